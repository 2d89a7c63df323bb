"""A session's views as the page prepares them, for tests of the steps after."""

from dataclasses import replace

import numpy as np

from orbitscan.processing.pipeline import prepare_view
from orbitscan.processing.reconstruction.trajectory import Hints
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.prepared_view import Outlook
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.results.estimates import Evidence, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.settings import Settings
from orbitscan.processing.steps import Steps
from orbitscan.processing.surface.preparation import choose_scale
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
        """As a cache hands out a view."""
        return self.views[index]

    get_surface = get

    def get_outlook(self, index):
        """As a cache tells where a view looks."""
        view = self.views[index]
        return Outlook(view.middle, view.surface.sensor_origin, view.self_turns)

    def T(self, target, source):
        """The true T_target_source of two views."""
        return poses.invert(self.truth[target]) @ self.truth[source]

    def steps(self, sensor_origin=(0.0, 0.0, 0.0)):
        """The page's steps at the session's scale."""
        return Steps(self.scale, replace(self.session.info, sensor_origin=sensor_origin), SETTINGS)

    def prepare(self, view, sensor_origin=(0.0, 0.0, 0.0)):
        """A view's surface and its described keypoints."""
        return prepare_view(self.steps(sensor_origin), view)

    def pair(self, source, target, settings=SETTINGS.pair):
        """Two prepared views to be registered."""
        return PairRegistration(source, target, settings)

    def correspond(self, source, target):
        """The matches of two prepared views, and the pose most of them agree on."""
        pair = self.pair(source, target)
        indices = self.steps().match(pair)
        return Matches(indices, self.steps().estimate_pose(pair, indices))

    def register(self, source, target):
        """The pose of two prepared views of which nothing is known."""
        return self.steps().register_competing(self.pair(source, target), self.correspond(source, target), Hints())


def edge(source, target, T, center=None, **fields):
    """A pair that is right, as exact in each direction as in any other."""
    information = np.diag([1e4] * 3 + [1e6] * 3)
    given = {"information": information, "covariance": np.linalg.inv(information)}
    given["center"] = np.zeros(3) if center is None else center
    status, evidence = Status(fields.pop("status", "ok")), Evidence(misfit=0.8, overlap=0.8)
    return PairEstimate(source, target, T, status, 0.9, evidence, **(given | fields))


def degrees(T_a, T_b):
    """The angle between the rotations of two poses."""
    return float(np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3])))
