"""Surface-to-surface ICP: from a start to the pose on which the surfaces agree."""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels.cholesky import solve
from orbitscan.processing.registration.correspondences import Target
from orbitscan.processing.registration.normal_equations import Problem, accumulate, motion, normal_equations
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses
from orbitscan.recorder.kernels import kernel, over_slices

_RIDGE = 1e-9  # of the trace: a motion that nothing determines stays at rest
_COARSE_RIDGE = 1e-6  # the same, where fewer surfels tell less


@dataclass(frozen=True)
class RefinementSettings:
    """Gates and deviations are multiples of the working resolution w; the thesis gives none of these.

    A gate is how far a corresponding surfel may be. An iteration ends at a step that moves no point by more than
    `still`, a share of the object's diameter.
    """

    # The thesis's point-to-point ICP, of all working points.
    icp_gate: float = 8.0
    icp_iterations: int = 100
    icp_still: float = 1e-5

    # While starts compete: a few surfels of either view.
    coarse_points: int = 800
    coarse_gate: float = 6.0
    coarse_deviation: float = 1.0  # a residual so large counts a quarter
    coarse_iterations: int = 15
    coarse_still: float = 2e-4

    # The winners: first the few surfels of the source among all of the target.
    middle_gate: float = 2.0
    middle_iterations: int = 10
    middle_still: float = 2e-4

    # Then all of both.
    fine_gate: float = 1.5
    fine_slide: float = 1.0  # surfels farther apart along the surface do not overlap
    fine_iterations: int = 12
    fine_still: float = 1e-5

    # For both.
    fine_deviation: float = 3.0  # a residual of so many standard deviations counts a quarter; not in w
    least_deviation: float = 0.03  # of a surfel, besides what its quadric says: what a quadric cannot follow

    judged_points: int = 4000  # surfels of either view by which a pose is judged


@dataclass(frozen=True, eq=False)
class Refined:
    """Where an iteration ended."""

    T_target_source: np.ndarray  # (4, 4), metres
    converged: bool
    information: np.ndarray | None = None  # (6, 6) of a turn [rad] about the centre, then a shift [m], in the target
    center: np.ndarray | None = None  # (3,) in the target


def align_coarsely(
    source: Surfels, target: Target, starts: np.ndarray, gate: float, deviation: float, iterations: int, still: float
) -> np.ndarray:
    """Return where surface-to-surface ICP of a few surfels takes each start T_target_source (B, 4, 4): (B, 4, 4).

    As `align`, but every residual has the same deviation [m], at which it counts a quarter. The gate is in metres; a
    step that moves the points by less than `still` [m] ends the iteration. A start without correspondences stays.
    """
    T = np.array(starts, dtype=np.float64)
    variances = np.full(len(source), deviation**2 / 2)
    target = target._replace(variances=np.full(len(target.variances), deviation**2 / 2))
    problem = Problem(source.points, source.normals, variances, target, gate, gate, 1.0)
    over_slices(_align_each, len(T), problem, iterations, still, _rms_radius(source.points), T)
    return T


def align(
    source: Surfels,
    coarse: Surfels,
    target: Target,
    start: np.ndarray,
    w: float,
    diameter: float,
    settings: RefinementSettings,
) -> Refined:
    """Align surfels with a target by surface-to-surface ICP from a start T_target_source; w and diameter in metres.

    Residuals are along the mean of both normals, in which two samplings of one curved surface agree to second order
    (Rusinkiewicz, A symmetric objective function for ICP, 2019). They are weighed by the inverse of both surfels'
    variances and robustly (Geman and McClure), so that creases and what is not in both views pull little. The first
    steps are made with the coarse surfels, which stand for the source's, the rest with all. A pose without
    correspondences stays where it is, without information.
    """
    stages = (
        (middle_problem(coarse, target, w, settings), settings.middle_iterations, settings.middle_still),
        (fine_problem(source, target, w, settings), settings.fine_iterations, settings.fine_still),
    )
    T, converged, A, center = start, False, None, None
    for problem, iterations, still in stages:
        middle = problem.points.mean(axis=0)[None]
        for _ in range(iterations):
            center = poses.transform(T, middle)[0]
            A, b = normal_equations(problem, T, center)
            step = solve_motion(A, b, center)
            if step is None:
                return Refined(T, False)
            T = step @ T
            moved = np.abs(step - np.eye(4))[:3]
            about = np.abs(poses.transform(step, center[None])[0] - center).max()
            converged = bool(moved[:, :3].max() * diameter + about < still * diameter)
            if converged:
                break
    return Refined(poses.make(poses.project_rotation(T[:3, :3]), T[:3, 3]), converged, A, center)


