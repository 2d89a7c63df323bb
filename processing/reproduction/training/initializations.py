"""Table 5.4 and figures 5.1 and 5.2: four initialisations of the best structure, trained alike."""

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.training.run import (
    Runs,
    average,
    column,
    curves,
    run_trainings,
    tabulate_curves,
    tabulate_runs,
)

NAMES = {"glorot": "Glorot", "dcae": "DCAE", "kmeans-pca": "PCA", "kmeans-zca": "ZCA"}
THESIS = {  # accuracy [%] (table 5.3); loss, overfitting (table 5.4), of 20 runs
    "glorot": (92.67, 0.2825, 0.2105),
    "dcae": (93.33, 0.2221, 0.1272),
    "kmeans-pca": (94.14, 0.1984, 0.0835),
    "kmeans-zca": (92.95, 0.2713, 0.0905),
}
_SCORES = {  # of a run -> factor to the unit shown, what its axis says
    "accuracy": (100, "accuracy of the test views [%]"),
    "loss": (1, "loss of the test views [nats]"),
    "overfitting": (1, "overfitting: test - training loss [nats]"),
}


def run_all(plan: Plan) -> Runs:
    """The runs of each initialisation, in the order of the plan's seeds."""
    return run_trainings(plan, {init: {"init": init} for init in NAMES}, "Training from four initialisations")


def tabulate(plan: Plan) -> Report:
    """Table 5.4: mean accuracy, loss and overfitting of the test views."""
    runs = run_all(plan)
    rows: list[Row] = [
        {
            "initialisation": NAMES[init],
            "accuracy_percent": average(found, "accuracy", 100),
            "thesis_accuracy_percent": THESIS[init][0],
            "loss": average(found, "loss"),
            "thesis_loss": THESIS[init][1],
            "overfitting": average(found, "overfitting"),
            "thesis_overfitting": THESIS[init][2],
            "seconds": average(found, "seconds"),
        }
        for init, found in runs.items()
    ]
    figure, ((axes,),) = charts.new_figure(width=6)
    series = {
        "loss": [average(found, "loss") for found in runs.values()],
        "loss, thesis": [loss for _, loss, _ in THESIS.values()],
        "overfitting": [average(found, "overfitting") for found in runs.values()],
        "overfitting, thesis": [overfitting for *_, overfitting in THESIS.values()],
    }
    charts.draw_bars(axes, list(NAMES.values()), series, "mean of the runs [nats]")
    charts.legend_below(figure, axes)
    return Report("table-5.4", "Four initialisations", rows, claims=_claim(runs), figures={"table-5.4": figure})


def draw_boxes(plan: Plan) -> Report:
    """Figure 5.1: accuracy, loss and overfitting of every run."""
    runs = _run_named(plan)
    rows, figures = tabulate_runs(runs, "initialisation"), {"figure-5.1": draw_run_boxes(runs, width=9)}
    return Report("figure-5.1", "Four initialisations: the runs", rows, [_describe_spread(runs)], figures=figures)


def draw_curves(plan: Plan) -> Report:
    """Figure 5.2: accuracy, loss and overfitting while the networks are trained."""
    return report_curves("figure-5.2", "Four initialisations: the training", _run_named(plan), "initialisation")


def report_curves(name: str, title: str, runs: Runs, label: str) -> Report:
    """The report of a figure of the runs' curves, whose rows name them by a label."""
    rows, figures = tabulate_curves(runs, label), {name: draw_run_curves(runs)}
    return Report(name, title, rows, [_describe_starts(runs)], figures=figures)


def draw_run_boxes(runs: Runs, width: float) -> charts.Figure:
    """A figure of box plots of accuracy, loss and overfitting over the runs, by name."""
    figure, (row,) = charts.new_figure(1, 3, width=width)
    for axes, key in zip(row, ("accuracy", "loss", "overfitting"), strict=True):
        draw_score_boxes(axes, runs, key)
    return figure


def draw_score_boxes(axes: charts.Axes, runs: Runs, key: str, sideways: bool = False) -> None:
    """Box plots of one of the scores over the runs, by name."""
    factor, label = _SCORES[key]
    charts.draw_boxes(axes, {name: column(found, key, factor) for name, found in runs.items()}, label, sideways)


def draw_run_curves(runs: Runs) -> charts.Figure:
    """A figure of accuracy, loss and overfitting over the batches: mean and range of the runs, by name."""
    figure, (row,) = charts.new_figure(1, 3, width=9, height=3.4)
    steps = next(iter(runs.values()))[0]["curve"]["step"]
    losses, training = curves(runs, "validation_loss"), curves(runs, "train_loss")
    for axes, series, label in (
        (row[0], curves(runs, "validation_accuracy", 100), "accuracy of test views [%]"),
        (row[1], losses, "loss of test views [nats]"),
        (row[2], {name: losses[name] - training[name] for name in runs}, "overfitting [nats]"),
    ):
        charts.draw_curves(axes, steps, series, label, "batches trained on")
    charts.legend_below(figure, row[0])
    return figure


def _describe_starts(runs: Runs) -> str:
    """Which runs are ahead in the first half of the training, in words."""
    accuracy = curves(runs, "validation_accuracy", 100)
    half = {name: float(values[:, : values.shape[1] // 2].mean()) for name, values in accuracy.items()}
    ranked = sorted(half, key=lambda name: -half[name])
    said = ", ".join(f"{name} {half[name]:.1f} %" for name in ranked)
    return f"Mean accuracy over the first half of the training, best first: {said}."


def _run_named(plan: Plan) -> Runs:
    return {NAMES[init]: found for init, found in run_all(plan).items()}


def _claim(runs: Runs) -> list[Claim]:
    """The thesis's order as claims: each initialisation against Glorot's, and PCA against the others."""
    accuracy = {init: column(found, "accuracy", 100) for init, found in runs.items()}
    overfitting = {init: column(found, "overfitting") for init, found in runs.items()}
    claims = [
        compare(f"{NAMES[init]} is more accurate than Glorot", accuracy[init], accuracy["glorot"], "points")
        for init in ("kmeans-pca", "dcae", "kmeans-zca")
    ]
    claims += [
        compare(f"{NAMES[init]} has less overfitting than Glorot", overfitting["glorot"], overfitting[init], "nats")
        for init in ("kmeans-pca", "kmeans-zca", "dcae")
    ]
    claims += [
        compare(f"PCA is more accurate than {NAMES[other]}", accuracy["kmeans-pca"], accuracy[other], "points")
        for other in ("dcae", "kmeans-zca")
    ]
    return claims


def _describe_spread(runs: Runs) -> str:
    """How far apart single runs are, beside the means of the initialisations, in words."""
    spread = {name: np.ptp(column(found, "accuracy", 100)) for name, found in runs.items()}
    widest = max(spread, key=spread.__getitem__)
    means = [average(found, "accuracy", 100) for found in runs.values()]
    return (
        f"From run to run the accuracy differs by up to {spread[widest]:.1f} points ({widest}); "
        f"the means of the initialisations differ by {np.ptp(means):.1f} points."
    )
