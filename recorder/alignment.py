"""Whether the true poses align the clouds and, where they do not, how their numbers are to be read so that they do.

The same numbers may lead from the camera to the object or back, speak of any of the 24 right-handed camera axes, and be
metres or millimetres. None of this changes the angle between two views: the pairs of views that must overlap are chosen
once, by that angle, and every reading is judged on the same pairs, by how near the clouds come to each other there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import permutations, product

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.recorder import cloud, poses
from orbitscan.recorder.conversion import DIRECTIONS, METRES, Conversion, recorded
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import Session

BEST_ANGLE, LAST_ANGLE = np.deg2rad(30), np.deg2rad(75)  # between two views: much overlap, yet a wrong pose shows
EDGES = 0.15  # views an angle a apart share 1 - a / pi of a sphere, less this at its edges
MAX_PAIRS, MIN_POINTS = 18, 10
MEASURED = 3  # views whose resolution, noise and diameter stand for all
TARGET_POINTS, SOURCE_POINTS = 20_000, 500
COARSE_PAIRS, COARSE_POINTS, FINALISTS = 6, 60, 8  # every reading is tried on a few points, the best on all
RESOLUTIONS, NOISES, DIAMETERS = 1.0, 2.0, 0.005  # aligned clouds are no farther apart than the largest of these
APART = 0.05  # not aligned at all: farther apart than this share of the diameter
CLEAR = 1.5  # another reading is right where it aligns the clouds, and that many times better,
OBVIOUS = 4.0  # or where it alone is so many times better: poses with errors align no cloud quite
TIED = 1.25  # readings that differ by less explain the clouds equally well


@dataclass(frozen=True)
class Judgement:
    """How well true poses align the clouds.

    A residual is the root mean square distance [m] of one view's points to the nearest of another's, over the share
    that both should see; the median of all pairs.
    """

    residual: float  # of the poses as given
    aligned: bool  # as well as the clouds are sampled
    apart: bool  # not even near
    given: Conversion
    better: tuple[Conversion, ...] = ()  # the simplest readings that align the clouds, where the given one does not
    better_residual: float = np.inf  # in the metres that reading gives


def judge(session: Session) -> Judgement | None:
    """The judgement of a session's true poses; None where no two views with poses and points must overlap.

    Raises InvalidPose for a pose that is no rigid motion.
    """
    given = recorded(session.info)
    files = {i: given.source_pose(T) for i, T in session.truth().items()}
    pairs = _choose_pairs(files)
    clouds = {i: _sample(session, i) for i in sorted({i for pair in pairs for i in (pair.source, pair.target)})}
    pairs = [pair for pair in pairs if min(len(clouds[pair.source]), len(clouds[pair.target])) >= MIN_POINTS]
    if not pairs:
        return None
    scene = _Scene(given, files, clouds)
    residual, half = scene.residual(given, pairs)
    limit = max(RESOLUTIONS * scene.resolution, NOISES * scene.noise, DIAMETERS * scene.diameter)
    # A box shows a new face as it turns: only half of its points must agree. The larger share tells readings apart.
    judgement = Judgement(residual, half <= limit, residual > APART * scene.diameter, given)
    if residual <= limit:
        return judgement
    some = pairs[:: -(-len(pairs) // COARSE_PAIRS)]
    finalists = sorted(_readings(given), key=lambda reading: scene.coarse_residual(reading, some))[:FINALISTS]
    residuals = {reading: scene.residual(reading, pairs)[0] for reading in finalists}
    best = min(residuals.values())
    tied = [reading for reading in finalists if residuals[reading] <= TIED * best]
    obvious = len(tied) == 1 and residual >= OBVIOUS * best and best <= APART * scene.diameter
    if obvious or (best <= limit and residual >= CLEAR * best):
        fewest = min(_changes(reading, given) for reading in tied)
        better = tuple(reading for reading in tied if _changes(reading, given) == fewest)
        mended = residuals[better[0]] * METRES[better[0].units] / METRES[given.units]
        return replace(judgement, aligned=False, better=better, better_residual=mended)
    return judgement


def _readings(given: Conversion) -> list[Conversion]:
    """Every way to read the poses; the clouds' units may be wrong instead of the poses'."""
    units = [(given.units, unit) for unit in METRES]
    units += [(unit, given.pose_units) for unit in METRES if unit != given.units]
    return [
        replace(given, units=unit, pose_units=pose_unit, pose_axes=axes, poses_are=direction)
        for direction, axes, (unit, pose_unit) in product(DIRECTIONS, right_handed_axes(), units)
    ]


def _changes(reading: Conversion, given: Conversion) -> int:
    return sum(getattr(reading, field.name) != getattr(given, field.name) for field in fields(Conversion))


def right_handed_axes() -> tuple[str, ...]:
    """The names of the 24 right-handed frames."""
    names = ("".join(letters) for lines in permutations(("RL", "DU", "FB")) for letters in product(*lines))
    return tuple(name for name in names if _is_right_handed(name))


def _is_right_handed(axes: str) -> bool:
    try:
        poses.axes_to_rdf(axes)
    except InvalidOption:
        return False
    return True


@dataclass(frozen=True)
class _Pair:
    """Two views that must overlap, and the share of the source's points that the target should see."""

    source: int
    target: int
    share: float


