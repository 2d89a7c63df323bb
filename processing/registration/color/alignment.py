"""Alignment by shape and colour together: along motions that shape leaves open, colours hold the views.

Residuals of colour are weighed as distances are, by their variances and robustly; what lamps may add is fitted anew at
every pose, and so pulls at nothing. (Of colour beside shape: Park, Zhou and Koltun, Colored point cloud registration
revisited, 2017.)
"""

from functools import partial

import numpy as np

from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.covariance import Rows
from orbitscan.processing.registration.normal_equations import Problem, normal_equations
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.registration.surface_icp import Refined, middle_problem, solve_motion
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.processing.surface.appearance import CHANNELS
from orbitscan.processing.surface.lighting import project, remove_light
from orbitscan.recorder import poses

_ITERATIONS = 12
_BESIDE = 0.16  # of the reach of 32 points, half the way to the next: a deviation of colours beside their surface
_COARSE_STILL, _STILL = 2e-4, 2e-5  # shares of the diameter: a smaller step ends the iteration


def approach_by_color(colors: ColorPair, start: np.ndarray) -> np.ndarray:
    """Align the coarse surfels of a pair by distances and colours from a start T_target_source (4, 4)."""
    pair = colors.pair
    middle = middle_problem(pair.source.coarse_surfels, pair.target.fine_target, pair.w, pair.settings.refinement)
    return _iterate(colors, middle, start, coarse=True).T_target_source


def align_by_color(colors: ColorPair, start: np.ndarray) -> Refined:
    """Align the judged surfels of a pair by distances and colours from a start T_target_source, a near one."""
    return _iterate(colors, colors.pair.problem, start, coarse=False)


def _iterate(colors: ColorPair, problem: Problem, T: np.ndarray, coarse: bool) -> Refined:
    diameter, points = colors.pair.diameter, problem.points.mean(axis=0)[None]
    still, converged, A, center = (_COARSE_STILL if coarse else _STILL) * diameter, False, None, None
    for _ in range(_ITERATIONS):
        center = poses.transform(T, points)[0]
        A, b = normal_equations(problem, T, center)
        told = linearize(colors, T, center, coarse)
        A, b = A + (told.rows * told.weights[:, None]).T @ told.rows, b + told.pull
        step = solve_motion(A, b, center)
        if step is None:
            return Refined(T, False)
        T = step @ T
        moved = np.abs(step - np.eye(4))[:3, :3].max() * diameter
        moved += np.abs(poses.transform(step, center[None])[0] - center).max()
        converged = bool(moved < still)
        if converged:
            break
    return Refined(poses.make(poses.project_rotation(T[:3, :3]), T[:3, 3]), converged, A, center)


def measure_uncertainty(colors: ColorPair, refined: Refined) -> Uncertainty | None:
    """Measure how well shape and colour together tell an aligned pose; None where the views hardly meet."""
    return colors.pair.measure_uncertainty(refined, partial(linearize, colors))


def linearize(colors: ColorPair, T: np.ndarray, center: np.ndarray, coarse: bool = False) -> Rows:
    """The residuals of colour under a pose T_target_source, and how they change with its motions about a centre (3,).

    What lamps may add is taken out of both. The residuals share what a camera adds that puts all colours a little
    beside the surface, always the same way as it sees it: to tell that from a motion they are not good enough.
    """
    compared = colors.compare(T, coarse)
    left, weights = remove_light(compared.residuals, compared.variances, compared.light)
    beside_by = _BESIDE * colors.pair.source.scale.patch
    turned = T[:3, :3] - np.eye(3)  # how the way the source's camera is off comes to lie against the target's
    turned = turned @ _across(colors.pair.source)
    rows = np.empty((len(left), CHANNELS, 9))
    for channel in range(CHANNELS):
        slope = compared.slopes[:, channel]
        change = np.hstack([np.cross(slope, compared.places - center), -slope, slope @ turned * beside_by])
        rows[:, channel] = change - project(compared.light, weights[:, channel], change)
    rows, beside = np.split(rows.reshape(-1, 9), [6], axis=1)
    return Rows(rows, weights.ravel(), left.ravel(), np.repeat(compared.places, CHANNELS, axis=0), beside)


def _across(view: PreparedView) -> np.ndarray:
    """The projection (3, 3) onto what lies across a sensor's line of sight; onto all if its place is unknown."""
    origin = view.surface.sensor_origin
    if origin is None:
        return np.eye(3)
    sight = view.middle - origin
    return np.eye(3) - np.outer(sight, sight) / max(float(sight @ sight), 1e-12)
