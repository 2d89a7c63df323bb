"""Point-to-point ICP, the thesis's refinement (4.3)."""

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from orbitscan.processing.registration.ransac import fit
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.recorder import poses


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
