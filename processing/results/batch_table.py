"""A batch as a table, a row per recording: what it is and is taken for, errors by method, failed views, seconds."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orbitscan.processing.results.estimates import summarize
from orbitscan.processing.results.folder import Results, ResultsFolder, read_results
from orbitscan.processing.results.status import METHODS, Method, best_method
from orbitscan.recorder.atomic import whole_file


@dataclass(frozen=True, eq=False)
class Row:
    """What is known of one recording after a batch."""

    session: str
    status: str  # done, failed, unfinished
    problem: str | None = None  # in a sentence; of what failed or is damaged
    folder: ResultsFolder | None = None  # None where there are no results

    @property
    def results(self) -> Results | None:
        """The content of results.json."""
        return self.folder.results if self.folder else None

    @property
    def views(self) -> int:
        """How many views were used."""
        return len(self.results.session.views_used) if self.results else 0

    def of(self, method: str, key: str) -> Any:
        """An entry of a method's summary; None where it was not run."""
        found = self.results.reconstruction.get(Method(method)) if self.results else None
        return found.summary[key] if found else None

    def of_best(self, key: str) -> Any:
        """An entry of the summary of the best method; None where there is none."""
        return self.results.best.summary[key] if self.results and self.results.best else None

    def seconds(self, method: str) -> float | None:
        """Seconds that a method took in all."""
        return self.folder.seconds["methods"][method]["total"] if self.folder else None


def read_row(path: Path, problem: str | None = None) -> Row:
    """The row of a complete results folder. Raises UnreadableRecording."""
    folder = read_results(path)
    return Row(path.name, "done", problem or folder.results.input.damage, folder)


def worst_first(rows: Sequence[Row]) -> list[Row]:
    """Recordings without results, then by views that the best method does not place, then by its largest error."""

    def badness(row: Row) -> tuple:
        if row.results is None:
            return (0 if row.status == "failed" else 1, row.session)
        error = row.of_best("max_center_error_m")
        return (2, -(row.of_best("failed_views") or 0), -(error or 0.0), row.session)

    return sorted(rows, key=badness)


def methods_of(rows: Sequence[Row]) -> list[Method]:
    """The methods that any of the recordings was processed by, worst to best."""
    return [m for m in METHODS if any(row.results and m in row.results.reconstruction for row in rows)]


def tabulate(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as flat records with one set of columns, whose names end in their units; None where nothing is known."""
    methods = methods_of(rows)
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


def _flatten(row: Row, methods: Sequence[Method]) -> dict[str, Any]:
    found = row.results
    answer = found.classification if found else None
    flat: dict[str, Any] = {
        "session": row.session,
        "status": row.status,
        "problem": row.problem,
        "category": found.session.category if found else None,
        "predicted": answer.category if answer else None,
        "known": answer.known if answer else None,
        "likeliest": answer.likeliest if answer else None,
        "probability": answer.probability if answer else None,
        "views_recorded": found.session.views_recorded if found else None,
        "views_used": row.views if found else None,
        "method": best_method(found.reconstruction) if found else None,
    }
    for method in methods:
        was_run = found is not None and method in found.reconstruction
        flat |= {f"{method}_{key}": row.of(method, key) for key in summarize((), None)}
        flat[f"{method}_seconds"] = row.seconds(method) if was_run else None
    flat["turntable_step_deg"] = found.turntable.step_deg if found and found.turntable else None
    flat["model_points"] = found.model.points if found and found.model else None
    flat["seconds"] = row.folder.seconds["total"] if row.folder else None
    return flat


def _type_of(column: str, pa: Any) -> Any:
    if column in ("session", "status", "problem", "category", "predicted", "likeliest", "method"):
        return pa.string()
    if column == "known":
        return pa.bool_()
    whole = column.startswith("views_") or column.endswith(("failed_views", "_points"))
    return pa.int64() if whole else pa.float64()
