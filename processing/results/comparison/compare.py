"""Two results of a recording, or of a batch: what changed, by how much, and whether that is more than chance.

An error of a view that both place with confidence changed where it did so by more than the floor: FLOOR standard
deviations of the difference of two estimates, each as well known as the views allow (`uncertainty`). So the floor comes
from the recording itself, in its own size and noise, and not from a tolerance that would be too wide for one and too
narrow for another: another seed moves poses by a fraction of it, and what exceeds it would not be turned round by
scanning again. Where both results tell within what their pose is right, the floor is no less than both bounds together.
Views that are not ok claim nothing about their pose: of them the status counts alone.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.results.classification import UNKNOWN, SessionClassification, ViewClassification
from orbitscan.processing.results.comparison.records import (
    VERDICTS,
    Category,
    Comparison,
    Difference,
    SessionComparison,
    Totals,
    Verdict,
    ViewComparison,
)
from orbitscan.processing.results.comparison.uncertainty import scale_of_errors, view_deviations
from orbitscan.processing.results.estimates import ViewEstimate
from orbitscan.processing.results.folder import ROUNDING, Extent, Results, ResultsFolder, read_results, to_json
from orbitscan.processing.results.status import METHODS, WRONG_DEG, WRONG_SHARE, Method, Status
from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption

FLOOR = 2.0  # standard deviations: chance alone exceeds them at most once in twenty times
SHOWN_SETTINGS = 5  # that differ


def compare_folders(a: Path, b: Path) -> Comparison:
    """B against A: two sessions, or two batches whose sessions are matched by name. Raises ScanError."""
    in_a, in_b = find_sessions(a), find_sessions(b)
    if in_a is None and in_b is None:
        return Comparison((compare_results(read_results(a), read_results(b)),))
    if in_a is None or in_b is None:
        session, batch = (a, b) if in_a is None else (b, a)
        remedy = f"name two of a kind, such as {batch / session.name}"
        raise InvalidOption(session, f"is one session, {batch} a batch", remedy)
    common = [name for name in in_a if name in in_b]
    if not common:
        raise InvalidOption(b, f"has no session of the name of one in {a}", "compare results of the same recordings")
    # By the folder's name: a recording's file may be called otherwise than what it holds.
    pairs = ((name, read_results(in_a[name]), read_results(in_b[name])) for name in common)
    sessions = [replace(compare_results(*both), name=name) for name, *both in pairs]
    sessions.sort(key=lambda s: (VERDICTS.index(s.verdict), -s.count(s.verdict), s.name))
    return Comparison(
        tuple(sessions),
        tuple(name for name in in_a if name not in in_b),
        tuple(name for name in in_b if name not in in_a),
    )


def find_sessions(folder: Path) -> dict[str, Path] | None:
    """The sessions of a batch's folder by name; None where the folder is a session's. Raises InvalidOption."""
    if (folder / "results.json").is_file():
        return None
    sessions = [path.parent for path in sorted(folder.glob("*/results.json")) if path.parent.suffix != ".part"]
    if not sessions:
        problem = "holds no results" if folder.is_dir() else "no such folder"
        raise InvalidOption(folder, problem, "name what 'orbitscan process -o' wrote: a session's folder or a batch's")
    return {session.name: session for session in sessions}


def compare_results(a: ResultsFolder, b: ResultsFolder) -> SessionComparison:
    """What changed from A to B. Raises InvalidOption where they have no view by no method in common."""
    of_a, of_b = a.results, b.results
    name = of_b.session.name
    methods = [m for m in METHODS if m in of_a.reconstruction and m in of_b.reconstruction]
    totals = {method: _total(method, a, b) for method in methods}
    if _content(of_a) == _content(of_b):
        return SessionComparison(name, (), identical=True, methods=totals)
    views = [view for method in methods for view in _compare_method(method, a, b)]
    if not views:
        raise InvalidOption(b.path, f"has no view by a method that {a.path} has", "compare results with some")
    notes = tuple(describe_differences(of_a, of_b))
    return SessionComparison(name, notes, False, tuple(views), totals, *_compare_categories(of_a, of_b))


def _content(results: Results) -> dict[str, Any]:
    """The results but for what the recording's file was called."""
    content = to_json(results)
    return {**content, "input": {**content["input"], "name": None}}


