"""Two results side by side -> .rrd: the verdict, the models of A and B, their errors in one plot, what changed."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.results.comparison.records import Comparison, SessionComparison
from orbitscan.processing.results.estimates import ViewEstimate
from orbitscan.processing.results.folder import Extent, ResultsFolder, read_results
from orbitscan.processing.review import entities
from orbitscan.processing.review.comparison import words
from orbitscan.processing.review.curves import ROUNDING, log_curve
from orbitscan.processing.review.entities import entity_path
from orbitscan.processing.review.markdown import write_table
from orbitscan.processing.review.panels import HIDDEN, make_blueprint, view_3d, view_curves
from orbitscan.processing.review.stream import make_document, whole_recording

SHOWN_SESSIONS = 6  # of a batch, the worst: each with both models
SHOWN_VIEWS = 40  # of a session's table of changes
SHOWN_ROWS = 100  # of a batch's table
_POINT_BYTES = 20  # of a model's point in the file, at most
_MOVED = ("moved_mm", "How far apart A and B put the object's centre, log10 [mm]")
_SIDES = ("a", "b")
_PALE = 0.55  # how far A's colours are from the method's, towards grey


def write_comparison(path: Path, found: Comparison, a: Path, b: Path) -> None:
    """Write a comparison of the results in two folders as a Rerun recording, whole or not at all.

    Sessions that changed are shown, or the only one. Raises UnwritableOutput.
    """
    batch = not (a / "results.json").is_file()
    sessions = [s for s in found.sessions if s.verdict != "same"][:SHOWN_SESSIONS] if batch else list(found.sessions)
    runs = {s.name: [read_results(side / s.name if batch else side) for side in (a, b)] for s in sessions}
    size = sum(_POINT_BYTES * len(run.model[0]) for pair in runs.values() for run in pair if run.model is not None)
    with whole_recording(path, f"comparison-{path.stem}", _lay_out(sessions, runs, batch), size + (4 << 20)) as stream:
        stream.log("/summary", make_document(_summarize(found)), static=True)
        for session in sessions:
            _log_session(stream, session, *runs[session.name])


def _summarize(found: Comparison) -> str:
    notes = [f"- {note}" for note in words.list_notes(found.sessions)]
    lines = ["## A and B", "", f"**{words.conclude(found)}**", "", *notes, ""]
    changed = [session for session in found.sessions if session.verdict != "same"]
    if changed:
        lines += [*write_table(words.SESSION_HEADER, words.session_rows(changed[:SHOWN_ROWS])), ""]
    if len(changed) > SHOWN_SESSIONS:
        lines += [f"The worst {SHOWN_SESSIONS} have a tab each.", ""]
    return "\n".join([*lines, words.FLOOR_WORDS])


def _log_session(stream: rr.RecordingStream, session: SessionComparison, a: ResultsFolder, b: ResultsFolder) -> None:
    origin = entity_path(session.name)
    stream.log(f"{origin}/words", make_document(words.describe_session(session, SHOWN_VIEWS)), static=True)
    for side, run in zip(_SIDES, (a, b), strict=True):
        if run.model is not None:
            points, colors = run.model
            drawn = rr.Points3D(points, colors=entities.PLAIN_COLOR if colors is None else colors, radii=-1.5)
            stream.log(f"{origin}/model/{side}", drawn, static=True)
        for method in session.methods:
            for quantity, values in _errors(run.results.reconstruction[method].views):
                name, color = f"{side.upper()} {method}", _color(method, side)
                _log_curve(stream, f"{origin}/errors/{quantity}/{method}_{side}", name, color, values)
    for method in session.methods:
        moved = {v.view: 1e3 * v.moved_m for v in session.views if v.method == method and v.moved_m is not None}
        path = f"{origin}/{_MOVED[0]}/{method}"
        _log_curve(stream, path, method, entities.METHOD_COLORS[method], moved)
    if session.methods:
        best = list(session.methods)[-1]
        known = {v.view: v.floor_m for v in session.views if v.method == best and v.floor_m is not None}
        floors = {view: 1e3 * floor for view, floor in known.items() if floor > ROUNDING}  # the first view has none
        path = f"{origin}/{_MOVED[0]}/floor"
        _log_curve(stream, path, f"chance, {best}", entities.ENTROPY_COLOR, floors)


def _errors(views: Sequence[ViewEstimate]) -> Iterator[tuple[str, dict[int, float]]]:
    """Each error by view, in the units of its plot."""
    for quantity, (_, error, factor) in entities.LOG_ERRORS.items():
        errors = {view.view: getattr(view.errors, entities.error_field(error)) for view in views}
        yield quantity, {view: factor * value for view, value in errors.items() if value is not None}


def _log_curve(
    stream: rr.RecordingStream, path: str, name: str, color: entities.Color, values: Mapping[int, float]
) -> None:
    """The logarithms of a curve's values; those that are rounding have none."""
    known = {view: float(np.log10(value)) for view, value in values.items() if value > ROUNDING}
    if known:
        times = rr.TimeColumn(entities.VIEW_TIMELINE, sequence=list(known))
        log_curve(stream, path, (color, name, 2.0), [times], list(known.values()))


