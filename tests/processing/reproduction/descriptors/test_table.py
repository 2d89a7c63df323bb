"""Table 5.3: which views are known and tested, what a descriptor and a network name rightly, and what is claimed."""

import pytest

from orbitscan.processing.classification.labelled_views import gather
from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.reproduction.descriptors import table
from orbitscan.processing.reproduction.descriptors.run import (
    Learning,
    Matching,
    choose,
    learn_once,
    match_once,
    run_once,
)
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.training import data, initializations
from orbitscan.processing.reproduction.training.run import Training, change_thesis, train_once
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation import corpus
from tests.processing.classification import toys
from tests.processing.reproduction import fakes


@pytest.fixture
def sessions(monkeypatch):
    """Twelve recordings of three shapes, which are all the categories there are."""
    monkeypatch.setattr(corpus, "INSTANCES", dict.fromkeys(toys.SHAPES, 4))
    return toys.sessions(instances=4, views=6)


@pytest.fixture
def found(sessions, tmp_path):
    views = gather(sessions, tuple(toys.SHAPES))
    data.save(views, tmp_path / "views.npz", "toys")
    return data.Data(tmp_path / "views.npz", views.fingerprint)


def named(choice: list[tuple[Session, int]]):
    return [(session.info.name, index) for session, index in choice]


def test_known_views_are_of_training_instances_and_drawn_anew_by_each_seed(sessions):
    (known, tested), (again, _), (other, same) = (choose(sessions, 1, seed) for seed in (0, 0, 1))
    assert len(known.views) == 3 * 18  # fewer than asked for: all there are
    assert {session.info.instance for session, _ in known.views} == {"1", "2", "3"}
    assert {session.info.instance for session, _ in tested.views} == {"4"}
    assert known.digest == again.digest == other.digest  # all of them, whatever the seed
    assert tested.digest == same.digest


def test_a_seed_draws_the_known_views(sessions, monkeypatch):
    monkeypatch.setattr("orbitscan.processing.reproduction.descriptors.run.KNOWN", 5)
    (one, tested), (two, same) = (choose(sessions, 1, seed) for seed in (0, 1))
    assert len(one.views) == len(two.views) == 15
    assert one.digest != two.digest
    assert tested.digest == same.digest


def test_thinned_circles_are_thinned_for_both(sessions):
    known, tested = choose(sessions, 3, 0)
    assert {index for choice in (known, tested) for _, index in choice.views} == {0, 3}


@pytest.mark.parametrize("kind", ["shot", "esf"])
def test_shapes_are_told_apart_by_their_descriptors(sessions, found, kind):
    known, tested = choose(sessions, 1, 0)
    result = match_once(Matching(kind, found, known, tested, 0))
    assert result["accuracy"] > 0.6  # a guess has a third
    assert (result["known"], result["tested"]) == (54, 18)
    assert result["seconds"] > 0


SMALL = change_thesis(
    {"structure": "C(4,3,2)-P(2)-FC(3)", "epochs": 12, "batch": 8, "voxels": VoxelSettings(12, "density")}
)


def test_a_network_learns_from_the_same_few_views(sessions, found):
    result = learn_once(Learning("known", found, *choose(sessions, 1, 0), SMALL, 0))
    assert result["accuracy"] > 0.5
    assert (result["known"], result["tested"]) == (54, 18)
    assert result["seconds"] > 0
    assert result["gpu_seconds"] is None


def test_a_network_of_all_training_views_is_the_kept_trainings(sessions, found):
    known, tested = choose(sessions, 1, 0)  # the tested are all test views
    result = learn_once(Learning("all", found, known, tested, SMALL, 3))
    kept = train_once(Training(found, SMALL, 3, curve=2))
    assert result["accuracy"] == pytest.approx(kept["accuracy"], abs=1 / len(tested.views))
    assert result["known"] == 54


