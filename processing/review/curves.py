"""Curves over the views: a method's errors, their bounds, evidence and seconds, and a writer that completes them."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TypeGuard

import numpy as np
import rerun as rr

from orbitscan.processing.results.estimates import PairEstimate, ViewErrors, ViewEstimate
from orbitscan.processing.results.records import TurntableDeviation
from orbitscan.processing.review import entities

ROUNDING = 1e-9  # smaller errors are those of the arithmetic: view {0} has no logarithm

Value = tuple[str, float | None]  # a curve's entity, and its value at a view
Numbers = Sequence[float] | np.ndarray
Style = tuple[entities.Color, str, float]  # colour, name, width


def error_values(method: str, errors: ViewErrors, root: str = entities.ERRORS_ROOT) -> Iterator[Value]:
    """The errors of a view, in metres and millimetres, and their logarithms (Rerun's axes are linear)."""
    for quantity in entities.ERRORS:
        yield f"/{root}/{quantity}/{method}", getattr(errors, entities.error_field(quantity))
    for quantity, (_, error) in entities.MM_ERRORS.items():
        value = getattr(errors, entities.error_field(error))
        yield f"/{root}/{quantity}/{method}", None if value is None else 1e3 * value
    for quantity, (_, error, factor) in entities.LOG_ERRORS.items():
        yield f"/{root}_log10/{quantity}/{method}", _log10(getattr(errors, entities.error_field(error)), factor)
    yield f"/{root}_log10/rotation_deg/{method}", _log10(errors.rotation_error_deg)  # drawn with its bound


def bound_values(method: str, estimate: ViewEstimate) -> Iterator[Value]:
    """Within what the errors of a view are with 95 % probability, in the same units, and the logarithms."""
    yield f"/bounds/center_m/{method}", estimate.center_bound_m
    for quantity, (_, _, field, factor) in entities.BOUNDS.items():
        value = getattr(estimate, field)
        yield f"/bounds/{quantity}/{method}", None if value is None else factor * value
        yield f"/bounds_log10/{quantity}/{method}", _log10(value, factor)


def evidence_values(method: str, pair: PairEstimate) -> Iterator[Value]:
    """What speaks for the pair that placed a view."""
    for quantity, value in asdict(pair.evidence).items():
        yield f"/evidence/{quantity}/{method}", value
    yield f"/evidence/confidence/{method}", pair.confidence


def turntable_values(method: str, deviation: TurntableDeviation) -> Iterator[Value]:
    """How a view departs from a perfect turn."""
    yield f"/turntable/slip_deg/{method}", deviation.slip_deg
    yield f"/turntable/wobble_deg/{method}", deviation.wobble_deg
    yield f"/turntable/shift_mm/{method}", 1e3 * deviation.shift_m


def timing_values(method: str, seconds: Mapping[str, float]) -> Iterator[Value]:
    """The seconds of each stage for a view, and their total."""
    for stage, value in seconds.items():
        yield f"/timing/{stage}/{method}", value
    yield f"/timing/total/{method}", sum(seconds.values())


class Curves:
    """Writes a value as soon as it is known, and the rest at the end; None and NaN are left out."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._views: defaultdict[str, set[int]] = defaultdict(set)  # curve -> the views it has
        self.styles: dict[str, Style] = {}  # of curves whose path does not tell it

    def add(self, view: int, values: Iterable[Value]) -> None:
        """Writes the values of a view, at the stream's current time."""
        for path, value in values:
            if _is_known(value):
                self._style(path)
                self._views[path].add(view)
                self._stream.log(path, rr.Scalars(value))

    def complete(self, values: Mapping[int, Iterable[Value]], stamps_ns: Mapping[int, int]) -> None:
        """Writes those of all views' values that are not written yet, a column per curve."""
        missing: defaultdict[str, dict[int, float]] = defaultdict(dict)
        for view, of_view in values.items():
            for path, value in of_view:
                if _is_known(value) and view not in self._views[path]:
                    missing[path][view] = value
        for path, curve in missing.items():
            self._style(path)
            self._views[path].update(curve)
            stamps = np.array([stamps_ns[view] for view in curve], dtype="datetime64[ns]")
            times = [
                rr.TimeColumn(entities.VIEW_TIMELINE, sequence=list(curve)),
                rr.TimeColumn(entities.STAMP_TIMELINE, timestamp=stamps),
            ]
            self._stream.send_columns(path, times, rr.Scalars.columns(scalars=list(curve.values())))

    def _style(self, path: str) -> None:
        if not self._views[path]:
            self._stream.log(path, draw_line(*(self.styles.get(path) or entities.curve_style(path))), static=True)


def log_curve(
    stream: rr.RecordingStream, path: str, style: Style, times: Sequence[rr.TimeColumn], values: Numbers
) -> None:
    """Writes a whole curve: how it looks, and its values at the times."""
    stream.log(path, draw_line(*style), static=True)
    stream.send_columns(path, times, rr.Scalars.columns(scalars=values))


def draw_line(color: entities.Color, name: str, width: float = 2.0) -> rr.SeriesLines:
    """How a curve looks."""
    return rr.SeriesLines(colors=[color], names=[name], widths=[width])


def _log10(value: float | None, factor: float = 1.0) -> float | None:
    return float(np.log10(factor * value)) if value is not None and value > ROUNDING else None


def _is_known(value: float | None) -> TypeGuard[float]:
    return value is not None and bool(np.isfinite(value))
