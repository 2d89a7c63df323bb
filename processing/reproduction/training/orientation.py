"""Figures 5.3 to 5.5: the network with and without a second output for the side that is seen (3.2.4)."""

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report
from orbitscan.processing.reproduction.training import data
from orbitscan.processing.reproduction.training.initializations import draw_run_boxes, report_curves
from orbitscan.processing.reproduction.training.run import Runs, column, run_trainings, tabulate_runs
from orbitscan.recorder.exceptions import InvalidOption, Wording

EPOCHS = 3  # thesis 5.1
WITHOUT, WITH = "without orientation", "with orientation"


def run_all(plan: Plan) -> Runs:
    """The runs without and with the orientation head. Raises InvalidOption where no view's place on a turn is known."""
    if np.isnan(data.load(data.provide(plan)).turns).all():
        problem = "does not say where a turn ends, so the side that is seen is not known"
        whose = plan.dataset or "the virtual corpus"
        raise InvalidOption(whose, problem, Wording("leave {dataset} out for figures 5.3 to 5.5"))
    changes = {name: {"epochs": EPOCHS, "orientation": name == WITH} for name in (WITHOUT, WITH)}
    return run_trainings(plan, changes, "Training without and with the orientation")


def draw_boxes(plan: Plan) -> Report:
    """Figure 5.3: accuracy, loss and overfitting of every run."""
    runs = run_all(plan)
    figure = draw_run_boxes({name.replace(" ", "\n"): found for name, found in runs.items()}, width=8)
    rows, figures = tabulate_runs(runs, "network"), {"figure-5.3": figure}
    return Report("figure-5.3", "The orientation head: the runs", rows, claims=_claim(runs), figures=figures)


def draw_curves(plan: Plan) -> Report:
    """Figure 5.4: accuracy, loss and overfitting while the networks are trained."""
    return report_curves("figure-5.4", "The orientation head: the training", run_all(plan), "network")


def draw_confusions(plan: Plan) -> Report:
    """Figure 5.5: which categories the test views are taken for, all runs together."""
    runs = run_all(plan)
    names = data.load(data.provide(plan)).names
    counts = {name: np.sum([run["confusion"] for run in found], axis=0) for name, found in runs.items()}
    figure, (row,) = charts.new_figure(1, 2, width=10, height=5)
    for axes, (name, matrix) in zip(row, counts.items(), strict=True):
        charts.draw_matrix(axes, matrix, names)
        axes.set_title(f"{name} [% of the views]", fontsize=10)
    rows = [
        {"network": name, "category": names[i]} | {f"as_{other}": int(n) for other, n in zip(names, line, strict=True)}
        for name, matrix in counts.items()
        for i, line in enumerate(matrix)
    ]
    said = [_describe_confusion(name, matrix, names) for name, matrix in counts.items()]
    return Report("figure-5.5", "The orientation head: confusion", rows, said, figures={"figure-5.5": figure})


def _claim(runs: Runs) -> list[Claim]:
    """The claims that the second output (3.27) makes the first one more accurate, surer and less overfitted."""
    with_head, without = runs[WITH], runs[WITHOUT]
    claims = (
        ("With the orientation the category is told more accurately", "accuracy", 100.0, "points"),
        ("With the orientation the loss is smaller", "loss", -1.0, "nats"),
        ("With the orientation there is less overfitting", "overfitting", -1.0, "nats"),
    )
    return [
        compare(text, column(with_head, key, factor), column(without, key, factor), unit)
        for text, key, factor, unit in claims
    ]


def _describe_confusion(name: str, counts: np.ndarray, names: tuple[str, ...]) -> str:
    wrong = counts * ~np.eye(len(names), dtype=bool)
    row, column_ = np.unravel_index(wrong.argmax(), wrong.shape)
    share = 100 * wrong[row, column_] / max(counts[row].sum(), 1)
    confused = f"{names[row]} with {names[column_]}"
    return f"{name.capitalize()}: most often confused is {confused}, {share:.0f} % of its views."
