"""Damaged recordings through the commands, each kind thrice; `make fuzz` takes five hundred, with all methods."""

import signal

import numpy as np
import pytest

from tests.fuzz.commands import run_command
from tests.fuzz.mutations import KINDS, Bytes, find_records, mutate
from tests.fuzz.original import VIEWS, find_whole, make_original
from tests.fuzz.trial import process_undamaged, run_trial

NUMBERS = range(33)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


@pytest.fixture(scope="module")
def original(folder):
    return make_original(folder)


@pytest.fixture(scope="module")
def usual(original, folder):
    return process_undamaged(original, folder, ("--methods", "icp", "--model", "none"))


@pytest.mark.parametrize("number", NUMBERS)
def test_a_damaged_recording_breaks_nothing_and_gives_all_that_is_whole(original, usual, tmp_path, number):
    trial = run_trial(original, number, tmp_path, usual)
    assert not trial.complaints, f"{trial.what}; again: make fuzz FIRST={number} COUNT=1"


def test_each_kind_of_damage_occurs_and_does_harm(original):
    whole = find_whole(original, Bytes.of(original.content))
    assert (whole.views, whole.poses, whole.facts, whole.names) == ({0, 1, 2}, {0, 1, 2}, True, True)
    found = [mutate(original.content, number) for number in NUMBERS]
    assert {kind for _, kinds, _ in found for kind in kinds} == set(KINDS)
    lost = [VIEWS - len(find_whole(original, damaged).views) for damaged, _, _ in found]
    assert 5 < sum(count == 0 for count in lost) < len(NUMBERS) - 5
    assert {1, 2, 3} <= set(lost)


def test_a_number_makes_the_same_damage_again(original):
    for number in NUMBERS:
        (once, _, what), (again, _, _) = (mutate(original.content, number) for _ in range(2))
        assert np.array_equal(once.values, again.values)
        assert once.values.tobytes() != original.content or "zeroed" in what


def test_what_is_moved_is_whole_and_what_is_changed_is_not():
    content = bytes(range(100))
    file = Bytes.of(content)
    moved = file.take(slice(50, 100)).then(file.take(slice(0, 50)))
    assert moved.whole(10, 40)
    assert moved.whole(60, 40)
    assert not moved.whole(40, 20)
    assert not file.splice(30, 31, np.array([99], np.uint8)).whole(10, 40)
    assert file.splice(30, 31, np.array([30], np.uint8)).whole(10, 40)
    assert not file.splice(30, 30, np.zeros(3, np.uint8)).whole(10, 40)
    assert file.splice(5, 9, np.empty(0, np.uint8)).whole(10, 40)


def test_the_records_follow_each_other_to_the_end(original):
    records = find_records(original.content)
    assert [end for _, end in records[:-1]] == [start for start, _ in records[1:]]
    assert records[-1][1] == len(original.content) - 8
    assert {start for start, _ in original.clouds.values()} < {start for start, _ in records}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="nothing interrupts here")
def test_a_command_that_breaks_or_hangs_is_noticed(monkeypatch):
    monkeypatch.setattr("tests.fuzz.commands.LIMIT_S", 0.3)
    monkeypatch.setattr("orbitscan.recorder.mcap_file.read", lambda _: 1 / 0)
    assert "ZeroDivisionError" in run_command("info", "x.mcap").broke

    def hang(_):
        while True:
            pass

    monkeypatch.setattr("orbitscan.recorder.mcap_file.read", hang)
    hanging = run_command("info", "x.mcap")
    assert "TooSlow" in hanging.broke
    assert hanging.seconds < 3


def test_recordings_of_others_end_in_one_sentence(data, tmp_path):
    bags = sorted([*data.glob("mcap_ros2_rosbag2/*.mcap"), *data.glob("mcap_rosbags_rs/*/*.mcap")])
    assert len(bags) == 19
    for bag in bags:
        for command in (["info"], ["check"], ["process", "-o", str(tmp_path / "results")]):
            end = run_command(*command, str(bag))
            assert (end.status, end.out, end.broke) == (2, "", ""), (bag, command)
            assert end.err.startswith(f"orbitscan: error: {bag}: holds no /camera/points (topics: ")
            assert end.err.endswith("; make a recording with 'orbitscan convert'\n")
            assert end.err.count("\n") == 1
    assert not list(tmp_path.rglob("results/*"))
