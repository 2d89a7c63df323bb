"""Views are kept compactly, and no instance stands on two sides of a split."""

import numpy as np
import pytest

from processing.classification.labelled_views import MAX_POINTS, gather, join, split_views
from recorder.exceptions import InvalidOption
from recorder.session import SessionInfo, View, in_memory
from tests.processing.classification import toys


@pytest.fixture(scope="module")
def views():
    return gather(toys.sessions())


def one(points, **facts):
    info = SessionInfo(**{"name": "one", "views": 1, "category": "thing", "instance": "1", **facts})
    return in_memory(info, [View(0, "v", 1, points)])


def test_points_come_back_to_a_32767th_of_the_radius():
    points = toys.cloud("plank", np.random.default_rng(0))
    found = gather([one(points)])
    relative = points - points.mean(axis=0)
    assert found.radii[0] == pytest.approx(np.linalg.norm(relative, axis=1).max(), rel=1e-5)
    np.testing.assert_allclose(found.cloud(0), relative, atol=found.radii[0] / 32767)
    assert found.points.nbytes == 6 * len(points)


def test_a_large_view_is_thinned_and_its_points_stand_for_all():
    points = np.random.default_rng(0).normal(size=(3 * MAX_POINTS + 7, 3)).astype(np.float32)
    found = gather([one(points)])
    assert len(found.points) == MAX_POINTS
    assert found.weights[0] * MAX_POINTS == pytest.approx(len(points))


def test_points_that_are_not_finite_and_views_without_points_are_left_out():
    points = toys.cloud("ball", np.random.default_rng(0))
    with_holes = np.vstack([points, np.full((9, 3), np.nan, np.float32)])
    np.testing.assert_array_equal(gather([one(with_holes)]).points, gather([one(points)]).points)
    assert len(gather([one(points), one(points[:5])])) == 1
    with pytest.raises(InvalidOption, match="hold no view with points"):
        gather([one(points[:5])])


def test_what_is_said_of_a_view(views):
    assert views.names == ("ball", "plank", "stick")
    assert len(views) == 3 * 4 * 4
    np.testing.assert_array_equal(np.bincount(views.categories), 16)
    np.testing.assert_allclose(views.turns[:4], [0, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(views.up[0], [0, -np.sqrt(0.5), -np.sqrt(0.5)], atol=1e-6)
    assert np.isnan(gather([one(toys.cloud("ball", np.random.default_rng(0)))]).up).all()
    assert set(views.units[:4]) == {"ball/1"}


def test_a_recording_without_category_is_refused_in_a_sentence():
    with pytest.raises(InvalidOption, match="ball_1: does not say what it shows; convert it with --category"):
        gather([toys.session("ball", 1, category=False)])


def test_others_have_no_category(views):
    others = gather([toys.session("stick", 9)], names=("ball", "plank"))
    assert (others.categories == -1).all()
    both = join(gather(toys.sessions(("ball", "plank"))), others)
    assert (len(both), both.names) == (36, ("ball", "plank"))
    np.testing.assert_array_equal(both.cloud(35), others.cloud(3))


def test_every_second_view(views):
    thinned = gather(toys.sessions(), every=2)
    assert len(thinned) == len(views) // 2
    np.testing.assert_allclose(thinned.turns[:2], [0, 0.5])


def test_trimming_forgets_a_stray_point():
    points = toys.cloud("ball", np.random.default_rng(0))
    astray = np.vstack([points, points.mean(axis=0) + np.array([0, 0, 2])])
    assert gather([one(astray)]).radii[0] > 1
    assert gather([one(astray)], trim_share=0.005).radii[0] < 0.1


@pytest.mark.parametrize(
    ("validate", "test"), [("last", "last"), ("1", ""), ("25%", "25%"), ("last", "ball_2,stick*1")]
)
def test_no_instance_stands_on_two_sides(views, validate, test):
    split = split_views(views, validate, test)
    parts = [set(views.units[rows]) for rows in (split.train, split.validation, split.test)]
    assert not parts[0] & parts[1]
    assert not parts[0] & parts[2]
    assert not parts[1] & parts[2]
    assert sum(len(rows) for rows in (split.train, split.validation, split.test)) == len(views)
    for rows in (split.train, split.validation):
        assert set(views.categories[rows]) == {0, 1, 2}


def test_the_last_instance_is_the_tenth_and_not_the_ninth():
    views = gather([toys.session(name, i, views=1) for name in ("ball", "plank") for i in range(1, 11)])
    split = split_views(views, "last", "last")
    assert set(views.units[split.test]) == {"ball/10", "plank/10"}
    assert set(views.units[split.validation]) == {"ball/9", "plank/9"}


def test_a_share_is_drawn_by_the_seed(views):
    first, again, other = (split_views(views, "50%", seed=seed).validation for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_category_needs_an_instance_to_train_on():
    views = gather([toys.session("ball", 1), *toys.sessions(("plank",))])
    with pytest.raises(InvalidOption, match="ball: of its 1 instance none is left to train on"):
        split_views(views, "last")
    by_views = gather([toys.session("ball", 1), *toys.sessions(("plank",))], split="views")
    split = split_views(by_views, "25%")
    assert set(by_views.categories[split.train]) == {0, 1}


@pytest.mark.parametrize("text", ["nothing", "0%", "100%", "-1"])
def test_a_choice_that_chooses_nothing_is_refused(views, text):
    with pytest.raises(InvalidOption, match="chooses nothing"):
        split_views(views, text)
    with pytest.raises(InvalidOption, match="chooses nothing"):
        split_views(views, "last", text)


def test_the_fingerprint_knows_points_and_labels(views):
    assert gather(toys.sessions()).fingerprint == views.fingerprint
    others = [
        gather(toys.sessions(instances=3)),
        gather([*toys.sessions(("ball", "plank")), *toys.sessions(("ball",))]),
    ]
    assert len({views.fingerprint, *(other.fingerprint for other in others)}) == 3
