"""The studies of a reproduction -> .rrd: which claims hold, then each figure with its words, numbers and curves."""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from processing.review import entities
from processing.review.claims_grid import draw_claims, view_claims
from processing.review.columns import lay_out_columns, name_column
from processing.review.study_curves import Curve, find_curves, find_timeline
from processing.review.verdicts import VERDICTS, Statement, conclude, count_verdicts
from recorder.exceptions import UnwritableOutput

HEADINGS = dict(zip(VERDICTS, ("Holds", "Does not hold", "Cannot be told"), strict=True))
SHARED_TIMELINE = "step_or_view"  # the viewer plots over one timeline at a time: here all curves are on it
_MODEL_POINTS = 20_000
_TABLE_ROWS = 30
_TABLE_COLUMNS = 13
_WIDE = 1.7  # width to height of a figure below which its words stand, not beside it


@dataclass(frozen=True, eq=False)
class StudyReview:
    """A study as it is shown."""

    report: Mapping[str, Any]  # its JSON
    figures: Mapping[str, bytes] = field(default_factory=dict)  # PNG, by name
    models: Mapping[str, tuple[np.ndarray, np.ndarray | None]] = field(default_factory=dict)  # points (N, 3), colours

    @property
    def name(self) -> str:
        """As the command names it."""
        return self.report["name"]

    @property
    def origin(self) -> str:
        """The entity that all of it is below."""
        return _path("studies", self.name)


def write_reproduction(path: Path, groups: Mapping[str, Sequence[StudyReview]], run: str) -> None:
    """Write the studies, by group, as a Rerun recording, whole or not at all; `run`: what was run, as Markdown.

    Raises UnwritableOutput.
    """
    part = path.with_name(path.name + ".part")
    studies = [study for group in groups.values() for study in group]
    try:
        with rr.RecordingStream(
            entities.APPLICATION_ID,
            recording_id=f"{entities.APPLICATION_ID}-reproduction",
            send_properties=False,  # they hold the time of writing
            batcher_config=rr.ChunkBatcherConfig.NEVER(),
        ) as stream:
            stream.set_log_time_enabled(False)
            stream.save(part, default_blueprint=lay_out(groups))
            stream.send_recording_name("reproduction")
            for name, content in _summarize(studies, run):
                stream.log(name, content, static=True)
            for study in studies:
                _log_study(stream, study)
        part.replace(path)
    except (OSError, RuntimeError) as error:
        part.unlink(missing_ok=True)
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise UnwritableOutput(path, f"cannot be written ({reason})", "choose another place with -o") from None


