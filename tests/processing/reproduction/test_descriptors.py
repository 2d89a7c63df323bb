"""Table 5.3: which views are known and tested, what a descriptor and a network name rightly, and what is claimed."""

import numpy as np
import pytest

from processing.classification.labelled_views import gather
from processing.classification.voxels import VoxelSettings
from processing.reproduction import data, descriptors, initialisations
from processing.reproduction.descriptor_runs import Learning, Matching, choose, learn_once, match_once
from processing.reproduction.plan import Plan
from processing.reproduction.training_run import change_thesis
from recorder import corpus
from recorder.session import Session
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
    monkeypatch.setattr("processing.reproduction.descriptor_runs.KNOWN", 5)
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
    assert result["seconds"] == result["description_s"] + result["search_s"] > 0


def test_a_network_learns_from_the_same_few_views(sessions, found):
    known, tested = choose(sessions, 1, 0)
    how = change_thesis(
        {"structure": "C(4,3,2)-P(2)-FC(3)", "epochs": 12, "batch": 8, "voxels": VoxelSettings(12, "density")}
    )
    result = learn_once(Learning(found, known, tested, how, 0))
    assert result["accuracy"] > 0.5
    assert result["seconds"] > 0


def test_keys_name_what_a_result_depends_on_and_no_paths(sessions, found):
    known, tested = choose(sessions, 1, 0)
    tasks = [Matching(kind, found, known, tested, 0) for kind in ("shot", "esf")]
    assert tasks[0].key != tasks[1].key
    assert str(found.path) not in str([task.key for task in tasks])


def test_the_table_has_nine_rows_and_claims_the_order_of_the_thesis(monkeypatch, tmp_path):
    fakes.stub(monkeypatch, initialisations, [0.9, 0.9, 0.9, 0.7])
    accuracy = {"SHOT": 0.8, "FPFH": 0.75, "PFH": 0.7, "ESF": 0.5, descriptors.CONTROL: 0.6}
    seconds = {"SHOT": 20.0, "FPFH": 30.0, "PFH": 600.0, "ESF": 10.0, descriptors.CONTROL: 1.0}

    def match_all(plan):
        return {
            name: [
                {"accuracy": level + 0.01 * (i % 2), "seconds": seconds[name], "known": 200, "tested": 95}
                for i in plan.seeds
            ]
            for name, level in accuracy.items()
        }

    monkeypatch.setattr(descriptors, "_match_all", match_all)
    report = descriptors.compare_descriptors(Plan(tmp_path, runs=4))
    assert len(report.rows) == 9
    shot = report.rows[4]
    assert (shot["accuracy_percent"], shot["seconds_for_475"]) == pytest.approx((80.5, 100))
    verdicts = {line.split(":")[0]: line.split(": ")[1].split(" (")[0] for line in report.said if "(difference" in line}
    assert verdicts["The network from Glorot is more accurate than SHOT"] == "holds"
    assert verdicts["The network from ZCA is more accurate than SHOT"] == "does not hold"
    assert verdicts["SHOT is more accurate than PFH"] == "holds"
    assert verdicts["PFH is more accurate than FPFH"] == "does not hold"
    assert report.said[-1].startswith("From fast to slow: ESF, SHOT, FPFH, PFH; in the thesis: ESF, SHOT, FPFH, PFH.")
    assert np.isfinite([row["accuracy_percent"] for row in report.rows]).all()
