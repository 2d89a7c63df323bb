"""A session's summary: what its best method places, what is wrong, what the object is, what turned it."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from orbitscan.processing.results.edges import left_out
from orbitscan.processing.results.estimates import MethodResult, ViewEstimate
from orbitscan.processing.results.records import Coverage, SessionResult, Turntable
from orbitscan.processing.results.status import Method, Status
from orbitscan.processing.review.ambiguity import (
    find_freedoms,
    find_symmetries,
    list_ambiguous,
    list_settled,
    tell_apart,
)
from orbitscan.processing.review.markdown import (
    describe_freedom,
    describe_symmetry,
    enumerate_some,
    enumerate_views,
    in_mm,
    name_gap,
    name_view,
    number,
    plural,
)
from orbitscan.processing.review.session.classification import describe_classification
from orbitscan.processing.review.session.findings import explain, write_clause
from orbitscan.processing.review.session.tables import tabulate_methods

SHOWN_FAILURES = 10
SHOWN_FREEDOMS = 3
SHOWN_GAPS = 3
LEGEND = (
    "Move the time cursor to a view: the tab View tells its story, Matches draws its correspondences. "
    "Frusta: grey by the ground truth, coloured as estimated. Red: what fails (views, matches, outliers). "
    "Yellow: right but for a motion that nothing determines, whose axis is dashed."
)
GRAPH_LEGEND = "Lines between frusta are registered pairs: green, they hold the views; red, the others contradict them."


def write_unfinished(name: str) -> str:
    """What stands in place of the summary until the session is done, and for ever if the run is killed."""
    return f"## {name}\n\nNot finished: the views so far are complete, the summary and the model are still missing."


def conclude(result: SessionResult, method: Method) -> str:
    """One line: how many views a method places, which not and why, and how far off the worst one is."""
    views = result.reconstruction[method].views
    failed: defaultdict[str, list[int]] = defaultdict(list)
    for view in views:
        if view.status != Status.OK:
            failed[view.status].append(view.view)
    text = f"{method} places {sum(view.status == 'ok' for view in views)} of {len(views)} views with confidence"
    text += "".join(f"; {status}: {enumerate_views(of_status)}" for status, of_status in sorted(failed.items())) + "."
    if result.origin not in (None, *result.views_used[:1]):
        text += f" Frame {{0}} is that of view {result.origin}."
    if method == "refined" and len(views) > 2:
        text += " The loop is closed." if result.reconstruction[method].loop_closed else " No loop is closed."
    off = {v.view: v.errors.center_error_m for v in views if v.errors.center_error_m is not None}
    if off:
        worst = max(off, key=off.__getitem__)
        text += f" The object's centre is at most {in_mm(off[worst])} mm off the ground truth, in view {worst}."
    return text


def summarize(result: SessionResult, methods: Sequence[Method]) -> str:
    """The summary as Markdown; `methods` from worst to best."""
    best = methods[-1]
    found = result.reconstruction[best]
    lines = [f"## {result.info.name}", "", f"**{conclude(result, best)}**", "", *tabulate_methods(result, methods), ""]
    if failed := _worst_first(found):
        names = dict(zip(result.views_used, result.view_names, strict=True))
        lines += ["### What is wrong, worst first", ""]
        for estimate in failed[:SHOWN_FAILURES]:
            why = result.unreadable.get(estimate.view) or explain(estimate, found.speaking.get(estimate.view))
            lines.append(f"- **{name_view(estimate.view, names[estimate.view])}**: {why}")
        if len(failed) > SHOWN_FAILURES:
            lines.append(f"- and {len(failed) - SHOWN_FAILURES} more: see the log")
        lines.append("")
    if shown := describe_classification(result):
        lines += [shown, ""]
    if result.turntable is not None:
        lines += [describe_turntable(result.turntable), ""]
    if result.coverage is not None:
        lines += [describe_coverage(result.coverage, result.turntable is not None), ""]
    step_was_given = result.settings.get("pair", {}).get("step_deg") is not None
    for told in (describe_freedoms, describe_symmetries):
        if text := told(found, step_was_given):
            lines += [text, ""]
    for words, settled in list_settled(found).items():
        lines += [f"**By {words}:** {plural(len(settled), 'view')} {enumerate_views(settled)}.", ""]
    if apart := [write_clause(clause) for clause in tell_apart(found)]:
        lines += [*(f"- {clause}." for clause in apart), ""]
    if notes := _list_notes(found):
        lines += [*(f"- {note}" for note in notes), ""]
    if best == "refined" and (dropped := len(left_out(found))):
        lines += [f"{dropped} of {len(found.pairs)} pairs are left out of the graph: see the log.", ""]
    lines.append(f"{LEGEND} {GRAPH_LEGEND}" if best == "refined" else LEGEND)
    if model := result.model:
        lines.append(f"Model: {len(model.points):,} points by {model.method}, {len(model.removed):,} outliers removed.")
    if "total" in result.seconds:
        lines.append(f"Processing took {result.seconds['total']:.1f} s.")
    return "\n".join(lines)


def describe_turntable(turntable: Turntable) -> str:
    """A turntable's step, sense and axis in words, and the views that depart from it most."""
    up = -turntable.axis[1]  # a camera's y points down
    sense = "counterclockwise" if up > 0 else "clockwise"
    tilt = float(np.degrees(np.arccos(min(1.0, abs(up)))))
    slipped = max(turntable.deviations, key=lambda d: abs(d.slip_deg))
    wobbling = max(turntable.deviations, key=lambda d: d.wobble_deg)
    shifted = max(turntable.deviations, key=lambda d: d.shift_m)
    return (
        f"**Turntable:** {turntable.step_deg:.2f}° from view to view, the camera going {sense} seen from above; "
        f"the axis leans {tilt:.2f}° off the first view's upright. "
        f"At worst a view slips by {number(abs(slipped.slip_deg))}° (view {slipped.view}), "
        f"wobbles by {number(wobbling.wobble_deg)}° (view {wobbling.view}) "
        f"and shifts by {in_mm(shifted.shift_m)} mm (view {shifted.view})."
    )


