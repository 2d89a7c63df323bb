"""A batch as a table, a row per recording: what it is and is taken for, errors by method, failed views, seconds."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orbitscan.processing.results.files import read_results
from orbitscan.processing.results.records import METHODS, summarize
from orbitscan.recorder.atomic import whole_file

_ANSWER = ("category", "known", "likeliest", "probability")


@dataclass(frozen=True, eq=False)
class Row:
    """What is known of one recording after a batch."""

    session: str
    status: str  # done, failed, unfinished
    problem: str | None = None  # in a sentence; of what failed or is damaged
    folder: Path | None = None  # of the results; None where there are none
    results: Mapping[str, Any] | None = None  # results.json
    seconds: Mapping[str, Any] | None = None  # timings.json

    @property
    def best(self) -> str | None:
        """The best method run."""
        methods = self.results["reconstruction"] if self.results else ()
        return next((method for method in reversed(METHODS) if method in methods), None)

    def of_best(self, key: str) -> Any:
        """An entry of the summary of the best method; None where there is none."""
        return self.results["reconstruction"][self.best]["summary"][key] if self.best else None


def read_row(folder: Path, problem: str | None = None) -> Row:
    """The row of a complete results folder."""
    results = read_results(folder)
    seconds = json.loads((folder / "timings.json").read_text(encoding="utf-8"))
    return Row(folder.name, "done", problem or results["input"]["damage"], folder, results, seconds)


def worst_first(rows: Sequence[Row]) -> list[Row]:
    """Recordings without results, then by views that the best method does not place, then by its largest error."""

    def badness(row: Row) -> tuple:
        if row.results is None:
            return (0 if row.status == "failed" else 1, row.session)
        error = row.of_best("max_center_error_m")
        return (2, -(row.of_best("failed_views") or 0), -(error or 0.0), row.session)

    return sorted(rows, key=badness)


def tabulate(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as flat records with one set of columns, whose names end in their units; None where nothing is known."""
    methods = [m for m in METHODS if any(row.results and m in row.results["reconstruction"] for row in rows)]
    return [_flatten(row, methods) for row in rows]


def write_table(folder: Path, rows: Sequence[Row]) -> None:
    """Write summary.csv and summary.parquet, each whole or not at all. Raises UnwritableOutput."""
    import pyarrow as pa
    from pyarrow import parquet

    records = tabulate(rows)
    with whole_file(folder / "summary.csv") as part, part.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(records[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(records)
    schema = pa.schema([(name, _type_of(name, pa)) for name in records[0]])
    with whole_file(folder / "summary.parquet") as part:
        parquet.write_table(pa.Table.from_pylist(records, schema), part)


def _flatten(row: Row, methods: Sequence[str]) -> dict[str, Any]:
    found, answer = row.results or {}, (row.results or {}).get("classification") or {}
    session, turntable = found.get("session", {}), found.get("turntable") or {}
    flat: dict[str, Any] = {
        "session": row.session,
        "status": row.status,
        "problem": row.problem,
        "category": session.get("category"),
        **dict(zip(("predicted", *_ANSWER[1:]), map(answer.get, _ANSWER), strict=True)),
        "views_recorded": session.get("views_recorded"),
        "views_used": len(session["views_used"]) if session else None,
        "method": row.best,
    }
    for method in methods:
        of_method = found.get("reconstruction", {}).get(method)
        for key in _summary_keys():
            flat[f"{method}_{key}"] = of_method["summary"].get(key) if of_method else None
        seconds = row.seconds["methods"][method]["total"] if of_method else None
        flat[f"{method}_seconds"] = seconds
    flat["turntable_step_deg"] = turntable.get("step_deg")
    flat["model_points"] = (found.get("model") or {}).get("points")
    flat["seconds"] = row.seconds["total"] if row.seconds else None
    return flat


def _summary_keys() -> list[str]:
    return list(summarize((), None))


def _type_of(column: str, pa: Any) -> Any:
    if column in ("session", "status", "problem", "category", "predicted", "likeliest", "method"):
        return pa.string()
    if column == "known":
        return pa.bool_()
    whole = column.startswith("views_") or column.endswith(("failed_views", "_points"))
    return pa.int64() if whole else pa.float64()