def test_keys_name_what_a_result_depends_on_and_no_paths(sessions, found, monkeypatch):
    monkeypatch.setattr("orbitscan.processing.reproduction.descriptors.run.KNOWN", 5)
    (known, tested), (others, _) = choose(sessions, 1, 0), choose(sessions, 1, 1)
    tasks = [Matching(kind, found, which, tested, 0) for kind in ("shot", "esf") for which in (known, others)]
    tasks += [Learning("known", found, which, tested, SMALL, 0) for which in (known, others)]
    tasks += [Learning("all", found, known, tested, SMALL, seed) for seed in (0, 1)]
    keys = [str(task.key) for task in tasks]
    assert len(set(keys)) == len(keys)
    assert str(found.path) not in str(keys)
    assert Learning("all", found, known, tested, SMALL, 0).key == Learning("all", found, others, tested, SMALL, 0).key


ACCURACY = {"SHOT": 0.8, "FPFH": 0.75, "PFH": 0.7, "ESF": 0.5, table.SAME: 0.9, table.CONTROL: 0.6}
SECONDS = {"SHOT": 20.0, "FPFH": 30.0, "PFH": 600.0, "ESF": 10.0, table.SAME: 1.0, table.CONTROL: 2.0}


@pytest.fixture
def compare(sessions, found, monkeypatch, tmp_path):
    """A function that makes the table of runs nobody did: `result` tells what a task reaches."""

    def compare(result, runs):
        def keep(plan, work, tasks, what):
            assert work is run_once
            return [result(task) for task in tasks]

        fakes.stub(monkeypatch, initializations, [0.9, 0.9, 0.9, 0.7])
        monkeypatch.setattr(data, "provide", lambda plan: found)
        monkeypatch.setattr(data, "open_circles", lambda plan: sessions)
        monkeypatch.setattr(table, "keep", keep)
        return table.compare_descriptors(Plan(tmp_path, runs=runs))

    return compare


def name_of(task):
    """The row of the table that a task is of."""
    if isinstance(task, Matching):
        return task.kind.upper()
    return {"all": table.SAME, "known": table.CONTROL}[task.learns]


@pytest.fixture
def report(compare):
    def result(task):
        accuracy = ACCURACY[name_of(task)] + 0.01 * (task.seed % 2)
        return {"accuracy": accuracy, "seconds": SECONDS[name_of(task)], "known": 200, "tested": 95}

    return compare(result, runs=4)


def test_the_table_has_the_thesis_rows_and_two_controls(report):
    assert [row["classifier"] for row in report.rows][4:] == list(ACCURACY)
    shot = report.rows[4]
    assert (shot["accuracy_percent"], shot["seconds_for_475"]) == pytest.approx((80.5, 100))
    assert (shot["seconds_measured"], shot["views_measured"]) == (20, 95)
    assert [row["seconds_for_475"] for row in report.rows[:4]] == [5, 5, 5, 5]  # the network of all training views
    assert set(report.shown) < set(report.rows[0])


def test_the_orders_of_the_thesis_are_claims(report):
    verdicts = {claim.text.split(": ")[-1]: claim.verdict for claim in report.claims}
    assert verdicts["The network from Glorot is more accurate than SHOT"] == "holds"
    assert verdicts["The network from ZCA is more accurate than SHOT"] == "does not hold"
    assert verdicts["SHOT is more accurate than PFH"] == "holds"
    assert verdicts["PFH is more accurate than FPFH"] == "does not hold"
    assert verdicts["with the same known views the network is more accurate than SHOT"] == "does not hold"
    assert verdicts["on the same test views the network is more accurate than SHOT"] == "holds"
    assert [text for text in verdicts if "takes longer" in text] == [
        "PFH takes longer than FPFH",
        "FPFH takes longer than SHOT",
        "SHOT takes longer than ESF",
        "ESF takes longer than the network",
    ]
    assert report.said[-1].startswith("From fast to slow: ESF, SHOT, FPFH, PFH; in the thesis: ESF, SHOT, FPFH, PFH.")


def test_runs_go_to_the_classifier_they_are_of(compare):
    asked = []

    def result(task):
        asked.append((name_of(task), task.seed))
        return {"accuracy": list(ACCURACY).index(name_of(task)) / 10, "seconds": 1.0, "known": 200, "tested": 95}

    rows = compare(result, runs=3).rows[4:]
    assert {row["classifier"]: row["accuracy_percent"] for row in rows} == pytest.approx(
        {name: 10.0 * i for i, name in enumerate(ACCURACY)}
    )
    assert sorted(asked) == sorted((name, seed) for name in ACCURACY for seed in range(3))