def describe_coverage(coverage: Coverage, on_turntable: bool) -> str:
    """The azimuths that no view covers, the widest first, and what azimuths are."""
    shown = [name_gap(gap.start_deg, gap.end_deg) for gap in coverage.gaps[:SHOWN_GAPS]]
    more = len(coverage.gaps) - len(shown)
    if not shown:
        return f"**Covered all round:** neighbours stand at most {coverage.widest_deg:.0f}° apart."
    axis = "the turntable's axis" if on_turntable else "what the cameras call up"
    first = min(coverage.azimuths_deg, key=coverage.azimuths_deg.__getitem__)
    text = f"**Not covered:** {'; '.join(shown)}{f'; and {more} more such arcs' if more else ''}. "
    return text + f"Azimuths are about {axis}, counterclockwise seen from above, view {first} at 0°."


def describe_freedoms(found: MethodResult, step_was_given: bool) -> str:
    """Which motions nothing determines, in which views, and what helps; empty where all are determined."""
    free, in_first = find_freedoms(found)
    if not free:
        return ""
    text = f"**Cannot be told{_frame(in_first)}:** {enumerate_some([*map(describe_freedom, free)], SHOWN_FREEDOMS)}"
    text += f"{_name_views(list_ambiguous(found))}. "
    if any(freedom.kind == "turn" for freedom in free):
        text += "The object looks the same all round; "
        if step_was_given:
            text += "the step that was given does not fit these views. "
        else:
            text += "`orbitscan process --step-deg N` uses your knowledge of the turntable's step. "
    if any(freedom.kind == "shift" for freedom in free):
        text += "The surface slides along itself; views that see an edge or an end of it would tell. "
    return text + "All else about these views is determined."


def describe_symmetries(found: MethodResult, step_was_given: bool) -> str:
    """Which turns change nothing, in which views that leaves poses open, and what helps; empty where there are none."""
    symmetries, in_first = find_symmetries(found)
    if not symmetries:
        return ""
    ambiguous = list_ambiguous(found)
    text = f"**Symmetric{_frame(in_first)}:** {enumerate_some([*map(describe_symmetry, symmetries)], SHOWN_FREEDOMS)}"
    text += f"{_name_views(ambiguous)}."
    if ambiguous and not step_was_given:
        text += " `orbitscan process --step-deg N` uses your knowledge of the turntable's step."
    return text


def _list_notes(found: MethodResult) -> list[str]:
    """What else is to be said of views that are ok, those of one note together."""
    noted: defaultdict[str, list[int]] = defaultdict(list)
    for view in found.views:
        if view.status == Status.OK and view.note:
            noted[view.note].append(view.view)
    return [f"{plural(len(v), 'view')} {enumerate_views(v)}: {write_clause(note)}." for note, v in noted.items()]


def _frame(in_first: bool) -> str:
    return " in the first view's frame" if in_first else ""


def _name_views(views: Sequence[int]) -> str:
    return f" ({plural(len(views), 'view')} {enumerate_views(views)})" if views else ""


def _worst_first(found: MethodResult) -> list[ViewEstimate]:
    confidence = {view: pair.confidence for view, pair in found.speaking.items()}
    failed = [view for view in found.views if view.status != Status.OK]
    return sorted(failed, key=lambda v: (v.T_0_i is not None, confidence.get(v.view, 0.0), v.view))
