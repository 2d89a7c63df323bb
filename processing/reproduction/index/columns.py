"""A study's rows as the cells of a table: headings with units, numbers with as many digits as mean something."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from orbitscan.processing.reproduction.report import Row, Value

THESIS = "thesis_"  # begins the name of a column that holds the thesis's numbers
UNKNOWN = "–"
_UNITS = {"percent": "%", "deg": "°", "mm": "mm", "m": "m", "s": "s", "ms": "ms", "nats": "nats"}
_DIGITS = 4  # significant ones of a column's largest number
_FEWEST_DIGITS = 2  # of its smallest
_WIDEST_SPAN = 3  # powers of ten from smallest to largest, beyond which each number has digits of its own


@dataclass(frozen=True)
class Column:
    """A column of a table as it is shown."""

    name: str  # as in the rows
    heading: str
    cells: tuple[str, ...]
    is_number: bool
    is_thesis: bool


def lay_out_columns(rows: Sequence[Row]) -> list[Column]:
    """The columns of the rows, each of the thesis's beside ours, whose numbers have no fewer decimals than its."""
    names = list(rows[0]) if rows else []
    return [
        Column(
            name,
            name_column(name),
            tuple(write_value(row[name], decimals) for row in rows),
            any(is_number(row[name]) for row in rows),
            name.startswith(THESIS),
        )
        for name in sorted(names, key=lambda name: (names.index(_ours(name, names)), name.startswith(THESIS)))
        for decimals in [_choose_decimals(rows, name)]
    ]


def name_column(name: str) -> str:
    """A column's name as words: thesis_accuracy_percent -> 'accuracy [%], thesis'."""
    words = _plain(name).split("_")
    unit = _UNITS.get(words[-1]) if len(words) > 1 else None
    heading = " ".join(words[:-1]) + f" [{unit}]" if unit else " ".join(words)
    return f"{heading}, thesis" if name.startswith(THESIS) else heading


def is_number(value: object) -> bool:
    """Whether a value is a finite number; True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def write_value(value: Value, decimals: int | None = None) -> str:
    """A value as the text of a cell; a float has so many decimals, or three significant digits where they are None."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return UNKNOWN
    if isinstance(value, float):
        if decimals is None:
            decimals = 0 if value == 0 else max(0, 2 - math.floor(math.log10(abs(value))))
        return f"{value:,.{decimals}f}".replace("-", "−")
    return f"{value:,}".replace("-", "−") if isinstance(value, int) else value


def _ours(name: str, names: Sequence[str]) -> str:
    """The column that a thesis's one stands beside; itself where there is none."""
    return _plain(name) if _plain(name) in names else name


def _plain(name: str) -> str:
    return name.removeprefix(THESIS)


def _count_decimals(values: Sequence[Value]) -> int:
    """The most decimals that any of the numbers is given with; 92.4 has one, 175.0 none."""
    written = [repr(value).removesuffix(".0") for value in values if isinstance(value, float) and math.isfinite(value)]
    return max((len(number.partition(".")[2]) for number in written if "e" not in number), default=0)


def _choose_decimals(rows: Sequence[Row], name: str) -> int | None:
    """How many decimals a column's floats have; None where they are too far apart for one number of them."""
    given = _count_decimals([row.get(THESIS + _plain(name)) for row in rows])
    values = [row[name] for row in rows]
    sizes = [abs(value) for value in values if isinstance(value, float) and math.isfinite(value) and value]
    if name.startswith(THESIS) or not sizes:
        return given
    largest, smallest = math.floor(math.log10(max(sizes))), math.floor(math.log10(min(sizes)))
    if largest - smallest > _WIDEST_SPAN:
        return None
    return max(0, given, _DIGITS - 1 - largest, _FEWEST_DIGITS - 1 - smallest)
