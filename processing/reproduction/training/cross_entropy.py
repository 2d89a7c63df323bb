"""Table 5.2: categorical cross-entropy by its formula, and what the thesis's four numbers tell of its example.

The example's probabilities are not at hand. Those here are ours, chosen so that they give the thesis's sums.
"""

import numpy as np
import torch

from orbitscan.processing.classification.losses import classification_loss
from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row

PRINTED = (3.763991, 1.502131)  # thesis table 5.2: the sums of two classifiers
BY_FORMULA = (4.135, 1.650)  # [nats] what the thesis's formula, L = -sum t log y, gives
_PRINTED_DIGIT, _FORMULA_DIGIT = 1e-6, 1e-3  # the last of each
CLASSES = np.array([2, 1, 0])  # of our three samples
PROBABILITIES = {  # (samples, classes) by two classifiers; ours, not the thesis's
    "first": np.array([[0.3, 0.3, 0.4], [0.3, 0.4, 0.3], [0.1, 0.2, 0.7]]),
    "second": np.array([[0.1, 0.1, 0.8], [0.1, 0.8, 0.1], [0.3, 0.4, 0.3]]),
}
BASE = 3  # as many as there are classes: to this base a guess among them costs 1


def work_example(plan: Plan) -> Report:
    """Table 5.2: two classifiers that are right equally often, and the cross-entropy that tells them apart."""
    losses = {name: cross_entropies(given, CLASSES) for name, given in PROBABILITIES.items()}
    rows = [row for place, name in enumerate(losses) for row in _tabulate(name, losses[name], place)]
    sums = [float(values.sum()) for values in losses.values()]
    settings = {"classes": CLASSES.tolist(), "probabilities": {k: v.tolist() for k, v in PROBABILITIES.items()}}
    said = [*_compare(sums), *_explain(), _check(sums)]
    return Report(
        "table-5.2", "An example of cross-entropy", rows, said, figures={"table-5.2": _draw(losses)}, settings=settings
    )


def cross_entropies(probabilities: np.ndarray, classes: np.ndarray) -> np.ndarray:
    """-log y of the true class of each sample (S,), in nats: the loss that networks are trained by, one at a time."""
    logits = torch.from_numpy(np.log(probabilities))
    rows = [classification_loss(logits[i : i + 1], classes[i : i + 1], open_set=False) for i in range(len(classes))]
    return torch.stack(rows).numpy()


def find_base(printed: tuple[float, ...], by_formula: tuple[float, ...]) -> tuple[float, float]:
    """Between which bases of the logarithm the formula's sums, in nats, are the printed ones but for rounding.

    The first is larger than the second where no base is right for all.
    """
    pairs = list(zip(printed, by_formula, strict=True))
    low = max((nats - _FORMULA_DIGIT / 2) / (found + _PRINTED_DIGIT / 2) for found, nats in pairs)
    high = min((nats + _FORMULA_DIGIT / 2) / (found - _PRINTED_DIGIT / 2) for found, nats in pairs)
    return float(np.exp(low)), float(np.exp(high))


def _tabulate(name: str, losses: np.ndarray, place: int) -> list[Row]:
    """A row for each sample and one for their sum."""
    given = PROBABILITIES[name]
    right = given.argmax(axis=1) == CLASSES
    samples = [
        (str(i + 1), " ".join(f"{p:.1f}" for p in given[i]), str(CLASSES[i] + 1), "yes" if right[i] else "no", loss)
        for i, loss in enumerate(losses.tolist())
    ]
    total = ("sum", None, None, f"{right.sum()} of {len(right)}", float(losses.sum()))
    return [
        {
            "classifier": name,
            "sample": sample,
            "probabilities": probabilities,
            "true_class": true,
            "right": hit,
            "cross_entropy_nats": loss,
            "thesis_by_formula_nats": BY_FORMULA[place] if sample == "sum" else None,
            f"to_base_{BASE}": loss / float(np.log(BASE)),
            "thesis_prints": PRINTED[place] if sample == "sum" else None,
        }
        for sample, probabilities, true, hit, loss in (*samples, total)
    ]


def _compare(sums: list[float]) -> list[str]:
    """What our example shows, in words."""
    first, second = (int((given.argmax(axis=1) == CLASSES).sum()) for given in PROBABILITIES.values())
    told = "cannot tell them apart" if first == second else "tells them apart too"
    return [
        "The probabilities of the thesis's example are not at hand: these are our own, chosen to give its sums.",
        f"Of {len(CLASSES)} samples the first classifier has {first} right, the second {second}: accuracy {told}. "
        f"Cross-entropy does: {sums[0]:.3f} and {sums[1]:.3f} nats.",
    ]


def _explain() -> list[str]:
    """What the thesis's four numbers say by themselves, in words."""
    ratios = [a / b for a, b in zip(PRINTED, BY_FORMULA, strict=True)]
    low, high = find_base(PRINTED, BY_FORMULA)
    said = f"The thesis prints {ratios[0]:.4f} and {ratios[1]:.4f} times what its formula gives"
    if low > high:
        return [f"{said}; that is more than rounding apart, so another base of the logarithm does not explain it."]
    products = [BASE**-printed for printed in PRINTED]
    return [
        f"{said}: but for rounding one factor, that of a logarithm to a base of {low:.4f} to {high:.4f} instead of e; "
        f"base {BASE} {'is' if low <= BASE <= high else 'is not'} among them.",
        f"To base {BASE} its printed sums are those of samples whose true classes' probabilities multiply to "
        f"{products[0]:.6f} and {products[1]:.6f}.",
    ]


def _check(sums: list[float]) -> str:
    """Whether our example gives the thesis's numbers, in words."""
    based = [value / float(np.log(BASE)) for value in sums]
    nats, printed = (
        np.allclose(found, thesis, rtol=0, atol=0.51 * digit)
        for found, thesis, digit in ((sums, BY_FORMULA, _FORMULA_DIGIT), (based, PRINTED, _PRINTED_DIGIT))
    )
    return (
        f"Our sums {'are' if nats else 'are not'} the thesis's by its formula; to base {BASE}, {based[0]:.6f} and "
        f"{based[1]:.6f}, they {'are' if printed else 'are not'} those it prints. Other probabilities may do the same."
    )


def _draw(losses: dict[str, np.ndarray]) -> charts.Figure:
    """A figure with a bar for each classifier, its samples one after the other, the thesis's sums on it."""
    figure, ((axes,),) = charts.new_figure(width=7, height=3.2)
    places = np.arange(len(losses))
    starts = np.zeros(len(losses))
    for i, values in enumerate(np.stack(list(losses.values()), axis=1)):
        axes.barh(places, values, 0.5, left=starts, label=f"sample {i + 1}", **charts.bar_style(i))
        for place, given in enumerate(PROBABILITIES.values()):
            text = "right" if given[i].argmax() == CLASSES[i] else "wrong"
            axes.text(starts[place] + values[place] / 2, place - 0.28, text, ha="center", va="bottom", fontsize=7)
        starts = starts + values
    mark = {"linestyle": "", "color": "black", "markeredgecolor": "white", "markeredgewidth": 0.8}
    axes.plot(BY_FORMULA, places, marker="*", markersize=13, label="thesis, by its formula", **mark)
    axes.plot(PRINTED, places, marker="X", markersize=9, label="thesis, as printed", **mark)
    axes.set_yticks(places, [f"{name} classifier" for name in losses])
    axes.set_ylim(len(losses) - 0.6, -0.6)
    axes.set_xlabel("cross-entropy, sum of the samples [nats]")
    axes.grid(visible=False, axis="y")
    axes.legend(loc="lower right")
    return figure
