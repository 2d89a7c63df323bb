"""Results as Markdown tables: a session's methods, and its views."""

from collections.abc import Iterable, Sequence

import numpy as np

from orbitscan.processing.results.edges import count_edges
from orbitscan.processing.results.estimates import Evidence, MethodResult, PairEstimate
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.status import Method, Status
from orbitscan.processing.review.markdown import (
    UNCHALLENGED,
    UNCHALLENGED_WORDS,
    count,
    count_not_ok,
    in_mm,
    number,
    percent,
    write_table,
)
from orbitscan.processing.review.session.classification import describe_view
from orbitscan.processing.review.session.findings import observable_error


def tabulate_views(result: SessionResult, methods: Sequence[Method]) -> str:
    """A row per view as a Markdown table: status, category, errors, evidence by the best method, the others' status."""
    *lesser, best = methods
    pairs, edges = result.reconstruction[best].speaking, count_edges(result.reconstruction[best].pairs)
    statuses = {method: {v.view: v.status for v in result.reconstruction[method].views} for method in lesser}
    names = dict(zip(result.views_used, result.view_names, strict=True))
    shown = {view.view: describe_view(view) for view in result.classification.views} if result.classification else {}
    rows = []
    for estimate in result.reconstruction[best].views:
        errors, pair = estimate.errors, pairs.get(estimate.view)
        e = pair.evidence if pair else Evidence()
        rows.append(
            [
                f"{estimate.view}",
                estimate.status,
                shown.get(estimate.view, ""),
                in_mm(errors.translation_error_m),
                number(errors.rotation_error_chordal),
                in_mm(errors.center_error_m),
                number(estimate.rotation_bound_deg),
                in_mm(estimate.center_bound_m),
                number(pair.errors.rotation_error_deg if pair else None),
                number(observable_error(pair) if pair else None),
                count(edges[estimate.view] if best == "refined" else None),
                percent(e.overlap),
                in_mm(e.rmse_m),
                number(e.misfit),
                percent(e.violations),
                *(count(n) for n in (e.points or None, e.keypoints, e.valid_frames, e.matches, e.inliers)),
                *(statuses[method].get(estimate.view, "") for method in lesser),
                names[estimate.view],
            ]
        )
    header = ["view", "status", "shows", "translation [mm]", "chordal", "centre [mm]", "turn within [deg]"]
    header += ["centre within [mm]", "its pair [deg]", "observable [deg]", "pairs"]
    header += ["overlap", "residual [mm]", "misfit", "in front"]
    header += ["points", "keypoints", "frames", "matches", "inliers", *lesser, "name"]
    return "\n".join([f"Status, errors and evidence of {best}.", "", *write_table(header, rows)])


def tabulate_methods(result: SessionResult, methods: Sequence[Method]) -> list[str]:
    """A row per method as the lines of a Markdown table, the best first, and what its columns mean."""
    header = ["method", "not ok", "overlap", "residual [mm]", "translation [mm]", "chordal", "centre [mm]"]
    header += ["turn within [deg]", "centre within [mm]", "a pair [deg]", "observable [deg]"]
    rows = []
    for method in reversed(methods):
        found = result.reconstruction[method]
        largest = found.summary.get
        sound = [view for view in found.views if view.status == Status.OK and view.view != result.origin]
        turns = [view.rotation_bound_deg for view in sound if view.rotation_bound_deg is not None]
        shifts = [1e3 * view.center_bound_m for view in sound if view.center_bound_m is not None]
        rows.append(
            [
                method,
                count_not_ok(f"{found.failed_views} of {len(found.views)}", method),
                percent(_median(pair.evidence.overlap for pair in found.pairs)),
                in_mm(_median(pair.evidence.rmse_m for pair in found.pairs)),
                in_mm(largest("max_translation_error_m")),
                number(largest("max_rotation_error_chordal")),
                in_mm(largest("max_center_error_m")),
                _median_and_largest(turns),
                _median_and_largest(shifts),
                number(_largest(pair.errors.rotation_error_deg for pair in _believed(found))),
                number(_largest_observable(found)),
            ]
        )
    what = "Overlap and residual: medians; translation, chordal, centre, a pair: the largest error of the kind."
    if any(row[header.index("turn within [deg]")] for row in rows):
        what += " Within: the 95 % bounds of the ok views, median and largest."
    if any(row[-1] for row in rows):
        what += " Observable: with the motions granted that nothing determines."
    if any(method in UNCHALLENGED for method in methods):
        what += f" {UNCHALLENGED_WORDS}."
    return [*write_table(header, rows), "", what]


def _largest_observable(found: MethodResult) -> float | None:
    """The largest observable error of the pairs; None where no pair's differs from its raw error."""
    pairs = _believed(found)
    differ = any(observable_error(pair) is not None for pair in pairs)
    return _largest(pair.errors.rotation_error_deg_observable for pair in pairs) if differ else None


def _believed(found: MethodResult) -> list[PairEstimate]:
    """The pairs whose errors count: without those that say themselves that they are wrong."""
    return [pair for pair in found.pairs if pair.status.is_believed]


def _median_and_largest(values: Sequence[float]) -> str:
    return f"{number(float(np.median(values)))}, {number(max(values))}" if values else ""


def _largest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None
