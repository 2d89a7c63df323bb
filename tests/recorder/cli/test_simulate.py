"""`simulate`: one object, or a corpus of them."""

import pytest

from orbitscan.recorder import mcap_file


def test_simulate_records_an_object(orbitscan, tmp_path):
    status, out, err = orbitscan("simulate", "coffee_mug", "-o", "mug.mcap", "--views", "4", "--focal", "300")
    assert (status, err) == (0, "")
    assert out.splitlines() == [
        "mug.mcap: 4 views",
        "next: orbitscan check mug.mcap",
        "next: orbitscan process mug.mcap -o results",
    ]
    found = mcap_file.read(tmp_path / "mug.mcap")
    assert (found.info.name, found.info.category, sorted(found.truth())) == ("mug", "coffee_mug", [0, 1, 2, 3])


@pytest.fixture
def one_bowl(monkeypatch):
    monkeypatch.setattr("orbitscan.recorder.simulation.corpus.INSTANCES", {"bowl": 1})


def test_simulate_records_a_corpus_and_goes_on_with_it(orbitscan, tmp_path, one_bowl):
    command = ("simulate", "corpus", "-o", "corpus", "--every", "50", "--instances", "1")
    (tmp_path / "corpus").mkdir()
    for there in ("", "; 3 were there already"):
        status, out, err = orbitscan(*command)
        assert (status, err) == (0, "")
        assert out.splitlines() == [
            f"corpus: 3 recordings, 12 views{there}",
            "next: orbitscan train corpus -o model.pt",
        ]
    assert sorted(path.name for path in (tmp_path / "corpus").iterdir()) == [
        f"bowl_1_{video}.mcap" for video in (1, 2, 4)
    ]
    found = mcap_file.read(tmp_path / "corpus" / "bowl_1_2.mcap").info
    assert (found.category, found.instance, found.elevation_deg, found.views_per_turn) == ("bowl", "1", 45, 4)


def test_one_object_is_seen_by_a_kinect(orbitscan, tmp_path):
    assert orbitscan("simulate", "bowl", "-o", "bowl.mcap", "--views", "2", "--sensor", "kinect")[0] == 0
    assert mcap_file.read(tmp_path / "bowl.mcap").info.sensor.startswith("virtual Kinect")


def test_other_things_are_a_corpus_too(orbitscan, tmp_path, monkeypatch):
    monkeypatch.setattr("orbitscan.recorder.simulation.objects.OTHERS", ("bin",), raising=False)
    status, out, _ = orbitscan("simulate", "others", "-o", "others", "--views", "2")
    assert (status, out.splitlines()[0]) == (0, "others: 9 recordings, 18 views")
    assert (tmp_path / "others" / "bin_3_4.mcap").exists()
