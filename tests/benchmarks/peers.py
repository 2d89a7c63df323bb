"""The libraries that pip installs, as their own examples use them: what a user would get without orbitscan.

All get the working resolution w of the session, as orbitscan chooses it: the largest of point spacing, 2.5 times the
noise and 1/150 of the diameter. Each prepares a view once. A peer says nothing of whether its pose is right, so all it
returns counts as called ok.
"""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np
import open3d as o3d

from orbitscan.recorder import cloud, poses
from orbitscan.recorder.session import Session

OPEN3D = "Open3D FPFH+RANSAC+plane"
POSE_GRAPH = "Open3D pose graph"
KISS = "KISS-Matcher+GICP"
GICP = "small_gicp from identity"

_NEEDS = {KISS: ("kiss_matcher", "small_gicp"), GICP: ("small_gicp",)}  # libraries of the extra `bench`

registration = o3d.pipelines.registration


@dataclass(frozen=True)
class Sizes:
    """What a peer's radii are multiples of [m]."""

    resolution: float  # distance between points
    working: float  # w


@dataclass(frozen=True)
class Peer:
    """A library: how it prepares a view, and how it registers a source to a target."""

    prepare: Callable[[np.ndarray, Sizes], Any]
    register: Callable[[Any, Any, Sizes], np.ndarray]


@dataclass(frozen=True, eq=False)
class PeerRun:
    """A session by a peer."""

    pairs: Mapping[tuple[int, int], np.ndarray]  # (source, target) -> T_target_source
    poses: Mapping[int, np.ndarray]  # T_0_i
    seconds: Mapping[tuple[int, int], float]  # preparing the source and registering it
    stages: Mapping[str, float]  # seconds of the whole session


def available() -> tuple[str, ...]:
    """The peers that are installed; the pose graph comes after the pairs that it is made of."""
    return tuple(name for name in (OPEN3D, POSE_GRAPH, KISS, GICP) if not _lacking(name))


def missing() -> tuple[str, ...]:
    """A line for each peer that is not installed."""
    return tuple(f"{name}: not installed (pip install {' '.join(_lacking(name))})" for name in _NEEDS if _lacking(name))


def _lacking(name: str) -> list[str]:
    return [library.replace("_", "-") for library in _NEEDS.get(name, ()) if not find_spec(library)]


def run(names: Sequence[str], session: Session) -> dict[str, PeerRun]:
    """A session by each of these peers."""
    found = {}
    for name in names:
        if name != POSE_GRAPH:
            found[name], prepared = _successively(_PEERS[name], session)
            if name == OPEN3D and POSE_GRAPH in names:
                found[POSE_GRAPH] = _optimized(found[name], prepared, measure(session))
    return {name: found[name] for name in names}


def measure(session: Session) -> Sizes:
    """The sizes of a session, from its first view."""
    facts = cloud.measure(next(iter(session.views())).points)
    return Sizes(facts.resolution, max(facts.resolution, 2.5 * facts.noise, facts.diameter / 150))


def _successively(peer: Peer, session: Session) -> tuple[PeerRun, dict[int, Any]]:
    """Every view registered to the one before it, composed; and the prepared views."""
    sizes = measure(session)
    prepared, pairs, seconds = {}, {}, {}
    stages = {"prepare": 0.0, "register": 0.0}
    target = None
    for view in session.views():
        source, points = view.index, view.points.astype(np.float64)
        started = time.perf_counter()
        prepared[source] = peer.prepare(points, sizes)
        ready = time.perf_counter()
        stages["prepare"] += ready - started
        if target is not None:
            pairs[source, target] = peer.register(prepared[source], prepared[target], sizes)
            seconds[source, target] = time.perf_counter() - started
            stages["register"] += time.perf_counter() - ready
        target = source
    return PeerRun(pairs, _compose(list(prepared), pairs), seconds, stages), prepared


def _compose(views: Sequence[int], pairs: Mapping[tuple[int, int], np.ndarray]) -> dict[int, np.ndarray]:
    """T_0_i of every view."""
    composed = {views[0]: np.eye(4)}
    for target, source in pairwise(views):
        composed[source] = composed[target] @ pairs[source, target]
    return composed


# small_gicp: generalised ICP from the identity, all points, gate 5 w.


def _gicp_cloud(points: np.ndarray, sizes: Sizes) -> tuple[Any, Any]:
    import small_gicp

    return small_gicp.preprocess_points(points, sizes.resolution, num_neighbors=30, num_threads=_threads())


def _gicp(source: Any, target: Any, sizes: Sizes, start: np.ndarray | None = None) -> np.ndarray:
    import small_gicp

    return small_gicp.align(
        target[0],
        source[0],
        target[1],
        np.eye(4) if start is None else start,
        registration_type="GICP",
        max_correspondence_distance=5 * sizes.working,
        num_threads=_threads(),
        max_iterations=50,
        rotation_epsilon=1e-5,
        translation_epsilon=1e-3 * sizes.working,
    ).T_target_source


# KISS-Matcher: voxels of 2 w, all else its default. It refuses voxels below 5 mm, so it gets the points in units of
# which a voxel is 0.3, its default. It has no way to keep a prepared view. Then small_gicp.


