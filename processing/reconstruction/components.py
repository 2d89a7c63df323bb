"""What holds together: the groups of views that pairs connect, each in a frame of its own, the largest in frame {0}."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orbitscan.processing.results.estimates import ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

APART = "one of {} views that hold together, but nothing holds them to the others"
Ends = tuple[int, int]  # the recorded indices of a pair's views


@dataclass(frozen=True, eq=False)
class Component:
    """Views that pairs hold together, in the frame of the first of those between which nothing is left open."""

    first: int  # the view whose frame it is
    T: Mapping[int, np.ndarray]  # view -> T_first_i, in the order of use
    rigid: frozenset[int]  # the views between which nothing is left open


def find_components(
    T: Mapping[int, np.ndarray],
    holding: Sequence[Ends],
    rigid: Sequence[Ends],
    origin: int | None = None,
    before: Collection[int] = (),
) -> tuple[Component, ...]:
    """Find what pairs hold together, that of most rigid views first; a view that none holds is a component.

    `T` are poses in the order of use, in one frame for views that the holding pairs connect. The rigid ones among these
    leave nothing open. Where an origin is given its component comes first, in its frame; else those of the views
    `before`, where there are any.
    """
    views = list(T)
    groups, cores = label_groups(views, holding), label_groups(views, rigid)
    components = [_gather(T, views, np.flatnonzero(groups == group), cores, origin) for group in np.unique(groups)]
    others = set(before)
    components.sort(  # of equal ones the earlier is the first
        key=lambda c: (c.first != origin, others.isdisjoint(c.T), -len(c.rigid), -len(c.T))
    )
    return tuple(components)


def label_groups(views: Sequence[int], ends: Sequence[Ends]) -> np.ndarray:
    """Number the groups of views that pairs connect by their first views' rows; the number (V,) of each view's."""
    row = {view: k for k, view in enumerate(views)}
    sources, targets = [row[a] for a, _ in ends], [row[b] for _, b in ends]
    graph = coo_matrix((np.ones(len(ends)), (sources, targets)), shape=(len(views), len(views)))
    _, first, inverse = np.unique(
        connected_components(graph, directed=False)[1], return_index=True, return_inverse=True
    )
    return np.asarray(first[inverse])


def place_views(
    views: Sequence[ViewEstimate],
    components: Sequence[Component],
    tell: Callable[[int], tuple[Status, str | None]],
    notes: Mapping[int, str | None] | None = None,
) -> list[ViewEstimate]:
    """Place views as components do; `tell` says what becomes of one that is not rigid in its own, and why.

    `notes` are of those that are rigid in the largest.
    """
    first, *others = components
    apart = {view: k for k, other in enumerate(others, start=1) if len(other.T) > 1 for view in other.T}
    placed = []
    for view in views:
        index = view.view
        status, note = tell(index)
        found = replace(view, status=status, note=note, T_0_i=None, component=None, T_component_i=None, pair=None)
        if index in first.T:
            found = replace(found, component=0, T_0_i=first.T[index])
            if index in first.rigid:
                found = replace(found, status=Status.OK, note=(notes or {}).get(index))
        elif k := apart.get(index):
            together = components[k]
            found = replace(found, component=k, T_component_i=together.T[index])
            if index in together.rigid:
                found = replace(found, status=Status.NOT_CONNECTED, note=APART.format(len(together.T)))
        placed.append(found)
    return placed


def _gather(
    T: Mapping[int, np.ndarray], views: Sequence[int], rows: np.ndarray, cores: np.ndarray, origin: int | None
) -> Component:
    """Gather a group's views in the frame of the first of those that most rigid pairs connect, or of the origin."""
    group = [views[row] for row in rows]
    core, sizes = np.unique(cores[rows], return_counts=True)
    first, of_core = views[core[np.argmax(sizes)]], int(core[np.argmax(sizes)])
    if origin in group:
        first, of_core = origin, int(cores[views.index(origin)])
    back = poses.invert(T[first])
    placed = {view: np.eye(4) if view == first else back @ T[view] for view in group}
    return Component(first, placed, frozenset(views[row] for row in rows if cores[row] == of_core))