def _compare_method(method: Method, a: ResultsFolder, b: ResultsFolder) -> list[ViewComparison]:
    both = (a.results, b.results)
    of_a, of_b = (results.reconstruction[method] for results in both)
    in_a = {view.view: view for view in of_a.views}
    sigma: dict[int, float] = {}
    extents = [folder.extent for folder in (a, b) if folder.extent]
    extent = max(extents, key=lambda e: (e.points, e.diameter), default=None)
    origin = a.results.origin
    if extent is not None and origin is not None and origin == b.results.origin:
        radii = [results.settings["surface"]["quadric_radius"] for results in both]
        scale = min(scale_of_errors(results, extent.lever, q) for results, q in zip(both, radii, strict=True))
        for found, q in zip((of_a, of_b), radii, strict=True):
            for view, deviation in view_deviations(found.pairs, origin, q).items():
                sigma[view] = min(sigma.get(view, math.inf), scale * deviation)
    views = [_compare_view(method, in_a[v.view], v, sigma, extent) for v in of_b.views if v.view in in_a]
    # A camera that stands elsewhere in another recording has not moved.
    same_recording = a.results.input.sha256 == b.results.input.sha256
    return views if same_recording else [_without_motion(view) for view in views]


def _compare_view(
    method: Method, a: ViewEstimate, b: ViewEstimate, sigma: Mapping[int, float], extent: Extent | None
) -> ViewComparison:
    errors: dict[str, Difference] = {}
    floor = moved_m = moved_deg = None
    verdict: Verdict = "same"
    size = 0.0
    if extent is not None and a.T_0_i is not None and b.T_0_i is not None and sigma:
        D = b.T_0_i @ poses.invert(a.T_0_i)
        moved_m = float(np.linalg.norm(poses.transform(D, extent.center[None])[0] - extent.center))
        moved_deg = float(np.degrees(poses.rotation_angle(D[:3, :3])))
        if a.status == b.status == Status.OK and b.view in sigma:
            floor = max(FLOOR * math.sqrt(2) * sigma[b.view], ROUNDING)
            turn = max(floor / extent.lever, math.radians(_add(a.rotation_bound_deg, b.rotation_bound_deg)))  # radians
            floor = max(floor, _add(a.center_bound_m, b.center_bound_m))
            floors = _floors(floor, turn, extent, [T[:3, 3] for T in (a.T_0_i, b.T_0_i)])
            both = {name: (getattr(a.errors, name), getattr(b.errors, name)) for name in floors}
            errors = {name: Difference(*pair, floors[name]) for name, pair in both.items() if None not in pair}
            size = max(moved_m / floor, math.radians(moved_deg) / turn)
    if a.status != b.status:
        standings = _standing(a, extent), _standing(b, extent)
        verdict = "changed" if standings[0] == standings[1] else ("worse" if standings[1] < standings[0] else "better")
        size = math.inf
    elif errors:
        found = {difference.verdict for difference in errors.values()}
        verdict = next(verdict for verdict in VERDICTS if verdict in found)
        size = max(difference.size for difference in errors.values())
    elif size > 1:  # without truth: how far apart, neither better nor worse
        verdict = "changed"
    return ViewComparison(method, b.view, a.status, b.status, errors, moved_m, moved_deg, floor, verdict, size)


def _add(bound_a: float | None, bound_b: float | None) -> float:
    """Two bounds together; 0 where one does not tell its own."""
    return 0.0 if bound_a is None or bound_b is None else bound_a + bound_b


def _without_motion(view: ViewComparison) -> ViewComparison:
    verdict = "same" if view.verdict == "changed" and view.status_a == view.status_b else view.verdict
    size = view.size if view.errors or verdict != "same" else 0.0
    return replace(view, moved_m=None, moved_deg=None, verdict=verdict, size=size)


def _floors(floor_m: float, turn: float, extent: Extent, places: Sequence[np.ndarray]) -> dict[str, float]:
    """The floor of each judged error, from those of the centre [m] and of a turn [rad].

    `places` (3,) are the view's own in frame {0}.
    """
    distance = min(float(np.linalg.norm(place - extent.center)) for place in places)  # alike in both directions
    return {
        "translation_error_m": math.hypot(floor_m, distance * turn),
        "rotation_error_chordal": 2 * math.sqrt(2) * math.sin(min(turn / 2, math.pi / 2)),
        "center_error_m": floor_m,
    }


