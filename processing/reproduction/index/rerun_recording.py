"""The studies of a reproduction -> .rrd: which claims hold, then each figure with its words, numbers and curves."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import rerun as rr

from orbitscan.processing.reproduction.claims import Claim, Verdict, conclude, count_verdicts
from orbitscan.processing.reproduction.index.claims_grid import draw_claims
from orbitscan.processing.reproduction.index.columns import lay_out_columns
from orbitscan.processing.reproduction.index.layout import SHARED_TIMELINE, lay_out
from orbitscan.processing.reproduction.index.study import StudyReview, collect_claims
from orbitscan.processing.reproduction.report import SavedReport
from orbitscan.processing.review import entities
from orbitscan.processing.review.curves import log_curve
from orbitscan.processing.review.entities import entity_path
from orbitscan.processing.review.stream import make_document, whole_recording

_LARGEST = 64 << 20  # bytes of the whole
_MODEL_POINTS = 20_000
_TABLE_ROWS = 30
_TABLE_COLUMNS = 13


def write_reproduction(path: Path, groups: Mapping[str, Sequence[StudyReview]], run: str) -> None:
    """Write the studies, by group, as a Rerun recording, whole or not at all; `run`: what was run, as Markdown.

    Raises UnwritableOutput.
    """
    studies = [study for group in groups.values() for study in group]
    with whole_recording(path, "reproduction", lay_out(groups), size=_LARGEST) as stream:
        for name, content in _summarize(studies, run):
            stream.log(name, content, static=True)
        for study in studies:
            _log_study(stream, study)


def tabulate_rows(report: SavedReport) -> str:
    """The numbers of a report as a Markdown table; of a long or wide one the first, and where all of them are."""
    columns = lay_out_columns(report.rows)
    if not columns:
        return "No numbers."
    shown = columns[:_TABLE_COLUMNS]
    lines = [[column.heading for column in shown], ["---"] * len(shown)]
    lines += map(list, zip(*(column.cells[:_TABLE_ROWS] for column in shown), strict=True))
    table = "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)
    if len(report.rows) > _TABLE_ROWS or len(columns) > _TABLE_COLUMNS:
        table += f"\n\nAll {len(report.rows):,} rows of {len(columns)} columns are in {report.name}.csv."
    return table


def list_claims(studies: Sequence[StudyReview], verdict: Verdict) -> str:
    """The claims of one verdict by study, as Markdown."""
    lines = []
    for study in studies:
        if claims := [claim.text for claim in study.report.claims if claim.verdict == verdict]:
            lines += [f"**{study.name}**", "", *(f"- {claim}" for claim in claims), ""]
    return "\n".join(lines) or "None."


def _summarize(studies: Sequence[StudyReview], run: str) -> Iterator[tuple[str, rr.AsComponents]]:
    counts = count_verdicts(claim for study in studies for claim in study.report.claims)
    yield "/summary/run", make_document(f"# {conclude(counts)}\n\n{run}")
    for verdict in Verdict:
        yield entity_path("summary", "lists", verdict), make_document(list_claims(studies, verdict))
    for name, drawing in draw_claims(collect_claims(studies)).items():
        yield entity_path("summary", "claims", name), drawing


def _log_study(stream: rr.RecordingStream, study: StudyReview) -> None:
    said = [*study.report.said, *map(_write_claim, study.report.claims)]
    words = "\n".join([f"## {study.name}: {study.report.title}", "", *(f"- {line}" for line in said)])
    stream.log(f"{study.origin}/words", make_document(words), static=True)
    stream.log(f"{study.origin}/numbers", make_document(tabulate_rows(study.report)), static=True)
    for name, png in study.figures.items():
        stream.log(study.figure_path(name), rr.EncodedImage(contents=png, media_type="image/png"), static=True)
    for thing, models in study.models.items():
        for method, (points, colors) in models.items():
            every = -(-len(points) // _MODEL_POINTS) or 1
            cloud = rr.Points3D(points[::every], colors=entities.PLAIN_COLOR if colors is None else colors[::every])
            stream.log(study.model_path(thing, method), cloud, static=True)
    curves = study.curves
    line_colors = _color_lines(list(dict.fromkeys(curve.line for curve in curves)))
    for curve in curves:
        path = study.plot_path(curve.plot, curve.quantity) + entity_path(curve.line or "all")
        times = [rr.TimeColumn(name, sequence=curve.times) for name in (curve.timeline, SHARED_TIMELINE)]
        log_curve(stream, path, (line_colors[curve.line], curve.line, 2.0), times, curve.values)


def _color_lines(lines: Sequence[str]) -> dict[str, entities.Color]:
    """The methods' own colours, grey for a control beside them; where there are no methods one for each line."""
    if entities.METHOD_COLORS.keys() & set(lines):
        return {line: entities.METHOD_COLORS.get(line, entities.ENTROPY_COLOR) for line in lines}
    return {line: entities.category_color(i) for i, line in enumerate(lines)}


def _write_claim(claim: Claim) -> str:
    """A claim as Markdown, its verdict in bold and first."""
    return f"**{claim.verdict.capitalize()}**: {claim.text}" + (f" ({claim.evidence})" if claim.evidence else "")
