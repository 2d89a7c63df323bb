"""A view with everything registration asks of it, built when a step first needs it."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.processing.features.color_keypoints import detect_color_keypoints
from orbitscan.processing.registration.correspondences import Target, make_target
from orbitscan.processing.registration.free_space import RangeImage, make_range_image
from orbitscan.processing.registration.surface_icp import RefinementSettings
from orbitscan.processing.surface.appearance import Appearance, measure_appearance
from orbitscan.processing.surface.preparation import Scale, Surface, Surfels
from orbitscan.recorder.session import View, Views

_PIXEL = 1.0  # of the range image, in multiples of the working resolution


@dataclass(frozen=True, eq=False)
class PreparedView:
    """A view's surface, its keypoints and descriptors, and search structures."""

    surface: Surface
    keypoints: np.ndarray  # (K, 3)
    descriptors: np.ndarray  # (K, 352), NaN rows where the local frame is not valid
    frames: np.ndarray  # (K, 3, 3) local reference frames, rows x y z
    scale: Scale
    settings: RefinementSettings
    self_turns: tuple[np.ndarray, ...] = ()  # (4, 4): motions but the identity under which it agrees with itself

    @property
    def view(self) -> int:
        """Its recorded index."""
        return self.surface.view

    @cached_property
    def tree(self) -> cKDTree:
        """A kd-tree of the working points, for the thesis's ICP."""
        return cKDTree(self.surface.working)

    @cached_property
    def coarse_surfels(self) -> Surfels:
        """Surfels that stand for all while starts compete."""
        return self.surface.surfels.thinned(self.settings.coarse_points)

    @cached_property
    def middle(self) -> np.ndarray:
        """The middle (3,) of what it shows."""
        return self.coarse_surfels.points.mean(axis=0)

    @cached_property
    def judged_surfels(self) -> Surfels:
        """Surfels that stand for all when a pose is judged."""
        return self.surface.surfels.thinned(self.settings.judged_points)

    @cached_property
    def appearance(self) -> Appearance | None:
        """What its surfels look like; None for a view without colours."""
        return measure_appearance(self.surface, self.scale.working)

    @cached_property
    def by_color(self) -> "PreparedView | None":
        """The view with the keypoints of its colours in the place of its shape's; None for one without colours."""
        if self.appearance is None:
            return None
        rows = self.surface.surfels.every(self.settings.judged_points)
        found = detect_color_keypoints(self.judged_surfels, self.appearance.of(rows), self.scale.working)
        return replace(self, keypoints=found.points, descriptors=found.descriptors, frames=found.frames)

    @property
    def patch_size(self) -> float:
        """How far apart [m] residuals are independent: neighbouring surfels are fitted to points that they share."""
        return 2 * self.surface.reach

    @cached_property
    def patches(self) -> tuple[np.ndarray, int]:
        """The patch of neighbours (S,) to which each judged surfel belongs, and how many there are."""
        cells = np.floor(self.judged_surfels.points / self.patch_size).astype(np.int64)
        _, patch = np.unique(cells, axis=0, return_inverse=True)
        return patch.ravel(), int(patch.max(initial=-1)) + 1

    @cached_property
    def coarse_target(self) -> Target:
        """Its coarse surfels, sorted to find correspondences among."""
        return make_target(self.coarse_surfels, self.settings.coarse_gate * self.scale.working)

    @cached_property
    def fine_target(self) -> Target:
        """All its surfels, sorted to find correspondences among."""
        return make_target(self.surface.surfels, self.settings.middle_gate * self.scale.working)

    @cached_property
    def range_image(self) -> RangeImage | None:
        """How far its sensor saw in each direction; None where the sensor's place is unknown or amid the points."""
        origin = self.surface.sensor_origin
        return None if origin is None else make_range_image(self.surface.points, origin, _PIXEL * self.scale.working)


class Outlook(NamedTuple):
    """What little is kept of every view."""

    middle: np.ndarray  # (3,) of what it shows
    sensor_origin: np.ndarray | None  # (3,)
    self_turns: tuple[np.ndarray, ...]


class ViewCache:
    """The last views asked for, prepared; one that is no longer there is read and prepared again."""

    def __init__(
        self,
        views: Views,
        prepare: Callable[[View], PreparedView],
        prepare_surface: Callable[[View], PreparedView],
        most: int,
    ) -> None:
        """Keep `most` views at most; `prepare_surface` is the quicker one, without keypoints and descriptors."""
        self._views, self._prepare, self._prepare_surface, self._most = views, prepare, prepare_surface, max(1, most)
        self._kept: OrderedDict[int, PreparedView] = OrderedDict()
        self._without_features: set[int] = set()  # those kept without keypoints and descriptors
        self._outlooks: dict[int, Outlook] = {}  # of all that were ever asked for

    def put(self, view: View) -> PreparedView:
        """Prepare and keep a view that was just read."""
        self._without_features.discard(view.index)
        return self._keep(view.index, self._prepare(view))

    def get(self, index: int) -> PreparedView:
        """Return a view by its recorded index."""
        if index not in self._kept or index in self._without_features:
            return self.put(self._views.load(index))
        self._kept.move_to_end(index)
        return self._kept[index]

    def get_surface(self, index: int) -> PreparedView:
        """Return a view by its recorded index that may lack keypoints and descriptors."""
        if index not in self._kept:
            self._without_features.add(index)
            prepared = self._prepare_surface(self._views.load(index))
            if index in self._outlooks:
                prepared = replace(prepared, self_turns=self._outlooks[index].self_turns)
            return self._keep(index, prepared)
        self._kept.move_to_end(index)
        return self._kept[index]

    def get_outlook(self, index: int) -> Outlook:
        """Return what little is kept of every view."""
        if index not in self._outlooks:
            self.get_surface(index)
        return self._outlooks[index]

    def _keep(self, index: int, prepared: PreparedView) -> PreparedView:
        self._kept[index] = prepared
        if prepared.surface.enough:
            self._outlooks[index] = Outlook(prepared.middle, prepared.surface.sensor_origin, prepared.self_turns)
        self._kept.move_to_end(index)
        while len(self._kept) > self._most:
            oldest, _ = self._kept.popitem(last=False)
            self._without_features.discard(oldest)
        return prepared
