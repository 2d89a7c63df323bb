"""Seconds per pair, from points to pose, side by side with peers in one run: `make bench-pair`.

Successive views of the virtual robot, 20 degrees apart, 1 mm noise, thinned to so many points a view. Medians over the
pairs; a machine's load moves all rows alike, so compare the rows.
"""

import argparse
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import open3d as o3d
import small_gicp

from processing.compilation import compile_kernels
from processing.errors import rotation_error_deg
from processing.pipeline import process
from processing.results.records import METHODS, PairEstimate, ViewResult
from recorder import cloud, poses
from recorder.session import Session, in_memory
from recorder.sources.virtual import simulate


def main() -> None:
    """Print a row for each of our methods and each peer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=15_000)
    parser.add_argument("--views", type=int, default=8)
    arguments = parser.parse_args()
    session = thin(simulate("robot"), arguments.points, arguments.views)
    compile_kernels()
    print(f"{'':28s}  s/pair  deg median     max   stages [ms]")
    for method in METHODS:
        measure_ours(session, method)
    for name, register in (("small_gicp from identity", gicp), ("Open3D FPFH RANSAC + plane", fpfh)):
        measure_peer(session, name, register)


def thin(session: Session, points: int, views: int) -> Session:
    """The first views of a session with at most so many points each."""
    rng = np.random.default_rng(0)
    kept = []
    for view in session.views(f"0:{views}"):
        chosen = np.sort(rng.permutation(len(view.points))[:points])
        kept.append(type(view)(view.index, view.name, view.stamp_ns, view.points[chosen]))
    return in_memory(session.info, kept, session.truth())


def measure_ours(session: Session, method: str) -> None:
    """A row for one of our methods; a pair costs what its source view costs: each view is prepared once."""
    results = [r for r in process(session.views(), session.info, methods=[method]) if isinstance(r, ViewResult)][1:]
    laps = [sum(result.seconds[method].values()) for result in results]
    pairs: list[PairEstimate] = [result.pairs[method] for result in results]
    stages = {s: np.median([r.seconds[method].get(s, 0) for r in results]) * 1e3 for s in results[0].seconds[method]}
    report(method, laps, [error(session, p.source, p.target, p.T_target_source) for p in pairs], stages)


def measure_peer(session: Session, name: str, register: Callable[[np.ndarray, np.ndarray, float], np.ndarray]) -> None:
    """A row for a peer; it prepares both views of a pair, of which half would be kept for the next."""
    views = list(session.views())
    w = cloud.measure(views[0].points).resolution
    laps, errors = [], []
    for target, source in pairwise(views):
        started = time.perf_counter()
        T = register(source.points.astype(float), target.points.astype(float), w)
        laps.append(time.perf_counter() - started)
        errors.append(error(session, source.index, target.index, T))
    report(name, laps, errors, {})


def gicp(source: np.ndarray, target: np.ndarray, w: float) -> np.ndarray:
    """small_gicp alone, from the identity."""
    return small_gicp.align(
        target, source, downsampling_resolution=w, max_correspondence_distance=5 * w, num_threads=2, max_iterations=50
    ).T_target_source


def fpfh(source: np.ndarray, target: np.ndarray, w: float) -> np.ndarray:
    """Open3D's tutorial pipeline: FPFH, RANSAC over feature matches, point-to-plane ICP."""
    registration = o3d.pipelines.registration
    clouds, features = [], []
    for points in (source, target):
        pcd = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)).voxel_down_sample(1.5 * w)
        pcd.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(6 * w, 30))
        pcd.orient_normals_towards_camera_location(np.zeros(3))
        clouds.append(pcd)
        features.append(registration.compute_fpfh_feature(pcd, o3d.geometry.KDTreeSearchParamHybrid(15 * w, 100)))
    coarse = registration.registration_ransac_based_on_feature_matching(
        *clouds, *features, True, 4 * w,
        registration.TransformationEstimationPointToPoint(False), 3,
        [
            registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
            registration.CorrespondenceCheckerBasedOnDistance(4 * w),
        ],
        registration.RANSACConvergenceCriteria(100_000, 0.999),
    )  # fmt: skip
    plane = registration.TransformationEstimationPointToPlane()
    return registration.registration_icp(*clouds, 4 * w, coarse.transformation, plane).transformation


def error(session: Session, source: int, target: int, T: np.ndarray | None) -> float:
    """Degrees between an estimated and the true pose of a pair."""
    truth = session.truth()
    return np.nan if T is None else rotation_error_deg(poses.invert(truth[target]) @ truth[source], T)


def report(name: str, laps: list[float], errors: list[float], stages: dict[str, float]) -> None:
    """Print a row."""
    shown = "  ".join(f"{stage} {ms:.0f}" for stage, ms in stages.items())
    print(f"{name:28s}  {np.median(laps):6.3f}  {np.nanmedian(errors):10.3f}  {np.nanmax(errors):6.3f}   {shown}")


if __name__ == "__main__":
    main()