def _choose_pairs(files: Mapping[int, np.ndarray]) -> list[_Pair]:
    """Pairs of views about BEST_ANGLE apart, spread over the session; near in order where the angle says nothing."""
    known = sorted(files)
    pairs: dict[frozenset[int], _Pair] = {}
    for i in known[:: max(1, -(-len(known) // MAX_PAIRS))]:
        angles = {j: poses.rotation_angle(files[i][:3, :3].T @ files[j][:3, :3]) for j in known if j != i}
        near = [j for j, angle in angles.items() if angle <= LAST_ANGLE]
        if near:
            j = min(near, key=lambda j: (round(abs(angles[j] - BEST_ANGLE), 2), abs(i - j)))
            pairs.setdefault(frozenset((i, j)), _Pair(i, j, 1 - EDGES - angles[j] / np.pi))
    return list(pairs.values())


def _sample(session: Session, index: int) -> np.ndarray:
    points, _ = cloud.finite(session.load(index).points)
    return points[:: max(1, -(-len(points) // TARGET_POINTS))].astype(np.float64)


class _Scene:
    """The clouds of some views and their poses as they stand in a file, ready to be placed by any reading."""

    def __init__(self, given: Conversion, files: Mapping[int, np.ndarray], clouds: Mapping[int, np.ndarray]) -> None:
        self.given = given
        self.files = files
        self.clouds = clouds
        self.trees = {i: cKDTree(points) for i, points in clouds.items()}
        facts = [cloud.measure(points) for points in list(clouds.values())[:MEASURED]]
        sizes = [(fact.resolution, fact.noise, fact.diameter) for fact in facts]
        self.resolution, self.noise, self.diameter = np.median(sizes, axis=0).tolist()

    def residual(self, reading: Conversion, pairs: Sequence[_Pair]) -> tuple[float, float]:
        """The residual, over the share of the points that two views should both see and over the nearest half."""
        shares, halves = [], []
        for pair in pairs:
            distances, _ = self.trees[pair.target].query(self._placed(reading, pair, SOURCE_POINTS))
            squares = np.cumsum(np.sort(distances) ** 2) / np.arange(1, len(distances) + 1)
            shares.append(np.sqrt(squares[max(1, round(pair.share * len(squares))) - 1]))
            halves.append(np.sqrt(squares[(len(squares) - 1) // 2]))
        return float(np.median(shares)), float(np.median(halves))

    def coarse_residual(self, reading: Conversion, pairs: Sequence[_Pair]) -> float:
        """The residual of a few points, told only up to a tenth of the diameter."""
        far = self.diameter / 10
        found = []
        for pair in pairs:
            placed = self._placed(reading, pair, COARSE_POINTS)
            distances, _ = self.trees[pair.target].query(placed, distance_upper_bound=far)
            nearest = np.sort(np.minimum(distances, far))[: max(1, round(pair.share * len(distances)))]
            found.append(np.sqrt((nearest**2).mean()))
        return float(np.median(found))

    def _placed(self, reading: Conversion, pair: _Pair, count: int) -> np.ndarray:
        """About `count` points of the source in the frame of the target, in the units of the clouds as given."""
        T = poses.invert(reading.pose(self.files[pair.target])) @ reading.pose(self.files[pair.source])
        T[:3, 3] *= METRES[self.given.units] / METRES[reading.units]
        points = self.clouds[pair.source]
        return poses.transform(T, points[:: max(1, len(points) // count)])
