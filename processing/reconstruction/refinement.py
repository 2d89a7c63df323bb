"""Iterative closest point: from a start to the pose on which the surfaces agree."""

from dataclasses import dataclass

import numpy as np
import small_gicp
from numba import get_num_threads
from scipy.spatial import cKDTree

from processing.reconstruction.ransac import fit
from recorder import poses


@dataclass(frozen=True)
class RefinementSettings:
    """Gates are multiples of the working resolution; the thesis gives none of these."""

    icp_gate: float = 8.0  # the thesis's point-to-point ICP
    icp_iterations: int = 100
    icp_still: float = 1e-5  # a step that moves no point by more than this share of the diameter ends the iteration
    coarse_points: int = 1500  # of the source, while starts compete
    coarse_gate: float = 6.0
    coarse_iterations: int = 25
    coarse_still: float = 1e-4  # a step smaller than this (radians; metres) ends the iteration
    fine_gate: float = 3.0  # the winner, on all points
    fine_iterations: int = 30
    fine_still: float = 1e-5
    neighbours: int = 20  # of a point, for its covariance


@dataclass(frozen=True, eq=False)
class SearchableCloud:
    """Points with their local covariances and a search tree, as small_gicp wants them."""

    cloud: small_gicp.PointCloud
    tree: small_gicp.KdTree


@dataclass(frozen=True, eq=False)
class Refined:
    """Where an iteration ended."""

    T_target_source: np.ndarray  # (4, 4), metres
    converged: bool


def make_searchable(points: np.ndarray, neighbours: int) -> SearchableCloud:
    """The searchable cloud of points (N, 3), covariances from so many neighbours."""
    cloud = small_gicp.PointCloud(np.asarray(points, dtype=np.float64))
    tree = small_gicp.KdTree(cloud, num_threads=1)
    small_gicp.estimate_covariances(cloud, tree, num_neighbors=neighbours, num_threads=get_num_threads())
    return SearchableCloud(cloud, tree)


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


def generalized_icp(
    source: SearchableCloud, target: SearchableCloud, start: np.ndarray, gate: float, iterations: int, still: float
) -> Refined:
    """Plane-to-plane ICP (Segal 2009) from a start T_target_source, until a step is still.

    Partners lie within the gate [m]; they may slide along the surface, as two samplings of one surface do, so that
    nothing holds on to the start.
    """
    result = small_gicp.align(
        target.cloud,
        source.cloud,
        target.tree,
        init_T_target_source=start,
        registration_type="GICP",
        max_correspondence_distance=gate,
        num_threads=1,  # a sum over threads would depend on their number
        max_iterations=iterations,
        rotation_epsilon=still,
        translation_epsilon=still,
    )
    T = np.array(result.T_target_source)
    sound = bool(np.isfinite(T).all())
    return Refined(T if sound else start, sound and bool(result.converged))
