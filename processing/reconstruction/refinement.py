"""Iterative closest point: from a start to the pose on which the surfaces agree."""

from dataclasses import dataclass

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from processing.features.cholesky import solve
from processing.features.grid import Cells, Grid, build, rows_around
from processing.features.parallel import kernel, over_slices
from processing.reconstruction.ransac import fit
from processing.surface import Surfels
from recorder import poses

_CHUNKS = 16  # sums are made in so many parts, whatever the number of threads: the same bits on every machine
_FEW = 2000  # points for whose partners it is not worth to start threads
_NORMAL_COSINE = 0.5  # surfaces that face apart by more than 60 degrees are not partners


@dataclass(frozen=True)
class RefinementSettings:
    """Gates are multiples of the working resolution; the thesis gives none of these."""

    icp_gate: float = 8.0  # the thesis's point-to-point ICP
    icp_iterations: int = 100
    icp_still: float = 1e-5  # a step that moves no point by more than this share of the diameter ends the iteration
    coarse_points: int = 800  # of either view, while starts compete
    coarse_gate: float = 6.0
    coarse_iterations: int = 15
    coarse_deviation: float = 1.0  # residuals of this many w count half
    coarse_still: float = 2e-4  # a step that moves no point by more than this share of the diameter ends the iteration
    middle_gate: float = 2.0  # the winner: first with a few surfels among all of the other view ...
    middle_iterations: int = 10
    judged_points: int = 4000  # of either view, when the winner is judged
    fine_gate: float = 1.5  # ... then with all
    fine_slide: float = 1.0  # partners farther apart along the surface do not overlap
    fine_iterations: int = 12
    fine_deviation: float = 3.0  # residuals of this many standard deviations count a quarter
    least_variance: float = 0.03  # (multiples of w)^2 added to each surfel's: what a quadric cannot follow
    middle_still: float = 2e-4
    fine_still: float = 1e-5  # a step that moves no point by more than this share of the diameter ends the iteration


@dataclass(frozen=True, eq=False)
class Target:
    """Surfels in the cells of a grid, to find partners among."""

    grid: Grid  # holds the points
    normals: np.ndarray  # (S, 3), in the grid's order
    variances: np.ndarray  # (S,)


@dataclass(frozen=True, eq=False)
class Refined:
    """Where an iteration ended."""

    T_target_source: np.ndarray  # (4, 4), metres
    converged: bool
    information: np.ndarray | None = None  # (6, 6) of a turn [rad] about the centre, then a shift [m], in the target
    center: np.ndarray | None = None  # (3,) in the target


def make_target(surfels: Surfels, gate: float) -> Target:
    """The surfels in cells as large as the gate [m], the farthest a partner is looked for."""
    grid = build(surfels.points, gate)
    return Target(grid, np.ascontiguousarray(surfels.normals[grid.order]), surfels.variances[grid.order])


def icp(source: np.ndarray, target: cKDTree, start: np.ndarray, gate: float, iterations: int, still: float) -> Refined:
    """Point-to-point ICP (thesis 4.3) of points (N, 3) from a start T_target_source.

    Each point is paired with the nearest target point within the gate [m], the pose fitted to the pairs in closed form
    (4.8)-(4.22), until no step moves a point by more than `still` [m].
    """
    T = start
    for _ in range(iterations):
        moved = poses.transform(T, source)
        distance, nearest = target.query(moved, distance_upper_bound=gate, workers=get_num_threads())
        paired = np.isfinite(distance)
        if paired.sum() < 3:
            return Refined(T, False)
        step = fit(moved[None, paired], target.data[None, nearest[paired]])[0]
        T = step @ T
        if np.abs(poses.transform(step, moved) - moved).max() < still:
            return Refined(T, True)
    return Refined(T, False)


def align_coarsely(
    source: Surfels, target: Target, starts: np.ndarray, gate: float, deviation: float, iterations: int, still: float
) -> np.ndarray:
    """Where surface-to-surface ICP of a few surfels takes each start T_target_source: (B, 4, 4).

    See `align`; here every residual has the same deviation [m].
    """
    T = np.array(starts, dtype=np.float64)
    variances = np.full(len(source), deviation**2 / 2)
    others = np.full(len(target.variances), deviation**2 / 2)
    over_slices(
        _align_each, len(T), source.points, source.normals, variances, target.grid.points, target.normals, others,
        target.grid.cells, target.grid.low, target.grid.cell, gate, gate, 1.0, iterations, still, _reach(source), T,
    )  # fmt: skip
    return T


