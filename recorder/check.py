"""What would spoil the processing of a session, each finding with the settings of its conversion that mend it."""

import hashlib
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from orbitscan.recorder import cloud, poses
from orbitscan.recorder.alignment import Judgement, judge, right_handed_axes
from orbitscan.recorder.conversion import Conversion, recorded
from orbitscan.recorder.exceptions import InvalidPose, Values, Wording, as_keywords, spelled
from orbitscan.recorder.session import Session, SessionInfo, View, name_views

FEW_POINTS = 10
LINE, PLANE = 0.01, 0.01  # spread across over spread along, below which a cloud is no more than that
NOISE = 1.5  # a cloud no thicker than so many standard deviations of its noise is a plane
LARGE, FAR, LARGE_AND_FAR = 20.0, 50.0, 5.0  # [m] diameter; distance, with diameter: no scanned object is so
SMALL = 0.002  # [m] diameter: no scanned object is so small
INSIDE = 0.3  # a sensor nearer to the centroid than this share of the diameter stands within the object
USUAL_AXES = ("RDF", "RUB", "RFU", "FLU")  # cameras, graphics, the Washington data set, ROS bodies
FORWARD = 0.7  # cosine to the camera's axis, from which on a direction is in front of it
SAMPLE = 4000  # points of a view looked at

Severity = Literal["problem", "warning", "info"]


@dataclass(frozen=True)
class Finding:
    """Something about a session that its user should know."""

    severity: Severity  # a problem spoils the processing
    what: str
    remedy: str = ""

    def __str__(self) -> str:
        return self.spelled(as_keywords)

    def spelled(self, spell: Callable[[Values], str]) -> str:
        """The finding in a line, its remedy's settings written as `spell` does."""
        return f"{self.severity}: {self.what}" + (f"; {spelled(self.remedy, spell)}" if self.remedy else "")


@dataclass(frozen=True, eq=False)
class _Sight:
    """What a look at one view says; lengths in metres."""

    index: int
    damage: str | None
    recorded: int  # points
    points: int  # with finite coordinates
    digest: bytes  # of the finite points
    center: np.ndarray  # (3,)
    diameter: float
    shape: Literal["line", "plane", "body"]


def check(session: Session) -> list[Finding]:
    """The findings on a session, problems of its recording first, then of its views, its sizes and its poses."""
    sights = [_look(view) for view in session.views("all")]
    seen = [sight for sight in sights if sight.points >= FEW_POINTS]
    findings = [Finding("problem", f"{session.damage}", "record the session again")] if session.damage else []
    findings += _check_views(sights)
    if seen:
        findings += [*_check_sizes(session.info, seen), *_check_sensor(session.info, seen)]
    return findings + check_poses(session, _turned(session.info, seen))


def check_together(sessions: Sequence[Session]) -> list[Finding]:
    """The problems that a setting mends in sessions of one view each: axes and sizes are those of most of them."""
    if not sessions:
        return []

    def load(index: int) -> View:
        return replace(sessions[index].load(0), index=index)

    names = tuple(session.info.name for session in sessions)
    findings = check(Session(replace(sessions[0].info, views=len(names)), names, load))
    return [finding for finding in findings if finding.severity == "problem" and isinstance(finding.remedy, Wording)]


def check_poses(session: Session, axes: str | None = None) -> list[Finding]:
    """The findings on a session's true poses; `axes` are those the clouds should have been read with, where known."""
    try:
        known, judgement = len(session.truth()), judge(session)
    except InvalidPose as error:
        return [Finding("problem", f"{error.subject}: {error.problem}", error.remedy)]
    if session.info.has_estimates:
        return [Finding("info", f"its poses are {session.info.source_poses}: no errors will be told")]
    if not known:
        remedy = Wording("name their file with {poses} where they exist")
        return [Finding("info", "no true poses, so no errors will be told", remedy)]
    findings = []
    if known < session.info.views:
        findings.append(Finding("info", f"true poses of {known} of {session.info.views} views"))
    untested = Finding("info", "the poses cannot be tested: no two views with points are near enough to overlap")
    return [*findings, _pose_finding(judgement, session.info, axes) if judgement else untested]


