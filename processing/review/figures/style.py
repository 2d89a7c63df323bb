"""What the figures of a session and of a batch share: quantities, styles that black and white print keeps, files."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from orbitscan.processing.review.entities import METHOD_COLORS
from orbitscan.recorder.atomic import write_whole

FOLDER = "figures"  # in a results folder
ENDINGS = ("png", "svg")
ORDERS = 10.0  # a largest value over another, from which on an axis is logarithmic
MARKERS = {"icp": "s", "ransac_icp": "^", "pairwise": "D", "refined": "o"}
STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dddddd",
    "legend.frameon": False,
    "svg.hashsalt": "orbitscan",  # the same numbers give the same file
    "svg.fonttype": "none",
}
_DASHES = {"icp": "--", "ransac_icp": "-.", "pairwise": (0, (1, 1)), "refined": "-"}
# Equal curves show beneath each other: the solid line lies lowest, the broken ones on it, the wide one first.
_WIDTHS = {"icp": 2.8, "ransac_icp": 1.3, "pairwise": 1.5, "refined": 1.7}
_LAYERS = {"refined": 2.0, "icp": 2.1, "ransac_icp": 2.2, "pairwise": 2.3}


@dataclass(frozen=True)
class Quantity:
    """What a plot shows of each view: the name in results.json, its factor to the unit of the label."""

    name: str
    label: str
    factor: float = 1.0
    whole: bool = False  # from 0 to 1, never logarithmic


ERRORS = (
    Quantity("translation_error_m", "translation error [mm]", 1e3),
    Quantity("rotation_error_chordal", "rotation error,\nchordal [0 to 2.83]"),
    Quantity("center_error_m", "error of the object's\ncentre [mm]", 1e3),
)


def method_line(method: str, *, marked: bool) -> dict[str, Any]:
    """How a method's curve looks: its colour in every recording, and dashes and marks that tell it without."""
    return {
        "color": method_color(method),
        "linestyle": _DASHES[method],
        "linewidth": _WIDTHS[method],
        "zorder": _LAYERS[method],
        "marker": MARKERS[method] if marked else "",
        "markersize": 4,
    }


def method_color(method: str) -> tuple[float, ...]:
    """A method's colour, red, green and blue from 0 to 1."""
    return tuple(channel / 255 for channel in METHOD_COLORS[method])


def needs_logarithm(largest: Sequence[float]) -> bool:
    """Whether positive values differ so much that a linear axis would hide the small ones."""
    return len(largest) > 1 and max(largest) > ORDERS * min(largest)


def save(figure: Figure, path: Path) -> list[Path]:
    """Write the figure as `path` with each ending, every file whole or not at all. Raises UnwritableOutput."""
    paths = [path.with_name(f"{path.name}.{ending}") for ending in ENDINGS]
    for target in paths:
        write_whole(target, _render(figure, target.suffix[1:]))
    return paths


def _render(figure: Figure, ending: str) -> bytes:
    content = io.BytesIO()
    with rc_context(STYLE):
        figure.savefig(content, format=ending, metadata={"Date": None} if ending == "svg" else {"Software": None})
    return content.getvalue()
