"""Tables show what they are given; progress hands on every item, and a log gets a line now and then."""

from rich.text import Text

from orbitscan.recorder import console as module
from orbitscan.recorder.console import print_table, progress


def test_progress_hands_on_every_item_and_keeps_short_work_silent(capsys):
    assert list(progress(iter("abc"), 3, "Reading")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""


def test_long_work_tells_a_log_how_far_it_is(capsys, monkeypatch):
    clock = iter([0.0, 30.0, 61.0, 61.0, 62.0, 125.0, 125.0])
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    assert list(progress(range(4), 4, "Reading")) == [0, 1, 2, 3]
    assert capsys.readouterr().err.splitlines() == ["Reading: 2 of 4", "Reading: 4 of 4"]


def test_headers_and_cells_are_no_markup(capsys):
    print_table("All [b]", {"session": {}, "centre\n[mm]": {}}, [["mug[a]", Text("1.5", style="red")]])
    printed = capsys.readouterr().out
    for text in ("All [b]", "[mm]", "mug[a]", "1.5"):
        assert text in printed


def test_without_rows_nothing_is_printed(capsys):
    print_table("Errors", {"session": {}}, [])
    assert capsys.readouterr().out == ""
