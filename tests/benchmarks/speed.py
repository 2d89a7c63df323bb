"""Seconds from points to pose, per pair and stage, ours and the peers' in one run, each alone, on all cores.

    python -m tests.benchmarks.speed --points 5000,15000,45000,90000

Successive views of the virtual robot, 20 degrees apart, 1 mm noise, 1 % outliers; medians over pairs. A machine's load
moves all rows alike, so compare the rows.
"""

import argparse
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.processing.batch.compilation import compile_kernels
from orbitscan.processing.features.shot import describe
from orbitscan.processing.pipeline import process
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.status import METHODS
from orbitscan.recorder.session import Session
from tests.benchmarks import peers, sessions
from tests.benchmarks.sessions import Case
from tests.benchmarks.tables import print_table

PUBLISHED = """On two cores of another machine, 14,000 to 30,000 points a view: the thesis's method by PCL 1.13 takes
1.04 s a pair (ICP 13.1 s of a session's 17.6 s); Open3D FPFH 0.47 s; KISS-Matcher+GICP 0.31 s"""
PCL_SHOT, NEIGHBOURS = 21_000, 230  # keypoints per second of PCL's SHOT on two threads, at so many neighbours
REFERENCE_VIEW = Path(__file__).parents[1] / "reference" / "pcl_robot_view.npz"


def main() -> None:
    """Print the seconds for the numbers of points on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", default="5000,15000,45000,90000")
    parser.add_argument("--views", type=int, default=18)
    parser.add_argument("--peers", action=argparse.BooleanOptionalAction, default=True)
    options = parser.parse_args()
    report([int(word) for word in options.points.split(",")], options.views, options.peers)


def report(points: Sequence[int], views: int, with_peers: bool) -> dict[tuple[str, int], float]:
    """Print a table for each number of points a view, how time grows with it, and SHOT's speed.

    Returns seconds a pair by (method or peer, points).
    """
    compile_kernels()
    list(process(_session(1000, 2).views(), _session(1000, 2).info))  # whatever else is done once
    seconds = {}
    for count in points:
        session = _session(count, views)
        measured = {method: measure_method(session, method) for method in METHODS}
        if with_peers:
            measured |= {name: _stages_of_peer(run) for name, run in peers.run(peers.available(), session).items()}
        stages = list(dict.fromkeys(stage for laps in measured.values() for stage in laps))
        totals = {name: sum(laps.values()) for name, laps in measured.items()}
        seconds |= {(name, count): total for name, total in totals.items()}
        rows = [
            [name, f"{totals[name]:.3f}", f"{totals[name] / totals['pairwise']:.2f}",
             *(f"{1e3 * laps[stage]:.1f}" if stage in laps else "-" for stage in stages)]
            for name, laps in measured.items()
        ]  # fmt: skip
        actual = np.median([len(view.points) for view in session.views()])
        print(f"\nseconds a pair, {actual:.0f} points a view; stages in ms\n")
        print_table(["", "s/pair", "x", *stages], rows)
    print(f"\n{PUBLISHED}")
    _show_growth(seconds, points)
    rate = shot_rate()
    print(f"\nSHOT at {NEIGHBOURS} neighbours: {rate:,.0f} keypoints/s, {rate / PCL_SHOT:.1f} times PCL's {PCL_SHOT:,}")
    return seconds


def measure_method(session: Session, method: str) -> dict[str, float]:
    """Seconds of each stage for a pair by one of our methods, run alone.

    A pair costs what its source view costs, as each view is prepared once: medians over views. `joint` is what a method
    does once for the whole session, and `scale` what comes before any method; both shared among the views.
    """
    *views, result = process(session.views(), session.info, methods=[method])
    assert isinstance(result, SessionResult)
    laps = [view.seconds[method] for view in views[1:]]
    stages = {stage: float(np.median([lap.get(stage, 0.0) for lap in laps])) for stage in laps[0]}
    whole = {stage: s for stage, s in result.seconds["methods"][method].items() if stage != "total"}
    done = sum(s for view in views for s in view.seconds[method].values())
    joint = (sum(whole.values()) - done) / len(views)
    other = (result.seconds["total"] - result.seconds["outlier_removal"] - sum(whole.values())) / len(views)
    return {**{stage: s for stage, s in stages.items() if s}, "joint": max(0.0, joint), "scale": max(0.0, other)}


def _stages_of_peer(run: peers.PeerRun) -> dict[str, float]:
    """Seconds of each stage for a pair; a mean, but for the registration itself, which is a median."""
    views = len(run.poses)
    shared = {stage: s / views for stage, s in run.stages.items() if stage != "register"}
    return {**shared, "register": float(np.median(list(run.seconds.values()))) - sum(shared.values())}


def shot_rate() -> float:
    """Keypoints per second of SHOT on PCL's reference view; the best of three, as PCL's figure is."""
    view = np.load(REFERENCE_VIEW)
    points, normals = view["points"].astype(np.float64), view["normals"].astype(np.float64)
    keypoints = points[np.random.default_rng(0).permutation(len(points))[:5000]]
    tree = cKDTree(points)
    distances, _ = tree.query(keypoints[::10], k=NEIGHBOURS)
    radius = float(np.median(distances[:, -1]))
    describe(points, normals, keypoints[:10], radius)
    laps = []
    for _ in range(3):
        started = time.perf_counter()
        describe(points, normals, keypoints, radius)
        laps.append(time.perf_counter() - started)
    return len(keypoints) / min(laps)


def _show_growth(seconds: Mapping[tuple[str, int], float], points: Sequence[int]) -> None:
    """How much longer the most points take than the fewest, in units of n log n."""
    low, high = min(points), max(points)
    if low == high:
        return
    expected = high * np.log(high) / (low * np.log(low))
    print(f"\ntime from {low:,} to {high:,} points grows (n log n: {expected:.1f} times)")
    for name in dict.fromkeys(name for name, _ in seconds):
        print(f"  {name}: {seconds[name, high] / seconds[name, low]:.1f} times")


def _session(points: int, views: int) -> Session:
    return sessions.build(Case("robot", 20, points=points, views=views)).session


if __name__ == "__main__":
    main()