def _standing(view: ViewEstimate, extent: Extent | None) -> int:
    """The worth of a status: an ok that is wrong is worth less than a failure that says so."""
    degrees, metres = view.errors.rotation_error_deg, view.errors.center_error_m
    wrong = degrees is not None and degrees > WRONG_DEG
    wrong |= metres is not None and extent is not None and metres > WRONG_SHARE * extent.diameter
    return -1 if view.status == Status.OK and wrong else view.status.rank


def _compare_categories(a: Results, b: Results) -> tuple[Category | None, dict[int, Category]]:
    """The category of the session, and those of single views that differ."""
    shown_a, shown_b = a.classification, b.classification
    if not (shown_a and shown_b):
        return None, {}
    truth = a.session.category if a.session.category == b.session.category else None
    known = truth if truth in {*shown_a.categories, *shown_b.categories} or truth is None else UNKNOWN
    by_view = {view.view: view for view in shown_a.views}
    pairs = {v.view: (by_view[v.view], v) for v in shown_b.views if v.view in by_view}
    found = {view: _compare_category(*pair, known) for view, pair in pairs.items()}
    return _compare_category(shown_a, shown_b, known), {view: pair for view, pair in found.items() if pair.a != pair.b}


def _compare_category(
    a: SessionClassification | ViewClassification, b: SessionClassification | ViewClassification, truth: str | None
) -> Category:
    """Right is better than unknown, unknown than wrong; without a truth a change is neither."""
    names = a.answer, b.answer
    if names[0] == names[1]:
        return Category(*names, "same")
    if truth is None:
        return Category(*names, "changed")
    worth = [2 if name == truth else int(name == UNKNOWN) for name in names]
    return Category(*names, "changed" if worth[0] == worth[1] else ("worse" if worth[1] < worth[0] else "better"))


def _total(method: Method, a: ResultsFolder, b: ResultsFolder) -> Totals:
    of = [{view.view: view for view in folder.results.reconstruction[method].views} for folder in (a, b)]
    common = [[views[view] for view in of[0].keys() & of[1].keys()] for views in of]
    failed = [sum(view.status != Status.OK for view in views) for views in common]
    errors = [[e for view in views if (e := view.errors.center_error_m) is not None] for views in common]
    seconds = [folder.seconds.get("methods", {}).get(method, {}).get("total") for folder in (a, b)]
    return Totals(
        (failed[0], failed[1]),
        (max(errors[0]), max(errors[1])) if all(errors) else None,
        (seconds[0], seconds[1]) if None not in seconds else None,
    )


def describe_differences(a: Results, b: Results) -> Iterator[str]:
    """What differs between two results besides what came out, a phrase each."""
    if a.session.name != b.session.name:
        yield f"session: {a.session.name} in A, {b.session.name} in B"
    if a.input.sha256 != b.input.sha256:
        yield "another recording: differences may be of the input; poses are compared by their errors alone"
    for name, value in b.key.items():
        if name not in ("input_sha256", "settings") and a.key.get(name) != value:
            label = "model" if name == "model_sha256" else name
            yield f"{label}: {_brief(a.key.get(name))} in A, {_brief(value)} in B"
    in_a, in_b = (dict(_flatten(results.key["settings"])) for results in (a, b))
    differing = [name for name in in_b | in_a if in_a.get(name) != in_b.get(name)]
    for name in differing[:SHOWN_SETTINGS]:
        yield f"settings: {name} = {_brief(in_a.get(name))} in A, {_brief(in_b.get(name))} in B"
    if len(differing) > SHOWN_SETTINGS:
        yield f"settings: {len(differing) - SHOWN_SETTINGS} more differ"
    if a.key == b.key:
        new = {name: version for name, version in b.versions.items() if a.versions.get(name) != version}
        libraries = [f"{name} {a.versions.get(name)} in A, {version} in B" for name, version in new.items()]
        yield "the same recording and settings, yet other results: " + ("; ".join(libraries) or "by the same libraries")
    for name, one, other in (("A", a.session, b.session), ("B", b.session, a.session)):
        if only := [view for view in one.views_used if view not in other.views_used]:
            yield f"views in {name} only: {', '.join(map(str, only))}"
    if a.origin != b.origin:
        yield f"frame {{0}} is view {a.origin} in A, view {b.origin} in B: poses and errors cannot be compared"
    if a.input.damage != b.input.damage:
        yield f"damage: {a.input.damage or 'none'} in A, {b.input.damage or 'none'} in B"


def _flatten(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _brief(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if isinstance(value, float):
        return f"{value:.6g}"
    return f"{value[:8]}..." if isinstance(value, str) and len(value) == 64 else str(value)
