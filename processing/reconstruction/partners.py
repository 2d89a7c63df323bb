"""Which views are worth registering to each other: by where they look from, or by how a first look makes them agree."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from orbitscan.processing.reconstruction.pose_graph import GraphSettings
from orbitscan.processing.registration.competition import look
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import ViewCache
from orbitscan.processing.registration.unobservable import same_freedom
from orbitscan.processing.results.estimates import Freedom, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_SPOKESMEN = 4  # views of a group that are asked for it
_NEXT = 4  # views nearest in the order of use that a view is looked at with
_SPREAD = 12  # views spread over all that it is looked at with as well
_GOLDEN = (5**0.5 - 1) / 2  # steps of this share of a circle spread over it evenly, however many they are


def viewing_direction(T_0_i: np.ndarray, centroid: np.ndarray, sensor_origin: np.ndarray | None) -> np.ndarray:
    """Return the unit vector in frame {0} from the object towards a view's sensor; along -z where that is unknown."""
    towards = np.array([0.0, 0.0, -1.0]) if sensor_origin is None else sensor_origin - centroid
    return T_0_i[:3, :3] @ (towards / max(float(np.linalg.norm(towards)), 1e-12))


def choose_edges(
    directions: Mapping[int, np.ndarray], known: Sequence[tuple[int, int]], bands_deg: Sequence[float]
) -> list[tuple[int, int]]:
    """Choose the (source, target) pairs worth registering besides the known ones, by the angle of viewing directions.

    Each view gets the earlier view nearest to the middle of each band; and where the views go round, one more on its
    other side.
    """
    views = list(directions)
    D = np.array([directions[view] for view in views])
    taken = {frozenset(pair) for pair in known}
    chosen = []
    for i in range(1, len(views)):
        angles = np.degrees(np.arccos(np.clip(D[:i] @ D[i], -1, 1)))
        for low, high in zip((0.0, *bands_deg), bands_deg, strict=False):
            inside = np.flatnonzero((angles > low) & (angles <= high))
            if not len(inside):
                continue
            ranked = inside[np.argsort(np.abs(angles[inside] - (low + high) / 2), kind="stable")]
            first = int(ranked[0])
            between = np.degrees(np.arccos(np.clip(D[ranked] @ D[first], -1, 1)))
            beyond = ranked[between > angles[first]]
            for j in [first, *map(int, beyond[:1])]:
                if (pair := frozenset((views[i], views[j]))) not in taken:
                    taken.add(pair)
                    chosen.append((views[i], views[j]))
    return chosen


def choose_keyviews(directions: Mapping[int, np.ndarray], apart_deg: float) -> list[int]:
    """Choose views whose viewing directions are at least so far apart that all others are near one of them."""
    chosen: list[int] = []
    for view, direction in directions.items():
        if all(directions[other] @ direction <= np.cos(np.radians(apart_deg)) for other in chosen):
            chosen.append(view)
    return chosen


def choose_nearest(
    directions: Mapping[int, np.ndarray], keyviews: Sequence[int], known: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Pair each view between keyviews (source) with the nearest of these, besides the known pairs."""
    taken, pairs = {frozenset(pair) for pair in known}, []
    for view in directions.keys() - set(keyviews):
        nearest = max(keyviews, key=lambda other: float(directions[other] @ directions[view]))
        if frozenset((view, nearest)) not in taken:
            pairs.append((view, nearest))
    return sorted(pairs)


@dataclass
class Partners:
    """Whom to register views to that nothing holds yet: those first with which a first look agrees best."""

    views: Sequence[int]  # in the order of use
    cache: ViewCache
    pair_settings: PairSettings
    settings: GraphSettings
    diameter: float  # of the object [m]
    _promise: dict[tuple[int, int], float] = field(default_factory=dict)  # (view, other) -> the score of a first look
    _asked: dict[int, set[int]] = field(default_factory=dict)  # view -> the others that it was registered to
    _open: dict[int, list[list[Freedom]]] = field(default_factory=dict)  # view -> what each of its pairs leaves open

    def learn(self, pair: PairEstimate) -> None:
        """Keep what became of a pair; what it leaves open may be because of its source."""
        self._asked.setdefault(pair.source, set()).add(pair.target)
        if pair.status == Status.AMBIGUOUS and pair.T_target_source is not None:
            left = [*pair.freedoms, *(Freedom("turn", s.axis, s.point) for s in pair.symmetries)]
            T = poses.invert(pair.T_target_source)
            self._open.setdefault(pair.source, []).append([freedom.moved(T) for freedom in left])

    def propose(self, groups: Sequence[Sequence[int]], core: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield (source, target), a view of a group and one of the core, likeliest first, as long as these may help."""
        asking = [view for group in groups for view in _spread(group) if self._may_help(view)]
        likely = [pair for view in asking for pair in self._look(view, core)]
        for view, other in sorted(likely, key=self._promise.__getitem__, reverse=True):
            strong = self._promise[view, other] >= self.settings.promising
            if self._may_help(view) and (strong or len(self._asked.get(view, ())) < self.settings.weak_tries):
                yield view, other

    def _may_help(self, view: int) -> bool:
        """Whether a view was not asked too often, and does not leave so much open, or twice the same, by itself."""
        near = self.settings.same_axis_deg, self.settings.same_axis_shift * self.diameter
        left: list[Freedom] = []
        for open_ in self._open.get(view, ()):
            if any(same_freedom(a, b, *near) for a in open_ for b in left):
                return False
            left += open_
        few = len(self._open.get(view, ())) < self.settings.open_tries
        return few and len(self._asked.get(view, ())) < self.settings.tries

    def _look(self, view: int, core: Sequence[int]) -> list[tuple[int, int]]:
        """Look at a view with some of the core; those that it was not registered to yet."""
        place = {other: k for k, other in enumerate(self.views)}
        near = sorted(core, key=lambda other: (abs(place[other] - place[view]), place[other]))[:_NEXT]
        spread = sorted(core, key=lambda other: (place[other] * _GOLDEN) % 1)[:_SPREAD]
        asked = self._asked.get(view, set())
        pairs = [(view, other) for other in dict.fromkeys((*near, *spread)) if other not in asked]
        for pair in pairs:
            if pair not in self._promise:
                source, target = (self.cache.get(index) for index in pair)
                self._promise[pair] = look(PairRegistration(source, target, self.pair_settings))
        return pairs


def _spread(group: Sequence[int]) -> list[int]:
    """Some views of a group, its ends among them."""
    rows = np.linspace(0, len(group) - 1, min(_SPOKESMEN, len(group)))
    return [group[row] for row in np.rint(rows).astype(int)]
