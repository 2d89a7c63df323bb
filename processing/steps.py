"""The steps of the page on one session: each with its settings, in metres, and timed under its name."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from orbitscan.processing.features.keypoints import detect_keypoints
from orbitscan.processing.features.shot import describe
from orbitscan.processing.reconstruction.joint_refinement import Register, refine_jointly
from orbitscan.processing.reconstruction.model import build_model
from orbitscan.processing.reconstruction.trajectory import Hints
from orbitscan.processing.registration import competition, icp
from orbitscan.processing.registration.ambiguity.self_turns import find_self_turns
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.ransac import Consensus, Matches, estimate_pose
from orbitscan.processing.results.estimates import MethodResult, PairEstimate
from orbitscan.processing.results.records import Model
from orbitscan.processing.results.status import Method
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import UNKNOWN_SCALE, Scale, prepare
from orbitscan.processing.timing import SESSION, Stopwatch
from orbitscan.recorder.session import SessionInfo, View, Views

_RANSAC = 4  # the thesis's number of the step that draws at random, part of its generator's seed


@dataclass(frozen=True, eq=False)
class Steps:
    """The steps on one session; without a scale, which no view had points enough for, none gets beyond `prepare`."""

    scale: Scale | None
    info: SessionInfo
    settings: Settings
    seed: int = 0
    watch: Stopwatch = field(default_factory=Stopwatch)

    def prepare(self, view: View) -> PreparedView:
        """A view's surface, without keypoints and descriptors."""
        with self.watch.shared("prepare"):
            origin, outline = self.info.sensor_origin, self.info.outline_known
            surface = prepare(view, self.scale, origin, self.settings.surface, outline)
        nothing = np.empty((0, 3)), np.empty((0, 0)), np.empty((0, 3, 3))
        return PreparedView(surface, *nothing, self.scale or UNKNOWN_SCALE, self.settings.pair.refinement)

    def detect_keypoints(self, view: PreparedView) -> np.ndarray:
        """Step 1: the ISS keypoints (K, 3) of its working points."""
        how, w, points = self.settings.keypoints, view.scale.working, view.surface.working
        with self.watch.shared("keypoints"):
            return points[detect_keypoints(points, w * how.salient_radius, w * how.non_max_radius, how)]

    def describe(self, view: PreparedView, keypoints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Step 2: SHOT descriptors (K, 352) and local reference frames (K, 3, 3) of the keypoints (K, 3)."""
        radius = view.scale.working * self.settings.shot.radius
        with self.watch.shared("descriptors"):
            return describe(view.surface.working, view.surface.normals, keypoints, radius)

    def find_self_turns(self, view: PreparedView) -> PreparedView:
        """Ours: the view with the turns under which it agrees with itself, where it has points enough."""
        with self.watch.shared("refine"):
            return replace(view, self_turns=find_self_turns(view, self.settings.pair)) if view.surface.enough else view

    def match(self, pair: PairRegistration) -> np.ndarray:
        """Step 3: index pairs (M, 2) of keypoints whose descriptors correspond."""
        with self.watch.shared("matching"):
            return match(pair.source.descriptors, pair.target.descriptors, self.settings.matching)

    def estimate_pose(self, pair: PairRegistration, indices: np.ndarray) -> Consensus | None:
        """Step 4: the pose that most of the matched keypoints (M, 2) agree on; None where too few do."""
        source, target, how = pair.source, pair.target, self.settings.ransac
        rng = np.random.default_rng((self.seed, _RANSAC, source.view, target.view))
        with self.watch.shared("ransac"):
            points = source.keypoints[indices[:, 0]], target.keypoints[indices[:, 1]]
            return estimate_pose(*points, pair.w * how.tolerance, how, rng)

    def register_icp(self, pair: PairRegistration, matches: Matches | None = None) -> PairEstimate:
        """Step 5: point-to-point ICP from the consensus of the matches; without them, from the identity."""
        with self.watch("icp", "icp" if matches is None else "ransac_icp"):
            return icp.register_icp(pair, matches)

    def register_competing(self, pair: PairRegistration, matches: Matches, hints: Hints) -> PairEstimate:
        """Ours, in the place of step 5: many starts compete, likely ones among them."""
        with self.watch.shared("refine"):
            return competition.register_competing(pair, matches, hints.starts, hints.only_ok)

    def refine_jointly(self, pairwise: MethodResult, cache: ViewCache, register: Register) -> MethodResult:
        """Ours: all views of a session refined together, more pairs of them registered."""

        def ask(source: PreparedView, target: PreparedView, hints: Hints) -> PairEstimate:
            return self.align(source, target, hints) if hints.alone else register(source, target, hints)

        with self.watch.alone("refine", "refined"):
            return refine_jointly(pairwise, cache, ask, self.settings.pair, self.settings.graph)

    def align(self, source: PreparedView, target: PreparedView, hints: Hints) -> PairEstimate:
        """Ours: a pair by the likely pose alone, which geometry judges."""
        ((name, start),) = hints.starts.items()
        with self.watch.shared("refine"):
            found = competition.register_near(PairRegistration(source, target, self.settings.pair), name, start)
            return competition.verify_usual(found, hints.usual, self.settings.pair)

    def build_model(
        self, views: Views, T: Mapping[int, np.ndarray], method: Method | None, *, meshed: bool = True
    ) -> Model | None:
        """The model of views that a method placed, T by view; with a mesh where one is wanted."""
        how = self.settings.model
        how = how if meshed else replace(how, mesh=replace(how.mesh, wanted=False))
        with self.watch("outlier_removal", SESSION):
            return build_model(views, T, method, self.scale, self.info.sensor_origin, how)
