"""A session's views as the page prepares them, for tests of the steps after."""

import numpy as np

from orbitscan.processing.pipeline import _Steps
from orbitscan.processing.results.records import METHODS, Evidence, PairEstimate
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface import choose_scale
from orbitscan.processing.timing import Stopwatch
from orbitscan.recorder import poses

SETTINGS = Settings()


class Scene:
    """The steps of the page on one session, and its prepared views."""

    def __init__(self, session):
        self.session = session
        self.scale = choose_scale(session.views(), SETTINGS.surface)
        self.steps = _Steps(self.scale, session.info, SETTINGS, METHODS, 0, Stopwatch())
        self.views = [self.steps.prepare(view) for view in session.views()]
        self.truth = session.truth()

    def get(self, index):
        """As a shelf hands out a view."""
        return self.views[index]

    get_surface = get

    def T(self, target, source):
        """The true T_target_source of two views."""
        return poses.invert(self.truth[target]) @ self.truth[source]


def edge(source, target, T, center=None, **fields):
    """A pair that is right, as exact in each direction as in any other."""
    given = {"information": np.diag([1e4] * 3 + [1e6] * 3), "center": np.zeros(3) if center is None else center}
    return PairEstimate(source, target, T, fields.pop("status", "ok"), 0.9, Evidence(misfit=0.8), **(given | fields))


def degrees(T_a, T_b):
    """The angle between the rotations of two poses."""
    return float(np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3])))
