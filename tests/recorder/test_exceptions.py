"""What an error says: to who calls the library in Python's words, to who types a command in its own."""

import pickle

import pytest

from orbitscan.recorder.cli.output import as_flags
from orbitscan.recorder.exceptions import InvalidOption, Wording, setting, spelled


@pytest.mark.parametrize(
    ("wording", "python", "command"),
    [
        (Wording("pass {units} if so", units="mm"), "pass units='mm' if so", "pass --units mm if so"),
        (Wording("check {units} and {pose_axes}"), "check units and pose_axes", "check --units and --pose-axes"),
        (setting("columns", ("px", "py")), "columns=('px', 'py')", "--columns px,py"),
        (setting("elevation_deg", 91.0), "elevation_deg=91.0", "--elevation 91"),
        (setting("from_folders", True), "from_folders=True", "--from-folders"),
        (Wording("choose another {place}"), "choose another place", "choose another place with -o"),
        (
            Wording.of("pass ", {"axes": "RUB", "units": "m"}, " or ", {"axes": "RFU"}),
            "pass axes='RUB', units='m' or axes='RFU'",
            "pass --axes RUB --units m or --axes RFU",
        ),
    ],
)
def test_settings_are_written_as_the_reader_gives_them(wording, python, command):
    assert wording == python
    assert spelled(wording, as_flags) == command
    again = pickle.loads(pickle.dumps(wording))
    assert (again, spelled(again, as_flags)) == (python, command)


def test_braces_of_a_value_or_a_path_are_no_settings():
    error = InvalidOption("{a}.mcap", "holds {b}", Wording("pass {name}", name="{c}"))
    assert str(error) == "{a}.mcap: holds {b}; pass name='{c}'"
    assert error.spelled(as_flags) == "{a}.mcap: holds {b}; pass --name {c}"


def test_an_error_of_another_process_can_still_be_written_as_flags():
    error = pickle.loads(pickle.dumps(InvalidOption(setting("views", "0"), "selects no view", "give 1")))
    assert str(error) == "views='0': selects no view; give 1"
    assert error.spelled(as_flags) == "--views 0: selects no view; give 1"
