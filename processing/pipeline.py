"""THE PAGE: the method of the thesis (chapters 3 and 4) and what we add to it, a named call for each step, in order.

Views come without poses, and ground truth never enters here: `errors.with_errors` adds errors to what this yields.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orbitscan.processing.features.keypoints import detect_keypoints
from orbitscan.processing.features.shot import describe
from orbitscan.processing.reconstruction.coverage import measure_coverage
from orbitscan.processing.reconstruction.joint_refinement import refine_jointly
from orbitscan.processing.reconstruction.model import build_model
from orbitscan.processing.reconstruction.trajectory import Placed, Trajectory
from orbitscan.processing.reconstruction.turntable import fit_turntable
from orbitscan.processing.registration.competition import doubt
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import (
    Matches,
    last_correspondences,
    register_competing,
    register_consensus,
    register_icp,
)
from orbitscan.processing.registration.prepared_view import Prepared, Shelf
from orbitscan.processing.registration.ransac import estimate_pose
from orbitscan.processing.results.records import PairEstimate, SessionResult, ViewRecord, ViewResult
from orbitscan.processing.results.status import METHODS, Status, best_method
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import Scale, choose_scale, prepare
from orbitscan.processing.timing import SESSION, Stopwatch, total
from orbitscan.recorder.session import SessionInfo, View, Views

if TYPE_CHECKING:
    from orbitscan.processing.classification.classifier import Classifier

_STREAMED = ("icp", "ransac_icp", "pairwise")  # place a view when it comes; `refined` begins where `pairwise` ends
_USE_FEATURES = ("ransac_icp", "pairwise", "refined")
_RANSAC = 4  # the thesis's number of the step that draws at random, part of its generator's seed


def process(
    views: Views,
    info: SessionInfo,
    settings: Settings | None = None,
    methods: Sequence[str] = METHODS,
    seed: int = 0,
    classifier: "Classifier | None" = None,
) -> Iterator[ViewResult | SessionResult]:
    """A ViewResult per view as soon as it is classified and placed, then exactly one SessionResult.

    Without a classifier nothing is classified. The same input, settings and seed give the same numbers to the last
    bit, whatever the number of threads.
    """
    settings = settings or Settings()
    watch = Stopwatch()
    scale = choose_scale(views, settings.surface)
    steps = _Steps(scale, info, settings, tuple(methods), seed, watch)
    shelf = Shelf(views, steps.prepare, steps.prepare_surface, settings.surface.kept_views)
    streamed = [m for m in _STREAMED if m in methods or (m == "pairwise" and "refined" in methods)]
    trajectories = {method: Trajectory(retries=method == "pairwise") for method in streamed}
    records: list[ViewRecord] = []
    origin = None
    for view in views:
        with watch("classification", SESSION):
            shown = classifier.classify_view(view.index, view.points) if classifier else None  # (3.18) to (3.22)
        current = shelf.put(view)
        poses, pairs, found = {}, {}, {}
        for method, trajectory in trajectories.items():
            if not current.surface.enough:
                poses[method] = trajectory.skip(view.index, Status.UNREADABLE if view.damage else Status.TOO_FEW_POINTS)
            elif trajectory.last is None:
                origin = view.index
                poses[method] = trajectory.start(current)
            else:
                pairs[method], target = steps.attach(method, current, trajectory, found)
                poses[method] = trajectory.extend(current, pairs[method], target)  # (4.17)
        result = ViewResult(
            view=view.index,
            name=view.name,
            stamp_ns=view.stamp_ns,
            points=current.surface.points,
            colors=current.surface.colors,
            keypoints=current.keypoints,
            correspondences=last_correspondences(current, found),
            pairs=pairs,
            poses=poses,
            seconds=watch.lap(),
            origin=origin,
            damage=view.damage,
            classification=shown,
        )
        records.append(ViewRecord.of(result))
        yield result
    reconstruction = {method: trajectory.result(origin) for method, trajectory in trajectories.items()}
    if "refined" in methods:
        with watch("refine", "refined"):
            reconstruction["refined"] = refine_jointly(
                reconstruction["pairwise"], origin, shelf, steps.register_unguided, settings.pair, settings.graph
            )
    best = best_method(methods)
    placed = reconstruction[best].placed if best else {}
    with watch("outlier_removal", SESSION):
        model = build_model(views, placed, best, scale, info.sensor_origin, settings.model)
    turntable = fit_turntable(placed, settings.turntable)
    laps = [*(record.seconds for record in records), watch.lap()]
    yield SessionResult.of(
        records,
        info=info,
        origin=origin,
        classification=classifier.fuse([r.classification for r in records if r.classification]) if classifier else None,
        reconstruction={method: reconstruction[method] for method in METHODS if method in methods},
        model=model,
        turntable=turntable,
        coverage=measure_coverage(placed, info.sensor_origin, model, turntable, settings.coverage),
        seconds=total(laps, methods, watch.elapsed),
        settings=asdict(settings),
        seed=seed,
    )


@dataclass(frozen=True, eq=False)
class _Steps:
    """The steps of the method on one session: its scale and settings, and the watch that times them."""

    scale: Scale | None
    info: SessionInfo
    settings: Settings
    methods: tuple[str, ...]
    seed: int
    watch: Stopwatch

    def prepare_surface(self, view: View) -> Prepared:
        """A view's surface alone."""
        with self.watch("prepare", *self.methods):
            surface = prepare(view, self.scale, self.info.sensor_origin, self.settings.surface)
        nothing = np.empty((0, 3)), np.empty((0, 0)), np.empty((0, 3, 3))
        return Prepared(surface, *nothing, self.scale, self.settings.pair.refinement)

    def prepare(self, view: View) -> Prepared:
        """Steps 1 and 2: ISS keypoints of its surface and their SHOT descriptors too, for the methods that use them."""
        bare, how, users = self.prepare_surface(view), self.settings, self._users(_USE_FEATURES)
        if not (bare.surface.enough and users):
            return bare
        points, w = bare.surface.working, self.scale.working
        with self.watch("keypoints", *users):
            radii = w * how.keypoints.salient_radius, w * how.keypoints.non_max_radius
            keypoints = points[detect_keypoints(points, *radii, how.keypoints)[0]]
        with self.watch("descriptors", *users):
            descriptors, frames = describe(points, bare.surface.normals, keypoints, w * how.shot.radius)
        return replace(bare, keypoints=keypoints, descriptors=descriptors, frames=frames)

    def attach(
        self, method: str, source: Prepared, trajectory: Trajectory, found: dict[Prepared, Matches]
    ) -> tuple[PairEstimate, Placed]:
        """Steps 3 to 5: the view registered to the first of a method's targets that it fits, else to the likeliest."""
        attempts = []
        for target in trajectory.targets:
            pair = self.register(method, source, target.prepared, found, trajectory.step)
            pair = doubt(pair, trajectory.usual_misfit, self.settings.pair) if method == "pairwise" else pair
            attempts.append((pair, target))
            if pair.status == Status.OK:
                break
        order = {"ok": 2, "ambiguous": 1}
        return max(reversed(attempts), key=lambda attempt: (order.get(attempt[0].status, 0), attempt[0].confidence))

    def register(
        self, method: str, source: Prepared, target: Prepared, found: dict[Prepared, Matches], step: np.ndarray | None
    ) -> PairEstimate:
        """The pose of a pair by one method; `found` keeps the matches with a target for the method after it."""
        how = self.settings.pair
        if method == "icp":
            with self.watch("icp", method):
                return register_icp(source, target, how)
        if target not in found:
            found[target] = self.correspond(source, target)
        if method == "ransac_icp":
            with self.watch("icp", method):
                return register_consensus(source, target, found[target], how)
        with self.watch("refine", *self._users(("pairwise", "refined"))):
            return register_competing(source, target, found[target], step, how)

    def register_unguided(self, source: Prepared, target: Prepared) -> PairEstimate:
        """Any two views, for the joint refinement alone."""
        matches = self.correspond(source, target, ("refined",))
        return register_competing(source, target, matches, None, self.settings.pair)

    def correspond(self, source: Prepared, target: Prepared, methods: Sequence[str] = _USE_FEATURES) -> Matches:
        """Steps 3 and 4: matched descriptors, and the pose most of them agree on."""
        how, users = self.settings, self._users(methods)
        with self.watch("matching", *users):
            indices = match(source.descriptors, target.descriptors, how.matching)
        with self.watch("ransac", *users):
            points = source.keypoints[indices[:, 0]], target.keypoints[indices[:, 1]]
            rng = np.random.default_rng((self.seed, _RANSAC, source.view, target.view))
            consensus = estimate_pose(*points, self.scale.working * how.ransac.tolerance, how.ransac, rng)
        return Matches(indices, consensus)

    def _users(self, methods: Sequence[str]) -> list[str]:
        return [method for method in self.methods if method in methods]
