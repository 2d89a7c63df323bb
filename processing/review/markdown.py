"""Numbers, views, bounds and motions in words, and Markdown tables of them."""

from collections.abc import Sequence

import numpy as np

from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.processing.results.status import Method

ENUMERATED = 10  # views that a sentence names, at most
UNCHALLENGED = (Method.ICP, Method.RANSAC_ICP)  # as in the thesis: no other pose competes with the one they end at
UNCHALLENGED_WORDS = "† unchecked against other poses: what these methods call ok may be far off"


def number(value: float | None) -> str:
    """A number in three digits; what is below a millionth is rounding."""
    if value is None:
        return ""
    return "0" if abs(value) < 1e-6 else f"{value:.3g}"


def in_mm(metres: float | None) -> str:
    """Metres in millimetres."""
    return number(None if metres is None else 1e3 * metres)


def count(value: int | None) -> str:
    """A whole number with commas between thousands."""
    return "" if value is None else f"{value:,}"


def percent(share: float | None) -> str:
    """A share in percent."""
    return "" if share is None else f"{share:.0%}"


def count_not_ok(views: int | str, method: Method) -> str:
    """How many views of a method are not ok, with a dagger where ok says little."""
    return f"{views} †" if method in UNCHALLENGED else f"{views}"


def enumerate_some(words: Sequence[str], most: int = ENUMERATED) -> str:
    """The first words, and how many more there are."""
    more = len(words) - most
    return ", ".join(words[:most]) + (f" and {more} more" if more > 0 else "")


def enumerate_views(views: Sequence[int]) -> str:
    """The first of them, and how many more there are."""
    return enumerate_some([str(view) for view in views])


def plural(count: int, noun: str) -> str:
    """A noun as it stands after a number."""
    return noun if count == 1 else f"{noun}s"


def name_view(view: int, name: str) -> str:
    """`view 3`, with its name in the capture where that says more."""
    return f"view {view}" if name in ("", f"view_{view:03d}") else f"view {view} ({name})"


def describe_freedom(freedom: Freedom) -> str:
    """A motion with its axis, and where it is."""
    axis = _axis(freedom.axis)
    if freedom.kind == "shift":
        return f"a shift along {axis}"
    place = ", ".join(f"{x:.0f}" for x in (1e3 * freedom.point).round() + 0.0)
    return f"a turn about the axis {axis} through ({place}) mm"


def describe_symmetry(symmetry: Symmetry) -> str:
    """Turns that change nothing, with their axis."""
    turn = number(360 / symmetry.order)
    told = "has the same shape, but for its colours" if symmetry.told_by_color else "looks the same"
    return f"{symmetry.order}-fold about {_axis(symmetry.axis)}: turned by any multiple of {turn}° it {told}"


def describe_bounds(rotation_bound_deg: float, center_bound_m: float) -> str:
    """Within what a pose is right with 95 % probability."""
    return f"within {number(rotation_bound_deg)}° and {in_mm(center_bound_m)} mm (95 %)"


def name_gap(start_deg: float, end_deg: float) -> str:
    """`no view between 200° and 250°`: of a gap that may go past 360."""
    return f"no view between {start_deg:.0f}° and {(end_deg - 1e-6) % 360 + 1e-6:.0f}°"


def write_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a Markdown table; a column without any content is left out."""
    columns = [column for column in zip(header, *rows, strict=True) if any(column[1:])]
    title, *content = zip(*columns, strict=True)
    return ["| " + " | ".join(cells) + " |" for cells in (title, ["---"] * len(title), *content)]


def _axis(axis: np.ndarray) -> str:
    return f"({', '.join(f'{x:.2f}' for x in axis.round(2) + 0.0)})"
