"""Views are kept compactly, and no instance stands on two sides of a split."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.classification.labelled_views import MAX_POINTS, gather, join, split_views
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import SessionInfo, View, in_memory
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


def test_six_bytes_a_point_are_all_that_is_kept():
    rng = np.random.default_rng(0)
    clouds = [rng.normal(size=(n, 3)).astype(np.float32) for n in (5000, 20, 3 * MAX_POINTS)]
    found = gather([one(points) for points in clouds])
    arrays = [value for value in vars(found).values() if isinstance(value, np.ndarray)]
    kept = sum(array.nbytes if array.base is None else array.base.nbytes for array in arrays)
    assert kept < 6 * (5000 + 20 + MAX_POINTS) + 3 * 200


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
    with pytest.raises(InvalidOption, match="ball_1: does not say what it shows; convert it with 'orbitscan convert"):
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


@pytest.mark.parametrize("text", ["nothing", "0%", "100%", "-1", "1.5", "²", "²%", "%"])
def test_a_choice_that_chooses_nothing_is_refused(views, text):
    with pytest.raises(InvalidOption, match="chooses nothing"):
        split_views(views, text)
    with pytest.raises(InvalidOption, match="chooses nothing"):
        split_views(views, "last", text)


def test_a_batch_is_of_radius_one_and_weighs_what_was_measured():
    points = np.random.default_rng(0).normal(size=(MAX_POINTS + 1, 3)).astype(np.float32)
    found = gather([one(points), one(points[:40]), one(points[:50])])
    batch = found.clouds(np.array([2, 0]))
    assert batch.lengths.tolist() == [50, MAX_POINTS]
    assert batch.weights[:50].tolist() == [1.0] * 50
    assert float(batch.weights[50:].sum()) == pytest.approx(MAX_POINTS + 1)
    for row, cloud in zip([2, 0], batch.points.split(batch.lengths.tolist()), strict=True):
        assert float(cloud.norm(dim=1).max()) == pytest.approx(1, abs=1e-4)
        np.testing.assert_allclose(cloud.numpy() * found.radii[row], found.cloud(row), rtol=1e-5, atol=1e-7)


def test_a_view_of_one_place_has_no_extent():
    found = gather([one(np.ones((20, 3), np.float32))])
    assert found.radii[0] == 0
    assert not found.points.any()


def test_without_a_name_or_an_instance_it_is_a_recording_of_something_else():
    nameless = [
        one(toys.cloud("ball", np.random.default_rng(i)), name=f"{i}", category=None, instance=None) for i in (1, 2)
    ]
    found = gather(nameless, names=("ball",))
    assert (found.categories == -1).all()
    assert len(set(found.units)) == 2


def test_names_give_the_order_of_the_categories():
    found = gather(toys.sessions(instances=1, views=1), names=("stick", "ball"))
    assert dict(zip(found.units.tolist(), found.categories.tolist(), strict=True)) == {
        "ball/1": 1,
        "plank/1": -1,
        "stick/1": 0,
    }


def test_joined_views_are_those_of_both(views):
    others = gather(toys.sessions(("plank",), instances=2, views=3))
    both = join(views, others)
    for row in range(len(both)):
        one, its = (views, row) if row < len(views) else (others, row - len(views))
        np.testing.assert_array_equal(both.cloud(row), one.cloud(its))
        assert (both.units[row], both.turns[row]) == (one.units[its], one.turns[its])


def test_a_number_takes_so_many_of_the_last_of_each_category(views):
    split = split_views(views, "2", "1")
    assert set(views.units[split.test]) == {"ball/4", "plank/4", "stick/4"}
    assert set(views.units[split.validation]) == {f"{name}/{i}" for name in toys.SHAPES for i in (2, 3)}
    assert set(views.units[split.train]) == {"ball/1", "plank/1", "stick/1"}


def test_a_share_is_of_the_instances_of_each_category(views):
    split = split_views(views, "25%", "50%")
    for rows, count in ((split.test, 2), (split.validation, 1), (split.train, 1)):  # a quarter of the two that are left
        assert [len(set(views.units[rows][views.categories[rows] == c])) for c in range(3)] == [count] * 3


def test_a_named_recording_takes_its_instance_to_the_test_whole():
    def recordings(name):
        clouds = [toys.session(name, i) for i in (1, 2, 3)]
        return [
            one(c.load(0).points, name=f"{name}_{c.info.instance}_{end}", category=name, instance=c.info.instance)
            for c in clouds
            for end in "ab"
        ]

    views = gather([*recordings("ball"), *recordings("plank")])
    split = split_views(views, "last", "ball_1_a, plank_2*")
    assert set(views.sessions[split.test]) == {"ball_1_a", "ball_1_b", "plank_2_a", "plank_2_b"}
    assert set(views.units[split.validation]) == {"ball/3", "plank/3"}
    assert set(views.units[split.train]) == {"ball/2", "plank/1"}


def test_split_by_views_every_view_is_an_instance():
    views = gather(toys.sessions(), split="views")
    assert len(set(views.units)) == len(views)
    split = split_views(views, "25%", "25%")
    np.testing.assert_array_equal(np.bincount(views.categories[split.test]), 4)
    np.testing.assert_array_equal(np.bincount(views.categories[split.validation]), 3)
    last = split_views(views, "last").validation
    assert set(views.units[last]) == {f"{name}/4/{name}_4/3" for name in toys.SHAPES}


def test_something_else_is_trained_on_and_never_validated():
    views = gather(toys.sessions(), names=("ball", "plank"))
    split = split_views(views, "last", "1")
    assert (views.categories[split.train] == -1).sum() == 16
    assert (views.categories[np.concatenate([split.validation, split.test])] >= 0).all()


def other(column, i=0):
    def change(views):
        changed = getattr(views, column).copy()
        changed[i] += 1
        return replace(views, **{column: changed})

    return change


@pytest.mark.parametrize(
    "change",
    [
        *(other(column) for column in ("points", "radii", "weights", "up", "turns", "categories")),
        other("points", -1),
        other("starts", 1),
        lambda views: replace(views, names=("ball", "plank", "pole")),
        lambda views: replace(views, units=np.array(["ball/7", *views.units[1:]])),
    ],
)
def test_the_fingerprint_knows_every_point_size_and_label(views, change):
    assert gather(toys.sessions()).fingerprint == views.fingerprint
    assert change(views).fingerprint != views.fingerprint


def test_the_same_shape_twice_as_large_is_other_data():
    points = np.round(toys.cloud("ball", np.random.default_rng(0)) * 1024) / 1024
    small, large = gather([one(points)]), gather([one(2 * points)])
    np.testing.assert_array_equal(small.points, large.points)
    assert small.fingerprint != large.fingerprint