def _look(view: View) -> _Sight:
    points, _ = cloud.finite(view.points)
    sample = points[:: max(1, -(-len(points) // SAMPLE))].astype(np.float64)
    diameter = 0.0
    shape: Literal["line", "plane", "body"] = "body"
    if len(sample) >= FEW_POINTS:
        diameter = float(np.linalg.norm(np.ptp(np.percentile(sample, [0.5, 99.5], axis=0), axis=0)))
        along, across, through = np.linalg.svd(sample - sample.mean(axis=0), compute_uv=False) / np.sqrt(len(sample))
        thin = through < 5 * PLANE * along  # worth the search for neighbours
        if across < LINE * along:
            shape = "line"
        elif thin and through < max(PLANE * along, NOISE * cloud.measure(points).noise):
            shape = "plane"
    return _Sight(
        index=view.index,
        damage=view.damage,
        recorded=len(view.points),
        points=len(points),
        digest=hashlib.sha256(points.tobytes()).digest(),
        center=sample.mean(axis=0) if len(sample) else np.zeros(3),
        diameter=diameter,
        shape=shape,
    )


def _check_views(sights: Sequence[_Sight]) -> list[Finding]:
    findings = []

    def find(severity: Severity, chosen: list[_Sight], what: str, remedy: str) -> None:
        if chosen:
            findings.append(Finding(severity, f"{name_views([sight.index for sight in chosen])}: {what}", remedy))

    whole = [sight for sight in sights if not sight.damage]
    few = f"fewer than {FEW_POINTS} points"
    find("problem", [s for s in sights if s.damage], "unreadable", "record the session again")
    find("problem", [s for s in whole if not s.recorded], "no points", "leave the view out")
    find("problem", [s for s in whole if s.recorded and not s.points], "all points are NaN", "leave the view out")
    find("info", [s for s in whole if 0 < s.points < s.recorded], "some points are NaN", "they are left out")
    find("problem", [s for s in whole if 0 < s.points < FEW_POINTS], few, "leave the view out")
    find("problem", [s for s in whole if s.shape == "line"], "the points lie on a line", "leave the view out")
    flat = "the points lie on a plane, along which no motion can be seen"
    find("problem", [s for s in whole if s.shape == "plane"], flat, "scan the object from where it shows relief")
    same: dict[bytes, list[_Sight]] = defaultdict(list)
    for sight in whole:
        same[sight.digest].append(sight)
    for twins in same.values():
        if len(twins) > 1 and twins[0].points:
            find("problem", twins, "identical clouds", "keep one of them")
    if len(sights) == 1:
        findings.append(Finding("warning", "one view only: there is nothing to register it with"))
    return findings


def _check_sizes(info: SessionInfo, seen: Sequence[_Sight]) -> list[Finding]:
    diameter = float(np.median([sight.diameter for sight in seen]))
    distance = float(np.median([np.linalg.norm(sight.center) for sight in seen]))
    size = f"the object measures {length(diameter)} at a distance of {length(distance)}"
    either = Wording("check {units} and {scale}")
    if diameter > LARGE or (distance > FAR and diameter > LARGE_AND_FAR):
        remedy = Wording("pass {units} if these are millimetres", units="mm") if info.source_units == "m" else either
        return [Finding("problem", size, remedy)]
    if 0 < diameter < SMALL:
        remedy = either if info.source_units == "m" else Wording("pass {units} if these are metres", units="m")
        return [Finding("problem", size, remedy)]
    return []


def _check_sensor(info: SessionInfo, seen: Sequence[_Sight]) -> list[Finding]:
    if info.sensor_origin is None:
        what = "unknown sensor origin: free-space tests are off and normals point away from the centroid"
        return [Finding("warning", what, Wording("give its x, y, z with {sensor_origin} if it is known"))]
    near = [np.linalg.norm(sight.center - info.sensor_origin) < INSIDE * sight.diameter for sight in seen]
    if np.mean(near) > 0.5:
        remedy = Wording("pass {sensor_origin}", sensor_origin="unknown")
        return [Finding("problem", "the sensor's origin lies within the object", remedy)]
    if axes := _turned(info, seen):
        return [Finding("problem", "the points do not lie in front of the camera", Wording("pass {axes}", axes=axes))]
    return []


def _turned(info: SessionInfo, seen: Sequence[_Sight]) -> str | None:
    """The axes under which the points would lie in front of the camera, where they clearly do not."""
    if info.sensor_origin != (0.0, 0.0, 0.0) or not seen:
        return None
    far = [sight.center for sight in seen if np.linalg.norm(sight.center) > sight.diameter]
    if len(far) <= len(seen) / 2:
        return None
    direction = np.mean([center / np.linalg.norm(center) for center in far], axis=0)
    given = recorded(info).axes
    in_source = poses.axes_to_rdf(given).T @ direction
    fitting = [axes for axes in (given, *USUAL_AXES) if (poses.axes_to_rdf(axes) @ in_source)[2] > FORWARD]
    return fitting[0] if fitting and fitting[0] != given else None


def _pose_finding(judgement: Judgement, info: SessionInfo, axes: str | None) -> Finding:
    given = judgement.given
    if judgement.better:
        first, *equal = (_with_axes(reading, given, axes).changes(given) for reading in judgement.better)
        what = f"poses: {length(judgement.residual)} as given, {length(judgement.better_residual)} "
        what += _describe(judgement.better[0], given)
        return Finding("problem", what, _advise(first, equal) if info.source in ("", "clouds") else "")
    if judgement.aligned:
        return Finding("info", f"poses align the views to {length(judgement.residual)}")
    what = f"poses align the views only to {length(judgement.residual)}"
    if judgement.apart:
        what += ", and no other reading of them does better"
        return Finding("problem", what, "check that they belong to these clouds")
    what += ", more than the clouds' resolution and noise explain"
    return Finding("warning", what, "errors mean no more than that")


def _advise(first: Values, equal: Sequence[Values]) -> Wording:
    """Which settings to change, and which others would do as well."""
    others: list[str | Values] = []
    for settings in equal:
        others += [" or " if others else " (", settings]
    return Wording.of("pass ", first, *others, *([" fits as well)"] if others else []))


def _with_axes(reading: Conversion, given: Conversion, axes: str | None) -> Conversion:
    """A reading of the poses that aligns the clouds as given, for clouds read with other axes."""
    if axes is None:
        return reading
    pose_axes = poses.axes_to_rdf(axes) @ poses.axes_to_rdf(given.axes).T @ poses.axes_to_rdf(reading.pose_axes)
    name = next(name for name in right_handed_axes() if np.array_equal(poses.axes_to_rdf(name), pose_axes))
    return replace(reading, axes=axes, pose_axes=name)


def _describe(reading: Conversion, given: Conversion) -> str:
    words = ["inverted"] if reading.poses_are != given.poses_are else []
    words += [f"with camera axes {reading.pose_axes}"] if reading.pose_axes != given.pose_axes else []
    words += [f"with poses in {reading.pose_units}"] if reading.pose_units != given.pose_units else []
    words += [f"with clouds in {reading.units}"] if reading.units != given.units else []
    return ", ".join(words)


def length(metres: float) -> str:
    """A length in words, two digits: `0.6 mm`, `27 mm`, `1.2 m`."""
    number, unit = (metres, "m") if metres >= 1 else (1000 * metres, "mm")
    return f"{number:.0f} {unit}" if number >= 10 else f"{number:.2g} {unit}"