def _kiss_cloud(points: np.ndarray, sizes: Sizes) -> tuple[np.ndarray, Any]:
    return (points * _kiss_unit(sizes)).astype(np.float32), _gicp_cloud(points, sizes)


def _kiss(source: Any, target: Any, sizes: Sizes) -> np.ndarray:
    import kiss_matcher

    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(voxel_size=0.3))
    found = matcher.estimate(source[0], target[0])
    start = poses.make(np.array(found.rotation), np.array(found.translation) / _kiss_unit(sizes))
    return _gicp(source[1], target[1], sizes, start)


def _kiss_unit(sizes: Sizes) -> float:
    return 0.3 / (2 * sizes.working)


# Open3D's tutorials: voxels of 1.5 w, normals, FPFH, RANSAC over feature matches, point-to-plane ICP on all points.


@dataclass(frozen=True, eq=False)
class _Open3DCloud:
    coarse: o3d.geometry.PointCloud
    features: Any
    fine: o3d.geometry.PointCloud


def _open3d_cloud(points: np.ndarray, sizes: Sizes) -> _Open3DCloud:
    w = sizes.working
    fine = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    fine.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(4 * w, 30))
    fine.orient_normals_towards_camera_location(np.zeros(3))
    coarse = fine.voxel_down_sample(1.5 * w)
    coarse.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(6 * w, 30))
    coarse.orient_normals_towards_camera_location(np.zeros(3))
    features = registration.compute_fpfh_feature(coarse, o3d.geometry.KDTreeSearchParamHybrid(15 * w, 100))
    return _Open3DCloud(coarse, features, fine)


def _open3d(source: _Open3DCloud, target: _Open3DCloud, sizes: Sizes) -> np.ndarray:
    o3d.utility.random.seed(0)
    gate = 2 * sizes.working
    coarse = registration.registration_ransac_based_on_feature_matching(
        source.coarse, target.coarse, source.features, target.features, True, gate,
        registration.TransformationEstimationPointToPoint(False), 3,
        [
            registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
            registration.CorrespondenceCheckerBasedOnDistance(gate),
        ],
        registration.RANSACConvergenceCriteria(100_000, 0.999),
    )  # fmt: skip
    return _plane(source, target, sizes, coarse.transformation)


def _plane(source: _Open3DCloud, target: _Open3DCloud, sizes: Sizes, start: np.ndarray) -> np.ndarray:
    """Point-to-plane ICP, gate 2 w and then w."""
    T = start
    for gate in (2 * sizes.working, sizes.working):
        T = registration.registration_icp(
            source.fine, target.fine, gate, T,
            registration.TransformationEstimationPointToPlane(),
            registration.ICPConvergenceCriteria(1e-7, 1e-7, 50),
        ).transformation  # fmt: skip
    return T


# Open3D's multiway registration: the pairs as certain edges, every view to its second next and the closing pairs as
# uncertain ones (registered anew where the views go round), then global optimisation.


def _optimized(odometry: PeerRun, prepared: Mapping[int, _Open3DCloud], sizes: Sizes) -> PeerRun:
    """The pose graph of a session whose successive pairs are registered."""
    started = time.perf_counter()
    gate = sizes.working
    views = list(prepared)
    graph = registration.PoseGraph()
    for view in views:
        graph.nodes.append(registration.PoseGraphNode(odometry.poses[view]))

    def connect(source: int, target: int, T: np.ndarray, uncertain: bool) -> None:
        information = registration.get_information_matrix_from_point_clouds(
            prepared[source].fine, prepared[target].fine, gate, T
        )
        ends = views.index(source), views.index(target)
        graph.edges.append(registration.PoseGraphEdge(*ends, T, information, uncertain))

    for (source, target), T in odometry.pairs.items():
        connect(source, target, T, False)
    for target, source in zip(views, views[2:], strict=False):
        start = poses.invert(odometry.poses[target]) @ odometry.poses[source]
        connect(source, target, _plane(prepared[source], prepared[target], sizes, start), True)
    if len(views) > 3:
        for source, target in ((views[-1], views[0]), (views[-2], views[0]), (views[-1], views[1])):
            connect(source, target, _open3d(prepared[source], prepared[target], sizes), True)
    registration.global_optimization(
        graph,
        registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(
            max_correspondence_distance=gate, edge_prune_threshold=0.25, reference_node=0
        ),
    )
    first = poses.invert(graph.nodes[0].pose)
    placed = {view: first @ node.pose for view, node in zip(views, graph.nodes, strict=True)}
    pairs = {(s, t): poses.invert(placed[t]) @ placed[s] for s, t in odometry.pairs}
    graph_seconds = time.perf_counter() - started
    seconds = {pair: lap + graph_seconds / len(pairs) for pair, lap in odometry.seconds.items()}
    return PeerRun(pairs, placed, seconds, {**odometry.stages, "graph": graph_seconds})


def _threads() -> int:
    return int(os.environ.get("OMP_NUM_THREADS") or os.cpu_count() or 1)


_PEERS = {OPEN3D: Peer(_open3d_cloud, _open3d), KISS: Peer(_kiss_cloud, _kiss), GICP: Peer(_gicp_cloud, _gicp)}
