"""Table 5.1: seven structures of the network, trained alike."""

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.training.initializations import draw_score_boxes
from orbitscan.processing.reproduction.training.run import BEST, Runs, average, column, run_trainings

THESIS = {  # structure -> mean loss, mean accuracy [%], of 10 runs
    "C(16,3,2)-C(16,3)-P(2)-C(8,3)-P(2)-FC(10)": (0.2866, 89.36),
    "C(32,3,2)-C(16,3)-P(2)-C(16,3)-P(2)-FC(10)": (0.2926, 89.40),
    "C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(128)-FC(10)": (0.3083, 90.99),
    "C(32,3,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10)": (0.3365, 91.99),
    BEST: (0.2759, 92.21),
    "C(64,3,2)-C(32,3)-P(2)-C(32,3)-P(2)-FC(10)": (0.3880, 90.95),
    "C(64,3,2)-C(32,3)-P(2)-C(32,3)-P(2)-FC(256)-FC(10)": (0.3392, 91.12),
}


def compare_structures(plan: Plan) -> Report:
    """Table 5.1: mean loss, accuracy and overfitting of each structure on the test views."""
    changes = {structure: {"structure": structure} for structure in THESIS}
    runs = run_trainings(plan, changes, "Training seven structures")
    rows: list[Row] = [
        {
            "structure": structure,
            "loss": average(found, "loss"),
            "thesis_loss": THESIS[structure][0],
            "accuracy_percent": average(found, "accuracy", 100),
            "thesis_accuracy_percent": THESIS[structure][1],
            "overfitting": average(found, "overfitting"),
            "seconds": average(found, "seconds"),
        }
        for structure, found in runs.items()
    ]
    accuracy = {structure: column(found, "accuracy", 100) for structure, found in runs.items()}
    claims = [
        compare(f"{BEST} is more accurate than {other}", accuracy[BEST], accuracy[other], "points")
        for other in THESIS
        if other != BEST
    ]
    means = {structure: float(np.mean(values)) for structure, values in accuracy.items()}
    best = max(means, key=means.__getitem__)
    said = f"Most accurate on average here: {best}, {means[best]:.2f} %; in the thesis: {BEST}."
    return Report(
        "table-5.1",
        "Seven structures of the network",
        rows,
        said=[said],
        claims=claims,
        figures={"table-5.1": _draw(runs)},
        settings={"thesis": "10 runs of 2 epochs; training views of table 3.1"},
    )


def _draw(runs: Runs) -> charts.Figure:
    figure, ((accuracy, loss),) = charts.new_figure(1, 2, width=9, height=3.6)
    named = {structure.replace("-P(2)-", "-P(2)-\n", 1): found for structure, found in runs.items()}
    for axes, key in ((accuracy, "accuracy"), (loss, "loss")):
        draw_score_boxes(axes, named, key, sideways=True)
    losses, accuracies = zip(*(THESIS[structure] for structure in runs), strict=True)
    for axes, values in ((accuracy, accuracies), (loss, losses)):
        axes.plot(values, range(len(runs)), "k*", markersize=7, label="thesis")
    loss.set_yticklabels([])
    charts.legend_below(figure, accuracy)
    return figure
