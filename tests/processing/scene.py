"""A session's views as the page prepares them, for tests of the steps after."""

import numpy as np

from orbitscan.processing.features.keypoints import detect_keypoints
from orbitscan.processing.features.shot import describe
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import Matches, register_competing
from orbitscan.processing.registration.prepared_view import Prepared
from orbitscan.processing.registration.ransac import estimate_pose
from orbitscan.processing.results.records import Evidence, PairEstimate
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import choose_scale, prepare
from orbitscan.recorder import poses

SETTINGS = Settings()


class Scene:
    """The prepared views of one session, and the steps that register them."""

    def __init__(self, session):
        self.session = session
        self.scale = choose_scale(session.views(), SETTINGS.surface)
        self.views = [self.prepare(view) for view in session.views()]
        self.truth = session.truth()

    def get(self, index):
        """As a shelf hands out a view."""
        return self.views[index]

    get_surface = get

    def T(self, target, source):
        """The true T_target_source of two views."""
        return poses.invert(self.truth[target]) @ self.truth[source]

    def prepare(self, view, sensor_origin=(0.0, 0.0, 0.0)):
        """A view's surface and its described keypoints."""
        surface = prepare(view, self.scale, sensor_origin, SETTINGS.surface)
        points, w = surface.working, self.scale.working
        radii = w * SETTINGS.keypoints.salient_radius, w * SETTINGS.keypoints.non_max_radius
        keypoints = points[detect_keypoints(points, *radii, SETTINGS.keypoints)[0]]
        descriptors, frames = describe(points, surface.normals, keypoints, w * SETTINGS.shot.radius)
        return Prepared(surface, keypoints, descriptors, frames, self.scale, SETTINGS.pair.refinement)

    def correspond(self, source, target):
        """The matches of two prepared views, and the pose most of them agree on."""
        indices = match(source.descriptors, target.descriptors, SETTINGS.matching)
        points, how = (source.keypoints[indices[:, 0]], target.keypoints[indices[:, 1]]), SETTINGS.ransac
        rng = np.random.default_rng((0, 4, source.view, target.view))
        return Matches(indices, estimate_pose(*points, self.scale.working * how.tolerance, how, rng))

    def register(self, source, target):
        """The pose of two prepared views of which nothing is known."""
        return register_competing(source, target, self.correspond(source, target), None, SETTINGS.pair)


def edge(source, target, T, center=None, **fields):
    """A pair that is right, as exact in each direction as in any other."""
    given = {"information": np.diag([1e4] * 3 + [1e6] * 3), "center": np.zeros(3) if center is None else center}
    return PairEstimate(source, target, T, fields.pop("status", "ok"), 0.9, Evidence(misfit=0.8), **(given | fields))


def degrees(T_a, T_b):
    """The angle between the rotations of two poses."""
    return float(np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3])))
