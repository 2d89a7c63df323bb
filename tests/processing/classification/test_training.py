"""Training learns, can be stopped and resumed, and says what it cannot do."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from orbitscan.processing.classification.evaluation import EpochRecord, Evaluator, StepRecord
from orbitscan.processing.classification.labelled_views import gather, split_views
from orbitscan.processing.classification.losses import classification_loss, orientation_labels, orientation_loss
from orbitscan.processing.classification.training import RUNS, THESIS, TrainingSettings, train
from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.settings import read_settings
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.simulation import corpus
from tests.processing.classification import toys

SMALL = TrainingSettings(
    structure="C(8,3)-P(2)-FC(3)", epochs=4, batch=16, epoch_views=200, voxels=VoxelSettings(8, "density", 0.005)
)

SHORT = replace(SMALL, epochs=2, epoch_views=48)


@pytest.fixture(scope="module")
def views():
    return gather(toys.sessions(instances=5))


def run(views, settings=SMALL, **options):
    *records, model = train(views, split_views(views, "last", "last"), settings, **options)
    return records, model


@pytest.fixture(scope="module")
def whole(views):
    """The records and the model of a training that nothing stopped, for all tests."""
    return run(views)


@pytest.fixture(scope="module")
def short(views):
    """The model of a training of two short epochs."""
    return run(views, SHORT)[1]


def assert_same_weights(a, b):
    assert a.weights.keys() == b.weights.keys()
    for name in a.weights:
        assert torch.equal(a.weights[name], b.weights[name])


def test_it_learns_and_says_how_well(views):
    records, model = run(views, replace(SMALL, epochs=12))
    assert [record.epoch for record in records] == list(range(1, 13))
    assert records[-1].train_loss < 0.5 * records[0].train_loss
    assert records[-1].validation_accuracy > 0.9
    assert sum(map(sum, records[-1].confusion)) == 12  # views of the three validation instances
    assert records[-1].overfitting == records[-1].validation_loss - records[-1].train_loss
    assert model.metrics["test"]["views"] == 12
    assert model.metrics["test"]["accuracy"] > 0.9
    assert (model.categories, model.structure, model.fingerprint) == (
        ("ball", "plank", "stick"),
        SMALL.structure,
        views.fingerprint,
    )
    assert model.settings["epochs"] == 12


def test_the_seed_decides(views):
    one, again, other = (run(views, SHORT, seed=seed)[1] for seed in (3, 3, 4))
    assert_same_weights(one, again)
    assert not torch.equal(one.weights["categories.weight"], other.weights["categories.weight"])


def test_a_training_that_was_stopped_ends_as_if_it_had_not_been(views, whole, tmp_path):
    records, model = whole
    state = tmp_path / "state"
    stopped = train(views, split_views(views, "last", "last"), SMALL, state=state)
    before = [next(stopped), next(stopped)]
    stopped.close()
    resumed_records, resumed = run(views, state=state)
    assert [vars(record) for record in resumed_records[:2]] == [vars(record) for record in before]  # even the speeds
    assert_same_weights(model, resumed)
    assert resumed.calibration == model.calibration
    for a, b in zip(records, resumed_records, strict=True):
        assert replace(a, views_per_second=0).__dict__ == replace(b, views_per_second=0).__dict__


def test_the_state_of_another_training_or_a_cut_one_is_not_gone_on_from(views, short, tmp_path):
    state = tmp_path / "state"
    others = gather(toys.sessions(instances=6))
    for another in (
        lambda: run(views, SHORT, seed=2, state=state),
        lambda: run(views, replace(SHORT, batch=8), state=state),
        lambda: run(others, SHORT, state=state),
        lambda: list(train(views, split_views(views, "last", "2"), SHORT, state=state)),
        lambda: list(train(views, split_views(views, "2", "last"), SHORT, state=state)),
        lambda: state.write_bytes(state.read_bytes()[:500]),
        lambda: state.write_bytes(b"something else"),
        lambda: torch.save({"something": "else"}, state),
    ):
        another()
        content = state.read_bytes()
        assert_same_weights(run(views, SHORT, state=state)[1], short)
        assert state.read_bytes() != content


def test_a_flipped_bit_in_the_state_is_noticed(views, tmp_path):
    state = tmp_path / "state"
    _, whole = run(views, SHORT, state=state)
    damaged = bytearray(state.read_bytes())
    weights = whole.weights["categories.weight"].numpy().tobytes()
    damaged[damaged.index(weights) + 2] ^= 64
    state.write_bytes(damaged)
    assert_same_weights(run(views, SHORT, state=state)[1], whole)


def test_a_training_that_was_whole_gives_its_model_again(views, tmp_path):
    state = tmp_path / "state"
    records, whole = run(views, SHORT, state=state)
    again, model = run(views, SHORT, state=state)
    assert_same_weights(model, whole)
    assert [vars(record) for record in again] == [vars(record) for record in records]  # not even their speeds differ
    assert (model.calibration, model.metrics) == (whole.calibration, whole.metrics)


@pytest.mark.parametrize("init", ["glorot", "dcae", "kmeans-pca", "kmeans-zca"])
def test_every_initialisation_trains(views, init):
    settings = replace(THESIS, structure="C(4,3,2)-C(4,3)-P(2)-FC(3)", init=init, voxels=VoxelSettings(16), epochs=1)
    records, model = run(views, settings)
    assert len(records) == 1
    assert model.settings["init"] == init
    assert not model.calibration.size_means  # the thesis's network knows the shape alone


def test_a_kmeans_network_starts_from_other_filters(views):
    settings = replace(THESIS, structure="C(4,3,2)-FC(3)", voxels=VoxelSettings(16), epochs=1, learning_rate=0.0)
    random, kmeans = (run(views, replace(settings, init=init))[1] for init in ("glorot", "kmeans-pca"))
    assert not torch.equal(random.weights["features.0.weight"], kmeans.weights["features.0.weight"])
    assert torch.equal(random.weights["categories.weight"], kmeans.weights["categories.weight"])


def test_something_else_is_a_category_whose_logit_is_zero():
    logits, categories = torch.tensor([[2.0, -1.0], [0.5, 3.0]]), np.array([0, -1])
    first = -(2 - np.log(np.exp(2) + np.exp(-1) + 1))
    second = np.log(np.exp(0.5) + np.exp(3) + 1)
    assert classification_loss(logits, categories, True).item() == pytest.approx((first + second) / 2, rel=1e-5)
    closed = classification_loss(logits[:1], categories[:1], False).item()
    assert closed == pytest.approx(np.log(1 + np.exp(-3)), rel=1e-5)


def test_other_things_are_learnt_to_be_unknown():
    known = toys.sessions(("ball", "plank"), instances=5)
    views = gather([*known, *toys.sessions(("stick",), instances=5)], names=("ball", "plank"))
    settings = replace(SMALL, structure="C(8,3)-P(2)-FC(2)", epochs=12)
    split = split_views(views, "last")
    *_, model = train(views, split, settings)
    evaluator = Evaluator(views, np.zeros((len(views), 2)), settings.voxels)
    logits = evaluator.predict(model.network(), np.arange(len(views)))
    energy = np.logaddexp.reduce(logits, axis=1)
    assert np.median(energy[views.categories == -1]) < np.quantile(energy[views.categories >= 0], 0.05)


def test_a_label_is_the_run_of_one_turn():
    circle = gather([toys.session("ball", 1, views=30, per_turn=25)])  # more than a turn
    labels = orientation_labels(circle, np.arange(30), (6,))
    np.testing.assert_array_equal(labels, np.floor(np.arange(30) * 6 / 25).astype(int) % 6)
    turn = gather([toys.session("ball", 1, views=190)])
    counts = np.bincount(orientation_labels(turn, np.arange(190), (6,)))
    np.testing.assert_array_equal(counts, [32, 32, 31, 32, 32, 31])  # the thesis's 32 of 190
    thinned = gather([toys.session("ball", 1, views=190)], every=7)
    labels = orientation_labels(thinned, np.arange(len(thinned)), (6,))
    np.testing.assert_array_equal(labels, np.arange(0, 190, 7) * 6 // 190)


def test_a_view_of_unknown_orientation_adds_nothing():
    logits = torch.tensor([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    one = orientation_loss(logits, np.array([2, -1])).item()
    assert one == pytest.approx(-torch.log_softmax(logits[0], 0)[2].item() / 2)
    assert orientation_loss(logits, np.array([-1, -1])).item() == 0


def test_the_orientation_head_is_trained_and_kept(views):
    settings = replace(SMALL, orientation=True, runs={"ball": 1, "plank": 4, "stick": 2}, epochs=1)
    model = run(views, settings)[1]
    assert model.orientations == (1, 4, 2)
    assert model.network()(torch.zeros(2, 1, 8, 8, 8))[1].shape == (2, 4)


def test_the_runs_of_a_circle_are_those_of_the_virtual_corpus():
    assert {name: corpus.RUNS.get(name, 1) for name in corpus.INSTANCES} == RUNS


def test_the_thesis_has_counts_two_epochs_and_no_augmentation():
    assert (THESIS.epochs, THESIS.voxels, THESIS.init, THESIS.size) == (
        2,
        VoxelSettings(32, "counts", 0.0),
        "glorot",
        False,
    )
    assert THESIS.augmentation == type(THESIS.augmentation)()


def test_one_category_or_nothing_to_validate_is_refused_in_a_sentence(views):
    alone = gather(toys.sessions(("ball",)))
    with pytest.raises(InvalidOption, match="ball: is the only category; give recordings of another one"):
        next(train(alone, split_views(alone), SMALL))
    with pytest.raises(InvalidOption, match="leaves nothing to validate"):
        next(train(views, split_views(views, ""), SMALL))
    with pytest.raises(InvalidOption, match="has 5 outputs for 3 categories"):
        next(train(views, split_views(views), replace(SMALL, structure="C(8,3)-FC(5)")))


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("epochs = 0", "epochs"),
        ("batch = 0", "batch"),
        ("learning_rate = -1.0", "learning_rate"),
        ("dropout = 1.0", "dropout"),
        ("epoch_views = -1", "epoch_views"),
        ("unknown_share = -0.1", "unknown_share"),
        ("[runs]\nball = 0", "runs.ball"),
        ("[voxels]\ndiv = 0", "voxels.div"),
        ("[voxels]\ntrim = -0.5", "voxels.trim"),
    ],
)
def test_a_setting_that_cannot_be_is_named(tmp_path, text, key):
    (tmp_path / "settings.toml").write_text(text)
    with pytest.raises(InvalidOption, match=rf"settings.toml: {key}: input should be .*; give such a value"):
        read_settings(tmp_path / "settings.toml", TrainingSettings)


def test_a_record_is_made_after_each_epoch(views):
    first = next(train(views, split_views(views), SMALL))
    assert isinstance(first, EpochRecord)
    assert first.views_per_second > 0


def test_a_curve_is_measured_between_epochs_and_changes_nothing():
    views = gather(toys.sessions())
    split = split_views(views)
    plain = list(train(views, split, SMALL))
    curved = list(train(views, split, SMALL, curve=3))
    steps = [record for record in curved if isinstance(record, StepRecord)]
    assert [record.step for record in steps] == [5, 9, 14, 19, 23, 28, 33, 37, 42, 47, 51, 56]
    assert steps[-1].validation_loss == pytest.approx(plain[-2].validation_loss)  # all of so few views
    assert all(torch.equal(plain[-1].weights[name], curved[-1].weights[name]) for name in plain[-1].weights)
