"""The page of a reproduction: one file of HTML that holds its figures, readable anywhere and on paper."""

import base64
import json
import shlex
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path, PurePath
from typing import Any

from jinja2 import Environment, StrictUndefined

from orbitscan.processing.reproduction.claims import FEWEST_RUNS, Verdict, conclude, count_verdicts
from orbitscan.processing.reproduction.index.columns import Column, lay_out_columns, name_column
from orbitscan.processing.reproduction.report import SavedReport

_MARKS = {Verdict.HOLDS: "✓", Verdict.FAILS: "✗", Verdict.OPEN: "?"}
_ROWS = 12  # of a table shown whole
_FIRST_ROWS = 6  # of a longer one
_MOST_ROWS = 500  # the rest is in the CSV file alone
_FACTS = {  # what was run, a field of SavedReport -> its words
    "data": "Data",
    "fraction": "Share of the thesis's views",
    "runs": "Runs of each training",
    "seeds": "Seeds",
    "device": "Device",
    "precision": "Precision",
    "machine": "Machine",
    "versions": "Versions",
}


def render_page(studies: Sequence[SavedReport], missing: Sequence[str], folder: Path) -> str:
    """The page of the studies in a folder; `missing`: the names of those that were not run."""
    sections = [_lay_out(study, folder) for study in studies]
    counts = count_verdicts(claim for study in studies for claim in study.claims)
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(files(__package__).joinpath("page.html").read_text(encoding="utf-8"))
    return template.render(
        sections=sections,
        counts=counts,
        conclusion=conclude(counts),
        marks=_MARKS,
        facts=state_facts(studies),
        missing=missing,
        few_runs=FEWEST_RUNS if any(study.runs < FEWEST_RUNS for study in studies) else None,
        first_rows=_FIRST_ROWS,
        most_rows=_MOST_ROWS,
    )


def state_facts(studies: Sequence[SavedReport]) -> dict[str, list[tuple[str, str]]]:
    """What was run: each fact in words, with the studies for which it holds; '' stands for all, or all others."""
    commands = list(dict.fromkeys(shorten_command(study.command) for study in studies))
    command = commands[0] if len(commands) == 1 else f"{len(commands)} of them, each beside its numbers"
    return {"Command": [(command, "")]} | {words: _state_fact(studies, key) for key, words in _FACTS.items()}


def shorten_command(command: str) -> str:
    """A command without the folders before a path's last part."""
    try:
        words = shlex.split(command)
    except ValueError:  # a quotation mark in a path
        words = command.split()
    return shlex.join(PurePath(word).name if PurePath(word).is_absolute() else word for word in words)


def number(name: str) -> str:
    """A study's name as the thesis writes it: 'table-5.1' -> 'Table 5.1'."""
    return name.replace("study-", "study of ").replace("-", " ").capitalize()


def _lay_out(study: SavedReport, folder: Path) -> dict[str, Any]:
    """What the template shows of a study."""
    columns = lay_out_columns(study.rows)
    pictures = {name: folder / f"{name}.png" for name in study.figures}
    inlined = {name: base64.b64encode(path.read_bytes()).decode() for name, path in pictures.items() if path.exists()}
    names, words = [study.name, *study.figures], _describe_figure(study, columns)
    beside = [f"{name}.{ending}" for name in dict.fromkeys(names) for ending in ("csv", "json", "svg", "png")]
    rows = len(study.rows)
    return {
        "name": study.name,
        "number": number(study.name),
        "title": study.title,
        "said": study.said,
        "claims": study.claims,
        "counts": count_verdicts(study.claims),
        "figures": [
            {"source": f"data:image/png;base64,{png}", "words": words, "number": number(name)}
            for name, png in inlined.items()
        ],
        "columns": columns,
        "rows": rows,
        "shown_rows": rows if rows <= _ROWS else _FIRST_ROWS,
        "files": [name for name in beside if (folder / name).exists()],
        "command": shorten_command(study.command),
        "settings": {name_column(key): _write(value) for key, value in study.settings.items()},
    }


def _describe_figure(study: SavedReport, columns: Sequence[Column]) -> str:
    """What a figure shows to those who do not see it: what is drawn of what, and what the study says."""
    drawn = [column.heading for column in columns if column.is_number]
    of = [column.heading for column in columns if not column.is_number]
    words = f"{study.title}: {', '.join(drawn) or 'pictures'}"
    words += f" by {', '.join(of)}" if of and drawn else ""
    told = [*study.said, *map(str, study.claims)]
    return f"{words}. {told[0]}" if told else f"{words}."


def _state_fact(studies: Sequence[SavedReport], key: str) -> list[tuple[str, str]]:
    found: dict[str, list[str]] = {}
    for study in studies:
        found.setdefault(_write(getattr(study, key)), []).append(number(study.name))
    most = max(found, key=lambda fact: len(found[fact]))
    return [(most, ""), *((fact, ", ".join(names)) for fact, names in found.items() if fact != most)]


def _write(value: Any) -> str:
    """A value from JSON in words."""
    match value:
        case dict():
            return ", ".join(f"{key} {_write(item)}" for key, item in value.items())
        case [int(first), *_, int(last)] if value == list(range(first, last + 1)) and len(value) > 2:
            return f"{first} to {last}"
        case list():
            return ", ".join(map(_write, value))
        case str():
            return value
        case float():
            return f"{value:g}"
    return json.dumps(value)
