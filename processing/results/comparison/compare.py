"""Two results of a recording, or of a batch: what changed, by how much, and whether that is more than chance.

An error of a view that both place with confidence changed where it did so by more than the floor: FLOOR standard
deviations of the difference of two estimates, each as well known as the views allow (`uncertainty`). So the floor comes
from the recording itself, in its own size and noise, and not from a tolerance that would be too wide for one and too
narrow for another: another seed moves poses by a fraction of it, and what exceeds it would not be turned round by
scanning again. Views that are not ok claim nothing about their pose: of them the status counts alone.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.results.comparison.records import (
    VERDICTS,
    Category,
    Comparison,
    Difference,
    SessionComparison,
    Totals,
    ViewComparison,
)
from orbitscan.processing.results.comparison.run import (
    MAKE_AGAIN,
    Run,
    content,
    describe_differences,
    find_sessions,
    read_run,
    same_recording,
)
from orbitscan.processing.results.comparison.uncertainty import ROUNDING, Extent, scale_of_errors, view_deviations
from orbitscan.processing.results.records import METHODS
from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption, UnreadableRecording

FLOOR = 2.0  # standard deviations: chance alone exceeds them at most once in twenty times
WRONG_DEG, WRONG_SHARE = 5.0, 0.05  # of an ok view off the truth by more degrees, or this share of the diameter
JUDGED = ("translation_error_m", "rotation_error_chordal", "center_error_m")
_STANDING = {"ok": 3, "ambiguous": 2}  # any other status: 1; ok and wrong: 0


def compare_folders(a: Path, b: Path) -> Comparison:
    """B against A: two sessions, or two batches whose sessions are matched by name. Raises ScanError."""
    in_a, in_b = find_sessions(a), find_sessions(b)
    if in_a is None and in_b is None:
        return Comparison((_compare_paths(a, b),))
    if in_a is None or in_b is None:
        session, batch = (a, b) if in_a is None else (b, a)
        raise InvalidOption(
            session, f"is one session, {batch} a batch", f"name two of a kind, such as {batch / session.name}"
        )
    common = [name for name in in_a if name in in_b]
    if not common:
        raise InvalidOption(b, f"has no session of the name of one in {a}", "compare results of the same recordings")
    # By the folder's name: a recording's file may be called otherwise than what it holds.
    sessions = [replace(_compare_paths(in_a[name], in_b[name]), name=name) for name in common]
    sessions.sort(key=lambda s: (VERDICTS.index(s.verdict), -s.count(s.verdict), s.name))
    return Comparison(
        tuple(sessions),
        tuple(name for name in in_a if name not in in_b),
        tuple(name for name in in_b if name not in in_a),
    )


def _compare_paths(a: Path, b: Path) -> SessionComparison:
    run_a, run_b = read_run(a), read_run(b)
    try:
        return compare_runs(run_a, run_b)
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as error:
        problem = f"their results.json do not say what they should ({type(error).__name__}: {error})"
        raise UnreadableRecording(f"{a}, {b}", problem, MAKE_AGAIN) from None


def compare_runs(a: Run, b: Run) -> SessionComparison:
    """What changed from A to B. Raises InvalidOption where they have no view by no method in common."""
    name = b.results["session"]["name"]
    methods = [m for m in METHODS if m in a.results["reconstruction"] and m in b.results["reconstruction"]]
    totals = {method: _total(method, a, b) for method in methods}
    if content(a) == content(b):
        return SessionComparison(name, (), identical=True, methods=totals)
    views = [view for method in methods for view in _compare_method(method, a, b)]
    if not views:
        raise InvalidOption(b.folder, f"has no view by a method that {a.folder} has", "compare results with some")
    shown_a, shown_b = a.results["classification"], b.results["classification"]
    category, view_categories = None, {}
    if shown_a and shown_b:
        truths = {run.results["session"]["category"] for run in (a, b)}
        truth = truths.pop() if len(truths) == 1 else None
        known = truth if truth in {*shown_a["categories"], *shown_b["categories"]} or truth is None else "unknown"
        category = _compare_category(shown_a, shown_b, known)
        by_view = {view["view"]: view for view in shown_a["views"]}
        pairs = {v["view"]: (by_view[v["view"]], v) for v in shown_b["views"] if v["view"] in by_view}
        found = {view: _compare_category(*pair, known) for view, pair in pairs.items()}
        view_categories = {view: pair for view, pair in found.items() if pair.a != pair.b}
    return SessionComparison(
        name,
        tuple(describe_differences(a, b)),
        False,
        tuple(views),
        totals,
        category,
        view_categories,
    )


def _compare_method(method: str, a: Run, b: Run) -> list[ViewComparison]:
    of_a, of_b = (run.results["reconstruction"][method] for run in (a, b))
    in_a = {view["view"]: view for view in of_a["views"]}
    sigma: dict[int, float] = {}
    extent = max((run.extent for run in (a, b) if run.extent), key=lambda e: (e.points, e.diameter), default=None)
    if extent is not None and a.origin is not None and a.origin == b.origin:
        radii = [run.results["settings"]["surface"]["quadric_radius"] for run in (a, b)]
        scales = [scale_of_errors(run.results, extent.lever, q) for run, q in zip((a, b), radii, strict=True)]
        for of, q in zip((of_a, of_b), radii, strict=True):
            for view, deviation in view_deviations(of["pairs"], a.origin, q).items():
                sigma[view] = min(sigma.get(view, math.inf), min(scales) * deviation)
    found = [_compare_view(method, in_a[v["view"]], v, sigma, extent) for v in of_b["views"] if v["view"] in in_a]
    # A camera that stands elsewhere in another recording has not moved.
    return found if same_recording(a, b) else [_without_motion(view) for view in found]


def _compare_view(
    method: str, a: Mapping[str, Any], b: Mapping[str, Any], sigma: Mapping[int, float], extent: Extent | None
) -> ViewComparison:
    view, errors, floor = b["view"], {}, None
    moved_m = moved_deg = None
    if extent is not None and a["T_0_i"] is not None and b["T_0_i"] is not None and sigma:
        D = np.asarray(b["T_0_i"]) @ poses.invert(np.asarray(a["T_0_i"]))
        moved_m = float(np.linalg.norm(poses.transform(D, extent.center[None])[0] - extent.center))
        moved_deg = float(np.degrees(poses.rotation_angle(D[:3, :3])))
        if a["status"] == b["status"] == "ok" and view in sigma:
            floor = max(FLOOR * math.sqrt(2) * sigma[view], ROUNDING)
            floors = _floors(floor, extent, [np.asarray(v["T_0_i"])[:3, 3] for v in (a, b)])
            known = [name for name in JUDGED if a[name] is not None and b[name] is not None]
            errors = {name: Difference(a[name], b[name], floors[name]) for name in known}
    if a["status"] != b["status"]:
        standings = _standing(a, extent), _standing(b, extent)
        verdict = "changed" if standings[0] == standings[1] else ("worse" if standings[1] < standings[0] else "better")
        size = math.inf
    elif errors:
        found = {difference.verdict for difference in errors.values()}
        verdict = next((v for v in ("worse", "better") if v in found), "same")
        size = max(difference.size for difference in errors.values())
    else:  # without truth: how far apart, neither better nor worse
        size = max(moved_m, math.radians(moved_deg) * extent.lever) / floor if floor is not None else 0.0
        verdict = "changed" if size > 1 else "same"
    return ViewComparison(method, view, a["status"], b["status"], errors, moved_m, moved_deg, floor, verdict, size)


def _without_motion(view: ViewComparison) -> ViewComparison:
    verdict = "same" if view.verdict == "changed" and view.status_a == view.status_b else view.verdict
    size = view.size if view.errors or verdict != "same" else 0.0
    return replace(view, moved_m=None, moved_deg=None, verdict=verdict, size=size)


def _floors(floor_m: float, extent: Extent, places: Sequence[np.ndarray]) -> dict[str, float]:
    """The floor of each error, from that of the object's surface; `places` (3,) are the view's own in frame {0}."""
    turn = floor_m / extent.lever  # radians
    distance = min(float(np.linalg.norm(place - extent.center)) for place in places)  # alike in both directions
    return {
        "translation_error_m": math.hypot(floor_m, distance * turn),
        "rotation_error_chordal": 2 * math.sqrt(2) * math.sin(min(turn / 2, math.pi / 2)),
        "center_error_m": floor_m,
    }


def _standing(view: Mapping[str, Any], extent: Extent | None) -> int:
    """How much a status is worth: an ok that is wrong is worth less than a failure that says so."""
    degrees, metres = view["rotation_error_deg"], view["center_error_m"]
    wrong = degrees is not None and degrees > WRONG_DEG
    wrong |= metres is not None and extent is not None and metres > WRONG_SHARE * extent.diameter
    return 0 if view["status"] == "ok" and wrong else _STANDING.get(view["status"], 1)


def _compare_category(a: Mapping[str, Any], b: Mapping[str, Any], truth: str | None) -> Category:
    """Right is better than unknown, unknown than wrong; without a truth a change is neither."""
    names = [found["category"] if found["known"] else "unknown" for found in (a, b)]
    if names[0] == names[1]:
        return Category(*names, "same")
    if truth is None:
        return Category(*names, "changed")
    worth = [2 if name == truth else int(name == "unknown") for name in names]
    return Category(*names, "changed" if worth[0] == worth[1] else ("worse" if worth[1] < worth[0] else "better"))


def _total(method: str, a: Run, b: Run) -> Totals:
    of = [{view["view"]: view for view in run.results["reconstruction"][method]["views"]} for run in (a, b)]
    common = [[views[view] for view in of[0].keys() & of[1].keys()] for views in of]
    failed = [sum(view["status"] != "ok" for view in views) for views in common]
    errors = [[v["center_error_m"] for v in views if v["center_error_m"] is not None] for views in common]
    seconds = [run.seconds.get("methods", {}).get(method, {}).get("total") for run in (a, b)]
    return Totals(
        (failed[0], failed[1]),
        (max(errors[0]), max(errors[1])) if all(errors) else None,
        (seconds[0], seconds[1]) if None not in seconds else None,
    )
