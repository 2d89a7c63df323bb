"""A batch -> summary.rrd: how many recordings are well, how large their errors are, which are worst, what they are."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.results.batch_table import Row, methods_of, worst_first
from orbitscan.processing.results.confusion import Confusion
from orbitscan.processing.review import entities
from orbitscan.processing.review.batch.confusion import describe_confusion, log_confusion, view_confusion
from orbitscan.processing.review.curves import ROUNDING, log_curve
from orbitscan.processing.review.markdown import in_mm, number, write_table
from orbitscan.processing.review.panels import make_blueprint, view_curves, view_log
from orbitscan.processing.review.stream import make_document, whole_recording

SHOWN_ROWS = 100  # of the table: the worst
Curve = tuple[str, str, Sequence[int], np.ndarray]  # entity, method, ranks, values
_RANK = "worst_first"  # the timeline: recordings from the worst, 0, to the best
_ERRORS = {  # quantity -> title, key of a method's summary, factor
    "center_mm": ("Largest error of the object's centre, log10 [mm]", "max_center_error_m", 1e3),
    "rotation_chordal": ("Largest rotation error, log10 of the chordal distance", "max_rotation_error_chordal", 1.0),
}


def write_batch(path: Path, name: str, rows: Sequence[Row], confusion: Confusion | None) -> None:
    """Write the recordings of a batch as a Rerun recording, whole or not at all. Raises UnwritableOutput.

    Curves are over `worst_first`: of the recordings in that order, and of each method's errors in their own.
    """
    rows = worst_first(rows)
    methods = methods_of(rows)
    known = any(_errors(rows, method, key).size for method in methods for _, key, _ in _ERRORS.values())
    with whole_recording(path, name, _lay_out(known, confusion)) as stream:
        stream.log("/summary", make_document("\n".join(_summarize(name, rows, methods, known, confusion))), static=True)
        stream.log("/table", make_document("\n".join(_tabulate(rows))), static=True)
        for entity, method, ranks, values in (*_distributions(rows, methods), *_over_recordings(rows, methods)):
            style = entities.METHOD_COLORS[method], method, entities.CURVE_WIDTHS[method]
            log_curve(stream, f"{entity}/{method}", style, [rr.TimeColumn(_RANK, sequence=ranks)], values)
        for rank, row in enumerate(rows):
            if row.problem:
                stream.set_time(_RANK, sequence=rank)
                level = rr.TextLogLevel.ERROR if row.status == "failed" else rr.TextLogLevel.WARN
                stream.log("/log", rr.TextLog(f"{row.session}: {row.problem}", level=level))
                stream.flush()  # a chunk of one line: over a chunk of several the viewer mixes up the levels
        if confusion is not None:
            log_confusion(stream, confusion)


def conclude(rows: Sequence[Row]) -> str:
    """One sentence: how many recordings have results, and how many of their views are placed."""
    done = [row for row in rows if row.results]
    views = sum(row.views for row in done)
    failed = sum(row.of_best("failed_views") or 0 for row in done)
    text = f"{len(done):,} of {len(rows):,} recordings have results; "
    text += f"{views - failed:,} of their {views:,} views are placed with confidence"
    for status, words in (("failed", "failed"), ("unfinished", "are still being written")):
        if count := sum(row.status == status for row in rows):
            text += f"; {count:,} {words}"
    return text + "."


def _summarize(
    name: str, rows: Sequence[Row], methods: Sequence[str], known: bool, confusion: Confusion | None
) -> Iterator[str]:
    yield f"## {name}"
    yield ""
    yield f"**{conclude(rows)}**"
    yield ""
    if methods:
        header = ["method", "recordings", "views not placed", "centre, median [mm]", "centre, worst [mm]"]
        header += ["chordal, median", "chordal, worst", "seconds, median"]
        yield from write_table(header, [_describe_method(rows, method) for method in reversed(methods)])
        yield ""
        if known:
            yield "Centre and chordal: of the largest error in each recording."
        yield ""
    if confusion is not None:
        yield from describe_confusion(confusion)


def _describe_method(rows: Sequence[Row], method: str) -> list[str]:
    of = [row for row in rows if row.results and method in row.results.reconstruction]
    failed = sum(row.of(method, "failed_views") for row in of)
    views = sum(row.views for row in of)
    cells = [method, f"{len(of):,}", f"{failed:,} of {views:,}"]
    for _, key, factor in _ERRORS.values():
        errors = factor * _errors(of, method, key)
        cells += [number(float(np.median(errors))), number(float(errors.max()))] if errors.size else ["", ""]
    return [*cells, number(float(np.median([row.seconds(method) for row in of])))]


def _tabulate(rows: Sequence[Row]) -> Iterator[str]:
    shown = rows[:SHOWN_ROWS]
    left = len(rows) - len(shown)
    yield "Worst first, by the best method of each." + (f" {left:,} better ones are in summary.csv." if left else "")
    yield ""
    header = ["recording", "status", "not placed", "centre, max [mm]", "chordal, max", "category", "taken for"]
    yield from write_table([*header, "seconds", "problem"], [_describe_recording(row) for row in shown])


def _describe_recording(row: Row) -> list[str]:
    problem = (row.problem or "").replace("|", "/")
    if not row.results:
        return [row.session, row.status, *[""] * 6, problem]
    answer = row.results.classification
    return [
        row.session,
        row.status,
        f"{row.of_best('failed_views')} of {row.views}",
        in_mm(row.of_best("max_center_error_m")),
        number(row.of_best("max_rotation_error_chordal")),
        row.results.session.category or "",
        answer.answer if answer else "",
        number(row.folder.seconds["total"] if row.folder else None),
        problem,
    ]


def _distributions(rows: Sequence[Row], methods: Sequence[str]) -> Iterator[Curve]:
    for quantity, (_, key, factor) in _ERRORS.items():
        for method in methods:
            errors = _errors(rows, method, key)
            if errors.size:
                values = _log(factor * np.sort(errors)[::-1])
                yield f"/distribution/{quantity}", method, range(len(values)), values


def _over_recordings(rows: Sequence[Row], methods: Sequence[str]) -> Iterator[Curve]:
    for method in methods:
        ranks = [i for i, row in enumerate(rows) if row.results and method in row.results.reconstruction]
        failed = np.array([rows[i].of(method, "failed_views") for i in ranks], dtype=float)
        yield "/recordings/failed_views", method, ranks, failed
        yield "/recordings/seconds", method, ranks, np.array([rows[i].seconds(method) for i in ranks])
        for quantity, (_, key, factor) in _ERRORS.items():
            errors = {i: error for i in ranks if (error := rows[i].of(method, key)) is not None}
            if errors:
                yield f"/recordings/{quantity}", method, list(errors), _log(factor * np.array(list(errors.values())))


def _errors(rows: Sequence[Row], method: str, key: str) -> np.ndarray:
    return np.array([e for row in rows if (e := row.of(method, key)) is not None], dtype=float)


def _log(errors: np.ndarray) -> np.ndarray:
    return np.log10(np.maximum(errors, ROUNDING))


def _lay_out(known: bool, confusion: Confusion | None) -> rrb.Blueprint:
    plots: list[Any] = []
    if known:
        distributions = [
            view_curves(f"/distribution/{quantity}", f"{title}, sorted for each method", rrb.Corner2D.RightTop)
            for quantity, (title, _, _) in _ERRORS.items()
        ]
        plots.append(rrb.Vertical(*distributions, name="Distribution of errors"))
    quantities = {"failed_views": "Views not placed"}
    quantities |= {quantity: title for quantity, (title, _, _) in _ERRORS.items()} if known else {}
    quantities["seconds"] = "Time [s]"
    found = [view_curves(f"/recordings/{name}", title, rrb.Corner2D.RightTop) for name, title in quantities.items()]
    plots.append(rrb.Grid(*found, grid_columns=2, name="Recording by recording, worst first"))
    if confusion is not None:
        plots.append(view_confusion(len(confusion.names)))
    return make_blueprint(
        rrb.Vertical(
            rrb.Tabs(*plots),
            rrb.Horizontal(
                rrb.TextDocumentView(origin="/summary", name="Summary"),
                rrb.Tabs(rrb.TextDocumentView(origin="/table", name="Table"), view_log(_RANK)),
            ),
            row_shares=[1, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline=_RANK, play_state="following"),
    )
