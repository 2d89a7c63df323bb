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
    _promise: dict[tuple[int, int], float] = field(default_factory=dict)  # (view, other) -> the score of a first look
    _asked: dict[int, list[PairEstimate]] = field(default_factory=dict)  # view -> the pairs that it was asked for

    def propose(self, groups: Sequence[Sequence[int]], core: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield (source, target), a view of a group and one of the core, likeliest first, as long as these may help."""
        likely = [pair for group in groups for view in _spread(group) for pair in self._look(view, core)]
        for view, other in sorted(likely, key=self._promise.__getitem__, reverse=True):
            if self._may_help(view, self._promise[view, other]):
                yield view, other

    def learn(self, pair: PairEstimate) -> None:
        """Keep what became of a proposed pair."""
        self._asked.setdefault(pair.source, []).append(pair)

    def _look(self, view: int, core: Sequence[int]) -> list[tuple[int, int]]:
        """Look at a view with some of the core; those that it was not registered to yet."""
        place = {other: k for k, other in enumerate(self.views)}
        near = sorted(core, key=lambda other: (abs(place[other] - place[view]), place[other]))[:_NEXT]
        spread = sorted(core, key=lambda other: (place[other] * _GOLDEN) % 1)[:_SPREAD]
        asked = {pair.target for pair in self._asked.get(view, ())}
        pairs = [(view, other) for other in dict.fromkeys((*near, *spread)) if other not in asked]
        for pair in pairs:
            if pair not in self._promise:
                source, target = (self.cache.get(index) for index in pair)
                self._promise[pair] = look(PairRegistration(source, target, self.pair_settings))
        return pairs

    def _may_help(self, view: int, promise: float) -> bool:
        asked = self._asked.get(view, [])
        weak = promise < self.settings.promising and len(asked) >= self.settings.weak_tries
        open_ = [pair for pair in asked if pair.status == Status.AMBIGUOUS]
        return not weak and len(asked) < self.settings.tries and not self._leaves_open(open_)

    def _leaves_open(self, pairs: Sequence[PairEstimate]) -> bool:
        """Whether pairs of a view leave so much open, or twice the same, that it is the view that does."""
        axes = [freedom for pair in pairs for freedom in _in_source(pair)]
        near = (
            self.settings.same_axis_deg,
            self.settings.same_axis_shift * self.cache.get_surface(self.views[0]).scale.diameter,
        )
        again = any(same_freedom(a, b, *near) for k, a in enumerate(axes) for b in axes[:k])
        return again or len(pairs) >= self.settings.open_tries


def _spread(group: Sequence[int]) -> list[int]:
    """Some views of a group, its ends among them."""
    rows = np.linspace(0, len(group) - 1, min(_SPOKESMEN, len(group)))
    return [group[row] for row in np.rint(rows).astype(int)]


def _in_source(pair: PairEstimate) -> list[Freedom]:
    """The free motions of a pair in its source's frame."""
    if pair.T_target_source is None:
        return []
    T = poses.invert(pair.T_target_source)
    moved = ((poses.rotate(T, f.axis[None])[0], poses.transform(T, f.point[None])[0], f.kind) for f in pair.freedoms)
    return [Freedom(kind, axis, point) for axis, point, kind in moved]