def align(
    source: Surfels,
    few: Surfels,
    target: Target,
    start: np.ndarray,
    w: float,
    diameter: float,
    settings: RefinementSettings,
) -> Refined:
    """Surface-to-surface ICP of surfels from a start T_target_source, at the working resolution w [m].

    Residuals are along the mean of both normals, in which two samplings of one curved surface agree to second order
    (Rusinkiewicz, A symmetric objective function for ICP, 2019). They are weighed by the inverse of both surfels'
    variances and robustly (Geman and McClure), so that creases and what is not in both views pull little. The first
    steps are made with a few of the source's surfels.
    """
    least = (settings.least_variance * w) ** 2
    stages = (
        (few, settings.middle_gate, settings.middle_gate, settings.middle_iterations, settings.middle_still),
        (source, settings.fine_gate, settings.fine_slide, settings.fine_iterations, settings.fine_still),
    )
    T, converged = start, False
    for surfels, gate, slide, iterations, still in stages:
        middle = surfels.points.mean(axis=0)[None]
        for _ in range(iterations):
            center = poses.transform(T, middle)[0]
            A, b = _normal_equations(surfels, target, least, T, center, gate * w, slide * w, settings)
            step = _motion(A, b, center)
            if step is None:
                return Refined(T, False)
            T = step @ T
            moved = np.abs(step - np.eye(4))[:3]
            about = np.abs(poses.transform(step, center[None])[0] - center).max()
            converged = bool(moved[:, :3].max() * diameter + about < still * diameter)
            if converged:
                break
    return Refined(poses.make(poses.project_rotation(T[:3, :3]), T[:3, 3]), converged, A, center)


def find_partners(points: np.ndarray, normals: np.ndarray, target: Target, gate: float) -> np.ndarray:
    """For points (N, 3) with normals in the target's frame, the position in the target's grid of each one's partner.

    The nearest surfel within the gate [m] that faces the same way; -1 where there is none. (N,) int.
    """
    grid = target.grid
    found = np.empty(len(points), np.int64)
    arguments = (points, normals, grid.points, target.normals, grid.cells, grid.low, grid.cell, gate, found)
    if len(points) < _FEW:
        _partners(0, len(points), *arguments)
    else:
        over_slices(_partners, len(points), *arguments)
    return found


def _normal_equations(
    source: Surfels,
    target: Target,
    least: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    settings: RefinementSettings,
) -> tuple[np.ndarray, np.ndarray]:
    """A (6, 6) and b (6,) of a small turn about the centre and a shift that bring the surfels together: A x = -b."""
    A, b = np.zeros((_CHUNKS, 6, 6)), np.zeros((_CHUNKS, 6))
    over_slices(
        _accumulate_chunks, _CHUNKS, source.points, source.normals, source.variances + least, target.grid.points,
        target.normals, target.variances + least, target.grid.cells, target.grid.low, target.grid.cell, T, center, gate,
        slide, settings.fine_deviation**2, A, b,
    )  # fmt: skip
    return A.sum(axis=0), b.sum(axis=0)


def _motion(A: np.ndarray, b: np.ndarray, center: np.ndarray) -> np.ndarray | None:
    """The motion about a centre that solves A x = -b for a turn and a shift; None where it is undetermined."""
    x, A = -b, A + np.eye(6) * 1e-9 * np.trace(A)
    if not solve(A, x):
        return None
    R = Rotation.from_rotvec(x[:3]).as_matrix()
    return poses.make(R, center + x[3:] - R @ center)


def _reach(surfels: Surfels) -> float:
    """Of the points from their mean, in root mean square [m]."""
    return float(np.sqrt(((surfels.points - surfels.points.mean(axis=0)) ** 2).sum(axis=1).mean()))


@kernel
def _accumulate_chunks(
    start: int,
    stop: int,
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    deviations: float,
    A: np.ndarray,
    b: np.ndarray,
) -> None:
    """Fill the normal equations of each chunk, A (chunks, 6, 6) and b (chunks, 6)."""
    n, chunks = len(points), len(A)
    for c in range(start, stop):
        _accumulate(
            points, normals, variances, partners, partner_normals, partner_variances, cells, low, cell, T, center, gate,
            slide, deviations, c * n // chunks, (c + 1) * n // chunks, A[c], b[c],
        )  # fmt: skip


