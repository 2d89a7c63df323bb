"""What a view shows, what views show together, and what is not known."""

import numpy as np
import pytest

from processing.classification.calibration import open_set_scores
from processing.classification.checkpoint import save
from processing.classification.classifier import Classifier
from processing.classification.labelled_views import gather, split_views
from processing.classification.training import TrainingSettings, train
from processing.classification.voxels import VoxelSettings
from tests.processing.classification import toys

SETTINGS = TrainingSettings(
    structure="C(8,3)-P(2)-FC(3)", epochs=15, batch=16, epoch_views=400, voxels=VoxelSettings(8, "density", 0.005)
)


@pytest.fixture(scope="module")
def classifier(tmp_path_factory):
    views = gather(toys.sessions(instances=6))
    *_, model = train(views, split_views(views, "2"), SETTINGS)
    path = tmp_path_factory.mktemp("model") / "toys.pt"
    save(model, path)
    return Classifier(path)


@pytest.fixture(scope="module")
def clouds():
    return [toys.cloud(name, np.random.default_rng([50, i])) for i in range(5) for name in toys.SHAPES]


def test_it_knows_what_it_has_learnt(classifier, clouds):
    found = classifier.classify_views(range(15), clouds)
    assert [view.likeliest for view in found] == list(toys.SHAPES) * 5
    for view in found:
        assert sum(view.probabilities.values()) == pytest.approx(1, abs=3e-4)
        assert view.probabilities[view.likeliest] == max(view.probabilities.values())
        assert (view.category is None) == (not view.known)
        assert view.known == (view.score >= round(classifier.checkpoint.calibration.threshold, 4))


def test_a_view_alone_is_answered_as_among_others(classifier, clouds):
    together = classifier.classify_views(range(15), clouds)
    for i, points in enumerate(clouds):
        alone = classifier.classify_view(i, points)
        assert alone.likeliest == together[i].likeliest
        for name, p in alone.probabilities.items():
            assert p == pytest.approx(together[i].probabilities[name], abs=2e-4)


def test_where_the_points_are_and_in_what_order_is_nothing(classifier, clouds):
    points = clouds[1]
    moved = np.random.default_rng(0).permutation(points) + np.float32([0.5, -0.25, 1])
    holes = np.vstack([points, np.full((50, 3), np.nan, np.float32), [[np.inf, 0, 0]]])
    answers = classifier.classify_views(range(3), [points, moved, holes])
    for answer in answers[1:]:
        assert answer.probabilities == pytest.approx(answers[0].probabilities, abs=0.02)


def test_too_few_points_have_no_answer(classifier, clouds):
    empty = np.empty((0, 3), np.float32)
    answers = classifier.classify_views([3, 4, 5], [empty, clouds[0], np.full((99, 3), np.nan)])
    assert [answer and answer.view for answer in answers] == [None, 4, None]
    assert classifier.classify_view(0, empty) is None
    assert classifier.fuse([]) is None


def test_another_size_is_unknown(classifier, clouds):
    assert classifier.classify_view(0, clouds[0]).known
    giant = classifier.classify_view(0, clouds[0] * 100)
    assert not giant.known
    assert giant.category is None


def test_views_together_have_the_geometric_mean(classifier, clouds):
    views = classifier.classify_views(range(3), clouds[:3])
    fused = classifier.fuse(views)
    p = np.array([[max(v.probabilities[name], 0.5e-4) for name in classifier.categories] for v in views])
    for k in range(3):
        expected = np.prod(p[: k + 1], axis=0) ** (1 / (k + 1))
        expected /= expected.sum()
        np.testing.assert_allclose(list(fused.fused[k].values()), expected, atol=1e-4)
        assert fused.entropy[k] == pytest.approx(-(expected * np.log(expected)).sum(), abs=2e-3)
    assert fused.probability == max(fused.fused[-1].values())
    assert (fused.category is None) == (not fused.known)
    mean = np.mean([view.score for view in views])
    assert fused.known == (mean >= classifier.checkpoint.calibration.fused_threshold)


def test_agreeing_views_are_surer_together(classifier, clouds):
    views = classifier.classify_views(range(5), clouds[::3])
    fused = classifier.fuse(views)
    assert (fused.category, fused.known) == ("ball", True)
    assert fused.entropy[-1] <= max(fused.entropy)


def test_the_score_is_the_free_energy():
    joint = np.array([[0.0, 0.0], [3.0, -50.0]])
    np.testing.assert_allclose(open_set_scores(joint), [np.log(2), 3.0])