def _lay_out(
    sessions: Sequence[SessionComparison], runs: Mapping[str, Sequence[ResultsFolder]], batch: bool
) -> rrb.Blueprint:
    summary = rrb.TextDocumentView(origin="/summary", name="Summary")
    tabs = [_lay_out_session(session.name, *runs[session.name]) for session in sessions]
    return make_blueprint(
        rrb.Tabs(summary, *tabs) if batch else tabs[0],
        rrb.TimePanel(state="collapsed", timeline=entities.VIEW_TIMELINE, play_state="following"),
    )


def _lay_out_session(name: str, a: ResultsFolder, b: ResultsFolder) -> rrb.Vertical:
    origin = entity_path(name)
    eye = _look_at(a.extent or b.extent)
    models = [
        view_3d(f"{origin}/model/{side}", f"Model of {side.upper()}: {run.path}", eye)
        for side, run in zip(_SIDES, (a, b), strict=True)
        if run.model is not None
    ]
    titles = {f"errors/{quantity}": _title(quantity) for quantity in entities.LOG_ERRORS} if _has_truth(a, b) else {}
    titles |= dict([_MOVED])
    legends = (next(iter(titles)), _MOVED[0])  # the errors have the same curves
    plots = [
        view_curves(f"{origin}/{place}", title, rrb.Corner2D.LeftTop if place in legends else HIDDEN)
        for place, title in titles.items()
    ]
    changes = rrb.TextDocumentView(origin=f"{origin}/words", name="What changed")
    above = [rrb.Horizontal(*models)] if models else []
    return rrb.Vertical(
        *above,
        rrb.Horizontal(rrb.Grid(*plots, grid_columns=min(2, len(plots))), changes, column_shares=[3, 2]),
        row_shares=[2, 3] if models else None,
        name=name,
    )


def _title(quantity: str) -> str:
    _, error, _ = entities.LOG_ERRORS[quantity]
    unit = " [mm]" if quantity.endswith("_mm") else ""
    return f"{entities.ERRORS[error].split('[')[0].strip(' ,')}, log10{unit}; A pale"


def _has_truth(*runs: ResultsFolder) -> bool:
    methods = (method for run in runs for method in run.results.reconstruction.values())
    return any(view.errors.center_error_m is not None for method in methods for view in method.views)


def _look_at(extent: Extent | None) -> rrb.EyeControls3D | None:
    """An eye behind camera {0} and a little above, whose -y is up: both models are seen from one place."""
    if extent is None:
        return None
    offset = extent.diameter * np.array([0.35, -0.55, -1.2])
    return rrb.EyeControls3D(position=extent.center + offset, look_target=extent.center, eye_up=(0.0, -1.0, 0.0))


def _color(method: str, side: str) -> entities.Color:
    color = np.array(entities.METHOD_COLORS[method], float)
    if side == "a":
        color = (1 - _PALE) * color + _PALE * np.array(entities.ENTROPY_COLOR)
    r, g, b = color.round().astype(int).tolist()
    return r, g, b