@kernel
def _align_each(
    start: int,
    stop: int,
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    gate: float,
    slide: float,
    deviations: float,
    iterations: int,
    still: float,
    reach: float,
    T: np.ndarray,
) -> None:
    """Overwrite each start T (B, 4, 4) by where the iteration ends; a start that finds no partners stays."""
    for c in range(start, stop):
        _align_one(
            points, normals, variances, partners, partner_normals, partner_variances, cells, low, cell, gate, slide,
            deviations, iterations, still, reach, T[c],
        )  # fmt: skip


@kernel
def _align_one(
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    gate: float,
    slide: float,
    deviations: float,
    iterations: int,
    still: float,
    reach: float,
    T: np.ndarray,
) -> None:
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
        _accumulate(
            points, normals, variances, partners, partner_normals, partner_variances, cells, low, cell, T, center, gate,
            slide, deviations, 0, len(points), A, b,
        )  # fmt: skip
        trace = 0.0
        for i in range(6):
            trace += A[i, i]
            b[i] = -b[i]
        for i in range(6):
            A[i, i] += 1e-6 * trace
        if trace <= 0.0 or not solve(A, b):
            return
        _move(T, b, center)
        turn = np.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) * reach
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


@kernel
def _accumulate(
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    deviations: float,
    start: int,
    stop: int,
    A: np.ndarray,
    b: np.ndarray,
) -> None:
    """Add to A (6, 6) and b (6,) what the points from start to stop say of a turn about the centre and a shift."""
    rows = np.empty((9, 2), np.int64)
    p, normal, a = np.empty(3), np.empty(3), np.empty(6)
    for i in range(start, stop):
        for k in range(3):
            p[k] = T[k, 0] * points[i, 0] + T[k, 1] * points[i, 1] + T[k, 2] * points[i, 2] + T[k, 3]
            normal[k] = T[k, 0] * normals[i, 0] + T[k, 1] * normals[i, 1] + T[k, 2] * normals[i, 2]
        nearest = _partner(partners, partner_normals, cells, low, cell, p, normal, gate, rows)
        if nearest < 0:
            continue
        length, residual, squared = 0.0, 0.0, 0.0
        for k in range(3):
            normal[k] += partner_normals[nearest, k]
            length += normal[k] * normal[k]
        length = np.sqrt(length)
        for k in range(3):
            normal[k] /= length
            offset = p[k] - partners[nearest, k]
            residual += offset * normal[k]
            squared += offset * offset
        if squared - residual * residual > slide * slide:
            continue
        variance = variances[i] + partner_variances[nearest]
        weight = 1.0 / (1.0 + residual * residual / (deviations * variance))
        weight = weight * weight / variance
        x, y, z = p[0] - center[0], p[1] - center[1], p[2] - center[2]
        a[0], a[1], a[2] = y * normal[2] - z * normal[1], z * normal[0] - x * normal[2], x * normal[1] - y * normal[0]
        a[3], a[4], a[5] = normal[0], normal[1], normal[2]
        for k in range(6):
            b[k] += weight * a[k] * residual
            for m in range(6):
                A[k, m] += weight * a[k] * a[m]


@kernel
def _partner(
    partners: np.ndarray,
    partner_normals: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    p: np.ndarray,
    normal: np.ndarray,
    gate: float,
    rows: np.ndarray,
) -> int:
    """The nearest partner within the gate that faces as the point p (3,) does; -1 where there is none."""
    rows_around(cells, low, cell, p, rows)
    nearest, squared = -1, gate * gate
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = partners[j, 0] - p[0], partners[j, 1] - p[1], partners[j, 2] - p[2]
            far = x * x + y * y + z * z
            if far < squared:
                other = partner_normals[j]
                if normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2] > _NORMAL_COSINE:
                    nearest, squared = j, far
    return nearest


@kernel
def _partners(
    start: int,
    stop: int,
    points: np.ndarray,
    normals: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    gate: float,
    found: np.ndarray,
) -> None:
    rows = np.empty((9, 2), np.int64)
    for i in range(start, stop):
        found[i] = _partner(partners, partner_normals, cells, low, cell, points[i], normals[i], gate, rows)