def lay_out(groups: Mapping[str, Sequence[StudyReview]]) -> rrb.Blueprint:
    """The claims in the first tab, then a tab for each group, with one for each study."""
    tabs = [rrb.Tabs(*map(_view_study, group), name=name) for name, group in groups.items() if group]
    studies = [study for group in groups.values() for study in group]
    curves = any(find_timeline(study.report["rows"]) for study in studies)
    return rrb.Blueprint(
        rrb.Tabs(_view_summary(studies), *tabs, active_tab=0),
        rrb.TimePanel(state="collapsed", timeline=SHARED_TIMELINE) if curves else rrb.TimePanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def tabulate_rows(report: Mapping[str, Any]) -> str:
    """The numbers of a report as a Markdown table; of a long or wide one the first, and where all of them are."""
    rows = report["rows"]
    columns = lay_out_columns(rows)
    if not columns:
        return "No numbers."
    shown = columns[:_TABLE_COLUMNS]
    lines = [[column.heading for column in shown], ["---"] * len(shown)]
    lines += list(zip(*(column.cells[:_TABLE_ROWS] for column in shown), strict=True))
    table = "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)
    if len(rows) > _TABLE_ROWS or len(columns) > _TABLE_COLUMNS:
        table += f"\n\nAll {len(rows):,} rows of {len(columns)} columns are in {report['name']}.csv."
    return table


def list_claims(studies: Sequence[StudyReview], verdict: str) -> str:
    """The claims of one verdict by study, as Markdown."""
    lines = []
    for study in studies:
        statements = [Statement.read(sentence) for sentence in study.report["said"]]
        claims = [statement.claim for statement in statements if statement.verdict == verdict]
        if claims:
            lines += [f"**{study.name}**", "", *(f"- {claim}" for claim in claims), ""]
    return "\n".join(lines) or "None."


def _summarize(studies: Sequence[StudyReview], run: str) -> Iterator[tuple[str, rr.AsComponents]]:
    counts = count_verdicts(sentence for study in studies for sentence in study.report["said"])
    yield "/summary/run", _document(f"# {conclude(counts)}\n\n{run}")
    for verdict in VERDICTS:
        yield _path("summary", "lists", verdict), _document(list_claims(studies, verdict))
    for name, drawing in draw_claims(_collect_verdicts(studies)).items():
        yield _path("summary", "claims", name), drawing


def _view_summary(studies: Sequence[StudyReview]) -> rrb.Horizontal:
    lists = [rrb.TextDocumentView(origin=_path("summary", "lists", v), name=HEADINGS[v]) for v in VERDICTS]
    return rrb.Horizontal(
        rrb.Vertical(
            rrb.TextDocumentView(origin="/summary/run", name="What was run"),
            view_claims("/summary/claims", _collect_verdicts(studies)),
            row_shares=[2, 3],
        ),
        *lists,
        column_shares=[3, 2, 2, 2],
        name="Summary",
    )


def _collect_verdicts(studies: Sequence[StudyReview]) -> dict[str, list[str]]:
    """The verdicts of each study that has any, by name."""
    found = {s.name: [Statement.read(sentence).verdict for sentence in s.report["said"]] for s in studies}
    return {name: told for name, verdicts in found.items() if (told := [v for v in verdicts if v])}


def _log_study(stream: rr.RecordingStream, study: StudyReview) -> None:
    said = [_write_statement(sentence) for sentence in study.report["said"]]
    words = "\n".join([f"## {study.name}: {study.report['title']}", "", *(f"- {line}" for line in said)])
    stream.log(f"{study.origin}/words", _document(words), static=True)
    stream.log(f"{study.origin}/numbers", _document(tabulate_rows(study.report)), static=True)
    for name, png in study.figures.items():
        stream.log(_figure(study, name), rr.EncodedImage(contents=png, media_type="image/png"), static=True)
    for name, (points, colors) in study.models.items():
        every = -(-len(points) // _MODEL_POINTS) or 1
        cloud = rr.Points3D(points[::every], colors=entities.PLAIN_COLOR if colors is None else colors[::every])
        stream.log(_model(study, name), cloud, static=True)
    curves = find_curves(study.report["rows"])
    lines = list(dict.fromkeys(curve.line for curve in curves))
    for curve in curves:
        color = entities.METHOD_COLORS.get(curve.line, entities.category_color(lines.index(curve.line)))
        style = rr.SeriesLines(colors=[color], names=[curve.line], widths=[2.0])
        stream.log(_curve(study, curve), style, static=True)
        times = [rr.TimeColumn(name, sequence=curve.times) for name in (curve.timeline, SHARED_TIMELINE)]
        stream.send_columns(_curve(study, curve), times, rr.Scalars.columns(scalars=curve.values))


def _view_study(study: StudyReview) -> rrb.Container:
    words = [
        rrb.TextDocumentView(origin=f"{study.origin}/words", name="In words"),
        rrb.TextDocumentView(origin=f"{study.origin}/numbers", name="Numbers"),
    ]
    figures = [
        rrb.Spatial2DView(origin=_figure(study, name), name=name, background=(255, 255, 255)) for name in study.figures
    ]
    shown = [*figures, *_view_models(study)]
    below = [rrb.Horizontal(*words)]
    if curves := find_curves(study.report["rows"]):
        below = [_view_curves(study, curves), rrb.Horizontal(*words)]
    if not shown:
        return rrb.Vertical(*below, name=study.name)
    picture = shown[0] if len(shown) == 1 else rrb.Tabs(*shown)
    if curves or all(_aspect(png) > _WIDE for png in study.figures.values()):
        return rrb.Vertical(picture, *below, row_shares=[3, *([2] * len(below))], name=study.name)
    return rrb.Horizontal(picture, rrb.Vertical(*words), column_shares=[3, 2], name=study.name)


def _view_models(study: StudyReview) -> list[rrb.Container]:
    views = [
        rrb.Spatial3DView(origin=_model(study, name), name=name, background=entities.BACKGROUND, line_grid=False)
        for name in study.models
    ]
    return [rrb.Grid(*views, name="Models")] if views else []


def _view_curves(study: StudyReview, curves: Sequence[Curve]) -> rrb.Container:
    plots = []
    for plot in dict.fromkeys(curve.plot for curve in curves):
        quantities = dict.fromkeys(curve.quantity for curve in curves if curve.plot == plot)
        views = [
            rrb.TimeSeriesView(
                origin=_path("studies", study.name, "curves", plot or "all", quantity),
                name=name_column(quantity),
                plot_legend=rrb.Corner2D.RightBottom if i == 0 else rrb.PlotLegend(visible=False),
            )
            for i, quantity in enumerate(quantities)
        ]
        plots.append(rrb.Horizontal(*views, name=plot))
    return plots[0] if len(plots) == 1 else rrb.Tabs(*plots)


def _write_statement(sentence: str) -> str:
    """A sentence as Markdown, its verdict in bold and first."""
    statement = Statement.read(sentence)
    if statement.verdict is None:
        return statement.claim
    return f"**{HEADINGS[statement.verdict]}**: {statement.claim}" + (
        f" ({statement.evidence})" if statement.evidence else ""
    )


def _figure(study: StudyReview, name: str) -> str:
    return _path("studies", study.name, "figures", name)


def _model(study: StudyReview, name: str) -> str:
    return _path("studies", study.name, "models", name)


def _curve(study: StudyReview, curve: Curve) -> str:
    return _path("studies", study.name, "curves", curve.plot or "all", curve.quantity, curve.line or "all")


def _path(*parts: str) -> str:
    return "/" + "/".join(map(rr.escape_entity_path_part, parts))


def _aspect(png: bytes) -> float:
    """Width to height of a PNG picture."""
    width, height = struct.unpack(">II", png[16:24])
    return width / height


def _document(markdown: str) -> rr.TextDocument:
    return rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN)
