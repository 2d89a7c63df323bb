"""What a view shows, what views show together, and what is not known."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.special import softmax

from orbitscan.processing.classification.calibration import joint_logits, open_set_scores
from orbitscan.processing.classification.checkpoint import Calibration, Checkpoint, UnreadableModel, save
from orbitscan.processing.classification.classifier import ODD, Classifier
from orbitscan.processing.classification.labelled_views import FEWEST_POINTS
from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings, pack, trim, voxel_grids
from orbitscan.processing.results.classification import ViewClassification
from tests.processing.classification import toys

STRUCTURE = "C(4,3)-P(2)-FC(3)"
NAMES = tuple(toys.SHAPES)
VOXELS = VoxelSettings(8, "density", 0.005)
SIZES = ((float(np.log(0.05)),) * 3, (0.35,) * 3)


def toy_clouds(seed, instances):
    """Balls, planks and sticks in turn."""
    return [toys.cloud(name, np.random.default_rng([seed, i])) for i in range(instances) for name in NAMES]


def trained():
    """A network that has seen 90 shapes."""
    torch.manual_seed(0)
    network = Network(STRUCTURE, 3, div=8, orientations=4)
    grids = voxel_grids(pack([trim(points, VOXELS.trim) for points in toy_clouds(1, 30)]), VOXELS)
    optimizer = torch.optim.Adam(network.parameters(), 0.02)
    for _ in range(40):
        optimizer.zero_grad()
        torch.nn.functional.cross_entropy(network(grids)[0], torch.arange(90) % 3).backward()
        optimizer.step()
    return network.state_dict()


@pytest.fixture(scope="module")
def model():
    calibration = Calibration(1.5, -3.0, 0.0, *SIZES)
    return Checkpoint(trained(), STRUCTURE, NAMES, VOXELS, (1, 4, 2), calibration)


@pytest.fixture(scope="module")
def work(model, tmp_path_factory):
    """Makes classifiers of the same network with other facts."""
    folder = tmp_path_factory.mktemp("models")

    def make(name="toys", calibration=None, **facts):
        calibration = replace(model.calibration, **(calibration or {}))
        save(replace(model, calibration=calibration, **facts), folder / name)
        return Classifier(folder / name)

    return make


@pytest.fixture(scope="module")
def classifier(work):
    return work()


@pytest.fixture(scope="module")
def clouds():
    return toy_clouds(50, 7)


def view(*probabilities, score=1.0):
    p = dict(zip(NAMES, probabilities, strict=True))
    return ViewClassification(0, None, max(p, key=p.get), False, score, p)


def test_it_knows_what_it_has_learnt(classifier, clouds):
    found = classifier.classify_views(range(21), clouds)
    assert [answer.likeliest for answer in found] == list(NAMES) * 7
    assert [answer.view for answer in found] == list(range(21))


def test_probabilities_sum_to_one_and_only_the_known_have_a_category(work, clouds):
    scores = [answer.score for answer in work().classify_views(range(21), clouds)]
    middle = float(np.median(scores)) + 1e-3
    found = work("middle", {"threshold": middle}).classify_views(range(21), clouds)
    for answer in found:
        assert tuple(answer.probabilities) == NAMES
        assert sum(answer.probabilities.values()) == pytest.approx(1, abs=1.5e-4 + 1e-9)
        assert answer.probabilities[answer.likeliest] == max(answer.probabilities.values())
        assert answer.known == (answer.score >= middle)
        assert answer.category == (answer.likeliest if answer.known else None)
    assert sum(answer.known for answer in found) == 10


def test_an_answer_is_the_softmax_and_free_energy_of_shape_and_size(model, classifier, clouds):
    points = trim(clouds[1], VOXELS.trim)
    logits, sides = model.network()(voxel_grids(pack([points]), VOXELS))
    radius = np.linalg.norm(points - points.mean(axis=0), axis=1).max()
    joint = joint_logits(logits.detach().double().numpy(), np.array([radius]), model.calibration)
    answer = classifier.classify_view(7, clouds[1])
    np.testing.assert_allclose(list(answer.probabilities.values()), softmax(joint / 1.5, axis=1)[0], atol=1e-4)
    assert answer.score == pytest.approx(open_set_scores(joint)[0], abs=1e-3)
    odds = softmax(sides.detach().double().numpy()[0])  # of a plank, which has four sides
    assert answer.orientation == (int(odds.argmax()), pytest.approx(odds.max(), abs=1e-4))


def test_only_what_has_sides_has_an_orientation(classifier, work, clouds):
    sides = [answer.orientation for answer in classifier.classify_views(range(3), clouds[:3])]
    assert sides[0] is None
    assert sides[1][0] in range(4)
    assert sides[2][0] in range(2)
    assert 0.5 <= sides[2][1] <= 1
    weights = {name: w for name, w in classifier.checkpoint.weights.items() if not name.startswith("orientations")}
    assert work("sideless", weights=weights, orientations=()).classify_view(0, clouds[1]).orientation is None


def near(one, other, within=1e-4 + 1e-9):
    assert one.likeliest == other.likeliest
    assert one.score == pytest.approx(other.score, abs=1e-3)
    assert one.probabilities == pytest.approx(other.probabilities, abs=within)


@pytest.fixture(scope="module", params=["toys", "packaged"])
def either(request, classifier):
    return classifier if request.param == "toys" else Classifier()


def test_a_view_alone_is_answered_as_among_others(either, clouds):
    for i, together in enumerate(either.classify_views(range(21), clouds)):  # more than a batch
        near(either.classify_view(i, clouds[i]), together)


def test_the_number_of_threads_is_nothing(either, clouds):
    before, answers = torch.get_num_threads(), []
    try:
        for threads in (1, 2, 3):
            torch.set_num_threads(threads)
            answers.append(either.classify_views(range(21), clouds))
    finally:
        torch.set_num_threads(before)
    for other in answers[1:]:
        for one, another in zip(answers[0], other, strict=True):
            near(one, another)


@pytest.mark.parametrize("row", range(3))
def test_where_the_points_are_and_in_what_order_is_nothing(classifier, clouds, row):
    points = np.round(clouds[row][:128] * 4096) / 4096  # so that sums and shifts are exact
    mixed = np.random.default_rng(0).permutation(points)
    holes = np.vstack([[[np.nan, 0, 0]], points, np.full((50, 3), np.nan), [[np.inf, 0, 0]]])
    others = [mixed, points + np.float32([0.5, -0.25, 1]), holes, points.astype(np.float64), points[::-1]]
    first, *answers = classifier.classify_views([3] * 6, [points.astype(np.float32), *others])
    assert answers == [first] * 5


def test_too_few_points_have_no_answer(classifier, clouds):
    empty, few = np.empty((0, 3), np.float32), clouds[0][: FEWEST_POINTS - 1]
    answers = classifier.classify_views([3, 4, 5, 6], [empty, clouds[0], np.full((99, 3), np.nan), few])
    assert [answer and answer.view for answer in answers] == [None, 4, None, None]
    assert classifier.classify_view(0, empty) is None
    assert classifier.classify_views([], []) == []
    assert classifier.fuse([]) is None


def test_another_size_is_unknown(classifier, clouds):
    assert classifier.classify_view(0, clouds[0]).known
    giant = classifier.classify_view(0, clouds[0] * 100)
    assert (giant.known, giant.category) == (False, None)
    assert classifier.odd_radius([clouds[0], clouds[1] * 2]) is None
    assert classifier.odd_radius([clouds[0] * 100]) == pytest.approx(5, rel=0.3)
    assert classifier.odd_radius([]) is None


def test_an_odd_radius_is_the_median_and_beyond_so_many_deviations(work, clouds):
    middle = float(np.median([pack([trim(c, VOXELS.trim)]).spheres[1][0] for c in clouds[:3]]))
    for factor, odd in ((0.99, None), (1.01, middle)):
        mean = float(np.log(middle)) - ODD * 0.35 * factor
        found = work("odd", {"size_means": (mean,) * 3}).odd_radius(clouds[:3])
        assert found == (odd and pytest.approx(odd))
    assert work("no size", {"size_means": (), "size_deviations": ()}).odd_radius(clouds[:3]) is None


@pytest.mark.parametrize(
    "spoil", [lambda p: p * np.float32(1e25), lambda p: np.vstack([p, np.full((9, 3), 3e38)]), lambda p: p * 0]
)
def test_garbage_is_unknown_and_still_has_numbers(classifier, clouds, spoil):
    answer = classifier.classify_view(0, spoil(clouds[0]))
    assert not answer.known
    assert np.isfinite([answer.score, *answer.probabilities.values()]).all()


def test_views_together_have_the_geometric_mean(classifier):
    views = [view(0.7, 0.2, 0.1), view(0.1, 0.6, 0.3), view(0.25, 0.25, 0.5)]
    fused = classifier.fuse(views)
    p = np.array([list(v.probabilities.values()) for v in views])
    for k in range(3):
        expected = np.prod(p[: k + 1], axis=0) ** (1 / (k + 1))
        expected /= expected.sum()
        np.testing.assert_allclose(list(fused.fused[k].values()), expected, atol=0.5e-4 + 1e-9)
        assert fused.entropy[k] == pytest.approx(-(expected * np.log(expected)).sum(), abs=0.5e-4 + 1e-9)
    # by hand: the roots of 0.0175, 0.03 and 0.015 are 0.2596, 0.3107 and 0.2466
    assert fused.fused[-1] == {"ball": 0.3178, "plank": 0.3803, "stick": 0.3019}
    assert (fused.likeliest, fused.probability, fused.views) == ("plank", 0.3803, tuple(views))
    assert (fused.categories, fused.model) == (NAMES, hashlib.sha256(classifier.path.read_bytes()).hexdigest())
    assert classifier.fuse(views[::-1]).fused[-1] == fused.fused[-1]


@pytest.mark.parametrize(
    ("scores", "known"), [((0.0,), True), ((-0.001,), False), ((-2, 2.1), True), ((2, -2.1), False)]
)
def test_a_session_is_known_by_its_mean_score_and_a_threshold_of_its_own(classifier, scores, known):
    fused = classifier.fuse([view(0.7, 0.2, 0.1, score=score) for score in scores])
    assert (fused.known, fused.category, fused.likeliest) == (known, "ball" if known else None, "ball")


def test_a_probability_rounded_to_zero_is_half_the_last_digit(classifier):
    alone = classifier.fuse([view(1.0, 0.0, 0.0)])
    assert alone.fused == ({"ball": 0.9999, "plank": 0.0, "stick": 0.0},)
    torn = classifier.fuse([view(1.0, 0.0, 0.0), view(0.0, 1.0, 0.0)]).fused[-1]
    root = np.sqrt(0.5e-4)
    expected = np.array([root, root, 0.5e-4]) / (2 * root + 0.5e-4)
    np.testing.assert_allclose(list(torn.values()), expected, atol=0.5e-4)
    outvoted = classifier.fuse([view(1.0, 0.0, 0.0)] * 2 + [view(0.0, 0.9, 0.1)])
    assert outvoted.likeliest == "ball"  # one sure view that errs forbids nothing
    everyone = classifier.fuse([view(1.0, 0.0, 0.0)] * 500)
    assert np.isfinite(everyone.entropy).all()
    assert everyone.fused[-1] == alone.fused[0]


def test_a_file_that_holds_no_model_is_refused_at_once(tmp_path):
    with pytest.raises(UnreadableModel, match="no such file"):
        Classifier(tmp_path / "none.pt")
