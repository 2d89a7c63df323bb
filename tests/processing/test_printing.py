"""Tables on the terminal show what they are given."""

from rich.text import Text

from orbitscan.processing.printing import print_table


def test_headers_and_cells_are_no_markup(capsys):
    print_table("All [b]", {"session": {}, "centre\n[mm]": {}}, [["mug[a]", Text("1.5", style="red")]])
    printed = capsys.readouterr().out
    for text in ("All [b]", "[mm]", "mug[a]", "1.5"):
        assert text in printed


def test_without_rows_nothing_is_printed(capsys):
    print_table("Errors", {"session": {}}, [])
    assert capsys.readouterr().out == ""