def middle_problem(surfels: Surfels, target: Target, w: float, settings: RefinementSettings) -> Problem:
    """The problem of the alignment's first steps; w in metres."""
    return _problem(surfels, target, settings.middle_gate * w, settings.middle_gate * w, w, settings)


def fine_problem(surfels: Surfels, target: Target, w: float, settings: RefinementSettings) -> Problem:
    """The problem of the alignment's last steps; w in metres."""
    return _problem(surfels, target, settings.fine_gate * w, settings.fine_slide * w, w, settings)


def _problem(
    surfels: Surfels, target: Target, gate: float, slide: float, w: float, settings: RefinementSettings
) -> Problem:
    least = (settings.least_deviation * w) ** 2
    target = target._replace(variances=target.variances + least)
    cutoff = settings.fine_deviation
    return Problem(surfels.points, surfels.normals, surfels.variances + least, target, gate, slide, cutoff**2)


def solve_motion(A: np.ndarray, b: np.ndarray, center: np.ndarray) -> np.ndarray | None:
    """Solve A x = -b for a turn and a shift about a centre: their motion (4, 4), None where it is undetermined."""
    x, A = -b, A + np.eye(6) * _RIDGE * np.trace(A)
    if not solve(A, x):
        return None
    return motion(x, center)


def _rms_radius(points: np.ndarray) -> float:
    """RMS distance of the points (N, 3) to their centroid [m]."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


@kernel
def _align_each(
    start: int, stop: int, problem: Problem, iterations: int, still: float, radius: float, T: np.ndarray
) -> None:
    """Overwrite each start T (B, 4, 4) by where the iteration ends; a start without correspondences stays."""
    for c in range(start, stop):
        _align_one(problem, iterations, still, radius, T[c])


@kernel
def _align_one(problem: Problem, iterations: int, still: float, radius: float, T: np.ndarray) -> None:
    """Overwrite one start T (4, 4) by where the iteration ends."""
    points = problem.points
    center, middle = np.empty(3), np.zeros(3)
    for i in range(len(points)):
        for k in range(3):
            middle[k] += points[i, k] / len(points)
    A, b = np.empty((6, 6)), np.empty(6)
    for _ in range(iterations):
        for k in range(3):
            center[k] = T[k, 0] * middle[0] + T[k, 1] * middle[1] + T[k, 2] * middle[2] + T[k, 3]
        for i in range(6):
            b[i] = 0.0
            for j in range(6):
                A[i, j] = 0.0
        accumulate(problem, T, center, (0, len(points)), A, b)
        trace = 0.0
        for i in range(6):
            trace += A[i, i]
            b[i] = -b[i]
        for i in range(6):
            A[i, i] += _COARSE_RIDGE * trace
        if trace <= 0.0 or not solve(A, b):
            return
        _move(T, b, center)
        turn = np.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) * radius
        if turn + np.sqrt(b[3] * b[3] + b[4] * b[4] + b[5] * b[5]) < still:
            return


@kernel
def _move(T: np.ndarray, x: np.ndarray, center: np.ndarray) -> None:
    """Overwrite T (4, 4) by the motion of x, a turn about the centre and a shift, after it (Rodrigues)."""
    angle = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    s = np.sin(angle) / angle if angle > 1e-12 else 1.0
    c = (1.0 - np.cos(angle)) / (angle * angle) if angle > 1e-12 else 0.5
    for column in range(4):
        p0, p1, p2 = T[0, column], T[1, column], T[2, column]
        if column == 3:
            p0, p1, p2 = p0 - center[0], p1 - center[1], p2 - center[2]
        q0, q1, q2 = x[1] * p2 - x[2] * p1, x[2] * p0 - x[0] * p2, x[0] * p1 - x[1] * p0
        r0, r1, r2 = x[1] * q2 - x[2] * q1, x[2] * q0 - x[0] * q2, x[0] * q1 - x[1] * q0
        T[0, column], T[1, column], T[2, column] = p0 + s * q0 + c * r0, p1 + s * q1 + c * r1, p2 + s * q2 + c * r2
        if column == 3:
            for k in range(3):
                T[k, column] += center[k] + x[3 + k]
