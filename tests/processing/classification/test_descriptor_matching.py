"""The comparison classifiers: what is described, that the search is exhaustive, and who wins."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from orbitscan.processing.classification.descriptor_matching import (
    KINDS,
    LENGTHS,
    Database,
    DescriptorSettings,
    build_database,
    classify_views,
    describe_view,
    nearest_distances,
)
from orbitscan.processing.kernels.grid import cell_means
from orbitscan.recorder.exceptions import InvalidOption
from tests.geometry import cylinder, plane, sphere

SHAPES = {"ball": sphere, "can": cylinder, "board": plane}
ORIGIN = (0.0, 0.0, 0.0)


@pytest.fixture(params=KINDS)
def kind(request):
    if request.param == "fpfh":
        request.getfixturevalue("open3d")
    return request.param


def view(shape, seed, points=4000):
    """The side of a shape that a camera half a metre away sees, with a millimetre of noise."""
    rng = np.random.default_rng(seed)
    cloud, normals = SHAPES[shape](rng, points)
    cloud = cloud + rng.normal(scale=0.001, size=cloud.shape)
    seen = normals[:, 0] > 0.2
    return (cloud[seen][:, [1, 2, 0]] * (1, 1, -1) + (0, 0, 0.5)).astype(np.float32)


@pytest.fixture(scope="module")
def known():
    """Two views of each shape: (clouds, categories)."""
    return [view(shape, seed) for seed in (1, 2) for shape in SHAPES], list(SHAPES) * 2


@pytest.fixture(scope="module")
def databases(known):
    """The database of the known views, kind by kind, each made once."""
    return cache(lambda kind: build_database(*known, kind))


def drawn_database(rng, kind="shot", counts=(7, 1, 23), length=None):
    """A database of random descriptors, so many of each category."""
    descriptors = rng.random((sum(counts), length or LENGTHS[kind])).astype(np.float32)
    return Database(kind, DescriptorSettings(), ("a", "b", "c"), descriptors, np.repeat(np.arange(3), counts))


def brute_force(database, queries, metric="euclidean"):
    distances = cdist(queries.astype(float), database.descriptors.astype(float), metric)
    return np.column_stack([distances[:, database.classes == c].min(axis=1) for c in range(3)])


def test_every_cell_of_the_grid_has_a_descriptor(kind):
    points = view("can", 1)
    descriptors = describe_view(points, ORIGIN, kind)
    cells = 1 if kind == "esf" else len(cell_means(points, 0.01))
    assert descriptors.shape == (cells, LENGTHS[kind])
    assert descriptors.dtype == np.float32
    assert np.isfinite(descriptors).all()


def test_points_that_were_not_measured_do_not_count(kind):
    points = view("ball", 1, points=1500)
    holed = np.insert(points, [0, 100, len(points)], np.nan, axis=0)
    np.testing.assert_array_equal(describe_view(holed, ORIGIN, kind), describe_view(points, ORIGIN, kind))


def test_places_without_neighbours_have_no_descriptor(kind):
    strays = np.array([[0, 0, 0.5], [0.3, 0, 0.5]], np.float32)
    assert describe_view(strays, ORIGIN, kind).shape == (0, LENGTHS[kind])
    assert describe_view(np.empty((0, 3), np.float32), ORIGIN, kind).shape == (0, LENGTHS[kind])
    if kind != "esf":
        board = view("board", 1, points=1500)
        descriptors = describe_view(np.vstack([board, [[1, 1, 2]]]), ORIGIN, kind)
        assert len(descriptors) == len(describe_view(board, ORIGIN, kind))


def test_new_views_are_recognised(kind, databases):
    answers = classify_views(databases(kind), [view(shape, 3) for shape in SHAPES])
    assert answers.categories == tuple(SHAPES)
    assert answers.description_s > 0
    assert answers.search_s > 0


def test_a_known_view_is_at_no_distance_from_its_category(kind, known, databases):
    database = databases(kind)
    for cloud, category in list(zip(*known, strict=True))[1:4]:  # of each shape one
        (distances,) = classify_views(database, [cloud]).distances
        own = distances[database.categories.index(category)]
        assert own < 0.002 * np.partition(distances, 1)[1]


def test_the_order_of_the_known_views_does_not_matter(known, databases):
    clouds, categories = known
    query = [view("can", 3)]
    one = classify_views(databases("shot"), query)
    other = classify_views(build_database(clouds[::-1], categories[::-1], "shot"), query)
    np.testing.assert_array_equal(one.distances, other.distances)


@pytest.mark.parametrize(("kind", "metric"), [("shot", "euclidean"), ("pfh", "euclidean"), ("esf", "cityblock")])
@pytest.mark.parametrize(
    ("counts", "queries", "length"),
    [((7, 1, 23), 11, None), ((9000, 1, 100), 1200, 4)],  # the second takes several rounds, of queries and of known
)
def test_the_search_is_exhaustive(kind, metric, counts, queries, length):
    rng = np.random.default_rng(0)
    database = drawn_database(rng, kind, counts, length)
    drawn = rng.random((queries, database.descriptors.shape[1]))
    queries = np.vstack([drawn, database.descriptors[[0, 7, counts[0], -1]]]).astype(np.float32)
    found = nearest_distances(database, queries)
    np.testing.assert_allclose(found, brute_force(database, queries, metric), rtol=1e-5, atol=1e-7)


def test_the_distance_is_the_mean_over_the_descriptors(known, databases):
    database, cloud = databases("shot"), known[0][1]
    (found,) = classify_views(database, [cloud]).distances
    expected = brute_force(database, describe_view(cloud, ORIGIN, "shot")).mean(axis=0)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)


def test_without_a_descriptor_there_is_no_answer(known, databases):
    database = databases("shot")
    nothing = np.full((4, 3), np.nan, np.float32)
    answers = classify_views(database, [nothing, known[0][1], nothing])
    assert answers.categories == (None, "can", None)
    assert np.isnan(answers.distances).all(axis=1).tolist() == [True, False, True]
    np.testing.assert_array_equal(answers.distances[1], classify_views(database, [known[0][1]]).distances[0])
    assert classify_views(database, [nothing]).categories == (None,)
    assert classify_views(database, []).categories == ()


def test_what_cannot_be_described_is_no_category(known):
    clouds, categories = known
    database = build_database([*clouds, np.zeros((1, 3), np.float32)], [*categories, "speck"], "shot")
    assert database.categories == ("ball", "board", "can")
    assert (np.diff(database.classes) >= 0).all()


@pytest.mark.parametrize(
    ("clouds", "categories", "kind", "message"),
    [
        ([np.zeros((9, 3), np.float32)], ["speck"], "spin", "choose one of shot, fpfh, pfh, esf"),
        ([np.zeros((9, 3), np.float32)], [], "shot", "1 views: have 0 categories"),
        ([np.zeros((9, 3), np.float32)], ["speck"], "esf", "nothing that esf describes"),
        ([], [], "shot", "nothing that shot describes"),
    ],
)
def test_what_makes_no_database_is_told(clouds, categories, kind, message):
    with pytest.raises(InvalidOption, match=message):
        build_database(clouds, categories, kind)
