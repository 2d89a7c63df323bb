"""Sessions are lazy, and views are selected by the grammar of `--views`."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import Session, SessionInfo, View, in_memory, name_views, select_views

NAMES = (*(f"bun{i:03d}" for i in range(20)), "chin", "top2", "top3", "ear_back")


@pytest.mark.parametrize(
    ("selection", "indices"),
    [
        ("all", range(24)),
        (" all ", range(24)),
        ("3", (0, 8, 16)),
        ("1", (0,)),
        ("24", range(24)),
        ("100", range(24)),
        ("0,1,5", (0, 1, 5)),
        ("5,1,0", (5, 1, 0)),
        ("7,", (7,)),
        ("2,2,3", (2, 3)),
        ("0:12", range(12)),
        (":3", range(3)),
        ("21:", range(21, 24)),
        ("18:19", (18,)),
        ("20:99", range(20, 24)),
        ("bun00*", range(10)),
        ("top*", (21, 22)),
        ("chin", (20,)),
        ("chin,top?", (20, 21, 22)),
        ("top3, chin", (20, 22)),
    ],
)
def test_the_grammar_of_views(selection, indices):
    assert select_views(selection, NAMES) == tuple(indices)


@pytest.mark.parametrize("selection", ["0", "0,24", "24:", "5:5", "9:3", "nobody", "Chin", "", "-1"])
def test_a_selection_of_nothing_is_refused_and_says_what_there_is(selection):
    with pytest.raises(InvalidOption, match=r"^views=.*the views are 0 to 23"):
        select_views(selection, NAMES)


@pytest.mark.parametrize(
    ("indices", "words"),
    [
        ([3], "view 3"),
        ([0, 1, 2, 3, 4, 7], "views 0-4, 7"),
        ([4, 3, 2], "views 4, 3, 2"),
        (range(0, 20, 2), "views 0, 2, 4, 6, 8, 10, 12, 14 and 2 more"),
    ],
)
def test_views_in_words(indices, words):
    assert name_views(indices) == words
    assert " more" not in name_views(indices, len(indices))


@given(st.integers(1, 300), st.integers(1, 300))
def test_a_count_is_spread_evenly(k, n):
    indices = select_views(str(k), ["v"] * n)
    assert len(indices) == min(k, n)
    assert indices[0] == 0
    steps = np.diff(indices)
    assert n == 1 or len(steps) == 0 or (steps.min() >= 1 and steps.max() - steps.min() <= 1)
    assert indices == tuple(range(n)) if k >= n else indices == tuple(i * n // k for i in range(k))


def test_views_are_loaded_when_asked_for_each_time():
    loaded = []

    def load(index):
        loaded.append(index)
        return View(index, f"v{index}", index, np.zeros((1, 3), np.float32))

    session = Session(SessionInfo("s", 5), tuple(f"v{i}" for i in range(5)), load)
    views = session.views("1:4")
    assert (len(views), views.indices, loaded) == (3, (1, 2, 3), [])
    assert [view.index for view in views] == [1, 2, 3]
    assert next(iter(views)).index == 1
    assert loaded == [1, 2, 3, 1]
    assert [view.index for view in session.views((4, 0))] == [4, 0]


def test_a_session_in_memory_keeps_the_truth_apart():
    views = [View(i, f"v{i}", i, np.zeros((1, 3), np.float32)) for i in range(2)]
    session = in_memory(SessionInfo("s", 2), views, {1: np.eye(4)})
    assert session.names == ("v0", "v1")
    assert list(session.views()) == views
    assert list(session.truth()) == [1]
    assert not [name for name in vars(views[0]) if "pose" in name or "truth" in name]
