"""Tables on the terminal, in one style."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_table(title: str, columns: Mapping[str, Mapping[str, Any]], rows: Sequence[Sequence[str | Text]]) -> None:
    """Print rows; columns are the options of Rich's `add_column` by their header. Without rows nothing.

    Headers and cells are shown as they are: [mm] and a session named [a] are no markup.
    """
    if not rows:
        return
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for name, options in columns.items():
        table.add_column(Text(name), **options)
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(cell) for cell in row))
    Console().print(table)
