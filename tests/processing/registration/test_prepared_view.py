"""A cache of prepared views: the last ones asked for stay, others are prepared again."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from orbitscan.processing.registration.prepared_view import ViewCache
from orbitscan.processing.surface.preparation import Surfels
from tests.geometry import scan
from tests.processing.scene import Scene


@dataclass
class Named:
    """In the place of a prepared view."""

    name: str
    surface: SimpleNamespace
    middle: str
    self_turns: tuple[str, ...] = ()


def named(name, *turns, enough=False):
    return Named(name, SimpleNamespace(enough=enough, sensor_origin="its sensor"), f"the middle of {name}", turns)


def names(*views):
    return [view.name for view in views]


@pytest.fixture
def cached():
    """A cache for two of four views, and the indices of those that were prepared, in order."""
    views, prepared = scan(n_views=4, points=2000).views(), []

    def prepare(view):
        prepared.append(view.index)
        return named(f"view {view.index}", "a turn", enough=True)

    return views, ViewCache(views, prepare, lambda view: named(f"surface {view.index}"), most=2), prepared


def test_what_is_kept_is_not_prepared_again(cached):
    views, found, prepared = cached
    for view in views:
        found.put(view)
    assert names(found.get(3), found.get(2), found.get(3)) == ["view 3", "view 2", "view 3"]
    assert prepared == [0, 1, 2, 3]


def test_what_was_asked_for_longest_ago_goes(cached):
    views, found, prepared = cached
    found.put(views.load(0))
    found.put(views.load(1))
    found.get(0)
    found.get(2)
    assert prepared == [0, 1, 2]
    assert found.get(0).name == "view 0"
    assert prepared == [0, 1, 2]
    assert found.get(1).name == "view 1"
    assert prepared == [0, 1, 2, 1]


def test_a_surface_is_prepared_alone_where_nothing_more_is_asked_for(cached):
    views, found, prepared = cached
    found.put(views.load(0))
    assert found.get_surface(0).name == "view 0"  # what is there has all
    assert names(found.get_surface(1), found.get_surface(1)) == ["surface 1", "surface 1"]
    assert prepared == [0]
    assert names(found.get(1), found.get_surface(1)) == ["view 1", "view 1"]
    assert prepared == [0, 1]
    found.get_surface(2)
    found.get_surface(3)
    assert found.get(1).name == "view 1"
    assert prepared == [0, 1, 1]


def test_what_little_is_kept_of_a_view_is_there_when_it_is_gone(cached):
    views, found, prepared = cached
    for view in views:
        found.put(view)
    assert found.get_outlook(0) == ("the middle of view 0", "its sensor", ("a turn",))
    assert found.get_surface(0).self_turns == ("a turn",)
    assert found.get_surface(0).name == "surface 0"
    assert prepared == [0, 1, 2, 3]


def test_a_few_surfels_stand_for_all():
    every = Surfels(np.arange(30.0).reshape(10, 3), np.ones((10, 3)), np.arange(10.0))
    assert len(every) == 10
    assert every.thinned(10).variances.tolist() == list(range(10))
    assert every.thinned(4).variances.tolist() == [0, 3, 6, 9]
    assert len(every.thinned(1)) == 1
    for few in (every.thinned(10), every.thinned(4)):  # or kernels are compiled anew for another layout
        assert few.points.flags.c_contiguous
        assert few.normals.flags.c_contiguous
        assert few.variances.flags.c_contiguous


def test_a_cache_for_none_still_hands_out_what_it_prepared():
    views = scan(n_views=1, points=2000).views()
    assert ViewCache(views, lambda view: named(f"view {view.index}"), None, most=0).get(0).name == "view 0"


def test_search_structures_are_made_once_and_hold_the_surfels():
    view = Scene(scan(n_views=1)).views[0]
    assert view.fine_target is view.fine_target
    assert len(view.coarse_surfels) <= view.settings.coarse_points < len(view.surface.surfels)
    for target, surfels in ((view.fine_target, view.surface.surfels), (view.coarse_target, view.coarse_surfels)):
        assert np.array_equal(target.grid.points, surfels.points[target.grid.order])
        assert np.array_equal(target.normals, surfels.normals[target.grid.order])
        assert np.array_equal(target.variances, surfels.variances[target.grid.order])
