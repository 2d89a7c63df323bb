"""THE PAGE: the method of the thesis (chapter 4) and what we add to it, a named call for each step, in order.

Views come without poses, and ground truth never enters here: `errors.with_errors` adds errors to what this yields.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict

import numpy as np

from processing.features.keypoints import detect_keypoints
from processing.features.shot import describe
from processing.reconstruction.matching import match
from processing.reconstruction.model import build_model
from processing.reconstruction.pair import Prepared, register_competing, register_consensus, register_icp
from processing.reconstruction.ransac import Consensus, estimate_pose
from processing.reconstruction.trajectory import Placed, Trajectory
from processing.results.records import METHODS, Correspondences, PairEstimate, SessionResult, ViewRecord, ViewResult
from processing.settings import Settings
from processing.surface import Scale, Surface, choose_scale, prepare
from processing.timing import Stopwatch, total
from recorder.session import SessionInfo, Views

_USE_FEATURES = ("ransac_icp", "pairwise")
_RANSAC = 4  # the thesis's number of the step that draws at random, part of its generator's seed

Match = tuple[Correspondences, Consensus | None]


def process(
    views: Views, info: SessionInfo, settings: Settings | None = None, methods: Sequence[str] = METHODS, seed: int = 0
) -> Iterator[ViewResult | SessionResult]:
    """A ViewResult per view as soon as it is placed, then exactly one SessionResult.

    The same input, settings and seed give the same numbers to the last bit, whatever the number of threads.
    """
    started = time.perf_counter()
    settings = settings or Settings()
    scale = choose_scale(views, settings.surface)
    trajectories = {method: Trajectory(retries=method == "pairwise") for method in methods}
    sharing = [method for method in methods if method in _USE_FEATURES]
    records: list[ViewRecord] = []
    origin = None
    for view in views:
        watch = Stopwatch()
        with watch("prepare", *methods):
            surface = prepare(view, scale, info.sensor_origin, settings.surface)
        current = _describe(surface, scale, settings, watch, sharing)
        poses, pairs, found = {}, {}, {}
        for method, trajectory in trajectories.items():
            if not surface.enough:
                poses[method] = trajectory.skip(view.index, "unreadable" if view.damage else "too_few_points")
            elif trajectory.last is None:
                origin = view.index
                poses[method] = trajectory.start(current)
            else:
                pairs[method], target = _attach(method, current, trajectories, found, scale, settings, seed, watch)
                poses[method] = trajectory.extend(current, pairs[method], target)  # (4.17)
        correspondences = [matches for matches, _ in found.values()]
        result = ViewResult(
            view=view.index,
            name=view.name,
            stamp_ns=view.stamp_ns,
            points=surface.points,
            colors=surface.colors,
            keypoints=current.keypoints,
            correspondences=correspondences[-1] if correspondences else None,
            pairs=pairs,
            poses=poses,
            seconds=watch.seconds(),
            origin=origin,
            damage=view.damage,
        )
        records.append(ViewRecord.of(result))
        yield result
    merging = time.perf_counter()
    model = build_model(views, {method: t.poses() for method, t in trajectories.items()}, scale, settings.model)
    ended = time.perf_counter()
    yield SessionResult(
        info=info,
        views_used=tuple(record.view for record in records),
        view_names=tuple(record.name for record in records),
        stamps_ns=tuple(record.stamp_ns for record in records),
        origin=origin,
        reconstruction={method: t.result(origin) for method, t in trajectories.items()},
        model=model,
        seconds=total(records, methods, ended - merging, ended - started),
        settings=asdict(settings),
        seed=seed,
        centroids={record.view: record.centroid for record in records if record.centroid},
        unreadable={record.view: record.damage for record in records if record.damage},
    )


def _describe(surface: Surface, scale: Scale, settings: Settings, watch: Stopwatch, methods: Sequence[str]) -> Prepared:
    """Steps 1 and 2: ISS keypoints and their SHOT descriptors, for the methods that use them."""
    how = settings.pair.refinement
    if not (surface.enough and methods):
        return Prepared(surface, np.empty((0, 3)), np.empty((0, 0)), how)
    w = scale.working
    with watch("keypoints", *methods):
        radii = w * settings.keypoints.salient_radius, w * settings.keypoints.non_max_radius
        indices, _ = detect_keypoints(surface.working, *radii, settings.keypoints)
        keypoints = surface.working[indices]
    with watch("descriptors", *methods):
        descriptors, _ = describe(surface.working, surface.normals, keypoints, w * settings.shot.radius)
    return Prepared(surface, keypoints, descriptors, how)


def _attach(
    method: str,
    source: Prepared,
    trajectories: Mapping[str, Trajectory],
    found: dict[Prepared, Match],
    scale: Scale,
    settings: Settings,
    seed: int,
    watch: Stopwatch,
) -> tuple[PairEstimate, Placed]:
    """Steps 3 to 5: the view registered to the first of a method's targets that it fits, else to the likeliest."""
    attempts = []
    for target in trajectories[method].targets:
        if method in _USE_FEATURES and target.prepared not in found:
            users = [m for m, t in trajectories.items() if m in _USE_FEATURES and t.aims_at(target)]
            found[target.prepared] = _correspond(source, target.prepared, scale, settings, seed, watch, users)
        pair = _register(method, source, target.prepared, found.get(target.prepared), scale, settings, watch)
        attempts.append((pair, target))
        if pair.status == "ok":
            break
    return max(attempts, key=lambda attempt: (attempt[0].status == "ok", attempt[0].confidence))


def _correspond(
    source: Prepared,
    target: Prepared,
    scale: Scale,
    settings: Settings,
    seed: int,
    watch: Stopwatch,
    methods: Sequence[str],
) -> Match:
    """Steps 3 and 4: matched descriptors, and the pose most of them agree on."""
    with watch("matching", *methods):
        matches = match(source.descriptors, target.descriptors, settings.matching)
        source_points, target_points = source.keypoints[matches[:, 0]], target.keypoints[matches[:, 1]]
    pair = source.surface.view, target.surface.view
    with watch("ransac", *methods):
        rng = np.random.default_rng((seed, _RANSAC, *pair))
        tolerance = scale.working * settings.ransac.tolerance
        consensus = estimate_pose(source_points, target_points, tolerance, settings.ransac, rng)
    inlier = np.zeros(len(matches), bool) if consensus is None else consensus.inlier
    return Correspondences(*pair, source_points, target_points, inlier), consensus


def _register(
    method: str,
    source: Prepared,
    target: Prepared,
    found: Match | None,
    scale: Scale,
    settings: Settings,
    watch: Stopwatch,
) -> PairEstimate:
    """Step 5: the pose of a pair by one method."""
    if method == "icp":
        with watch("icp", method):
            return register_icp(source, target, scale, settings.pair)
    correspondences, consensus = found
    matches = len(correspondences.inlier)
    if method == "ransac_icp":
        with watch("icp", method):
            return register_consensus(source, target, matches, consensus, scale, settings.pair)
    with watch("refine", method):
        return register_competing(source, target, matches, consensus, scale, settings.pair)
