"""EpochRecords -> .rrd: losses, accuracies and the confusion matrix of a training, epoch by epoch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review import entities
from orbitscan.processing.review.curves import draw_line
from orbitscan.processing.review.markdown import write_table
from orbitscan.processing.review.matrix import draw_matrix, view_matrix
from orbitscan.processing.review.panels import HIDDEN, make_blueprint, view_curves
from orbitscan.processing.review.stream import make_document, open_stream
from orbitscan.recorder.atomic import unwritable

if TYPE_CHECKING:
    from orbitscan.processing.classification.evaluation import EpochRecord
    from orbitscan.processing.classification.training import TrainingSettings

EPOCH_TIMELINE = "epoch"  # from 1
_CURVES: dict[str, tuple[entities.Color, str, str]] = {  # colour, name, what it shows of an EpochRecord
    "/loss/training": (entities.METHOD_COLORS["ransac_icp"], "training", "train_loss"),
    "/loss/validation": (entities.METHOD_COLORS["icp"], "validation", "validation_loss"),
    "/accuracy/training": (entities.METHOD_COLORS["ransac_icp"], "training", "train_accuracy"),
    "/accuracy/validation": (entities.METHOD_COLORS["icp"], "validation", "validation_accuracy"),
    "/overfitting": (entities.METHOD_COLORS["refined"], "validation loss - training loss", "overfitting"),
    "/views_per_second": (entities.METHOD_COLORS["pairwise"], "views per second", "views_per_second"),
}
_SHOWN_CONFUSIONS = 5


class TrainingReview:
    """A training's Rerun recording; each epoch is flushed.

    It is written to `model.part.rrd`, which the viewer can open meanwhile and which a killed training leaves behind,
    and becomes `model.rrd` when the training is complete. A training that fails before its first epoch leaves nothing.
    Raises UnwritableOutput where the file cannot be written.
    """

    def __init__(self, path: Path, categories: tuple[str, ...], settings: TrainingSettings) -> None:
        self.path = path
        self.part = path.with_suffix(".part" + path.suffix)
        self._categories = categories
        self._settings = settings
        self._epochs = 0
        self._stream = open_stream(f"{entities.APPLICATION_ID}-training-{path.stem}")
        try:
            self.part.parent.mkdir(parents=True, exist_ok=True)
            self._stream.save(self.part, default_blueprint=lay_out(len(categories)))
        except (OSError, RuntimeError) as error:
            raise unwritable(self.path, error) from None
        self._describe()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stream.disconnect()
        if kind is None:
            try:
                self.part.replace(self.path)
            except OSError as failure:
                raise unwritable(self.path, failure) from None
        elif not self._epochs:
            self.part.unlink(missing_ok=True)

    def add(self, record: EpochRecord) -> None:
        """Writes what is known after an epoch."""
        self._epochs += 1
        self._stream.set_time(EPOCH_TIMELINE, sequence=record.epoch)
        for path, (*_, quantity) in _CURVES.items():
            if np.isfinite(value := getattr(record, quantity)):
                self._stream.log(path, rr.Scalars(value))
        for name, drawing in draw_matrix(np.array(record.confusion), self._categories, self._categories).items():
            self._stream.log(f"/confusion/{name}", drawing)
        self._stream.log("/summary", make_document(describe_epoch(record, self._categories, self._settings.epochs)))
        self._stream.flush()

    def _describe(self) -> None:
        self._stream.send_recording_name(f"training of {self.path.stem}")
        for path, (color, name, _) in _CURVES.items():
            self._stream.log(path, draw_line(color, name), static=True)
        self._stream.log("/settings", make_document(tabulate_settings(self._settings)), static=True)
        self._stream.flush()


def lay_out(categories: int) -> rrb.Blueprint:
    """Curves at the left, the confusion matrix at the right with words below, at the last epoch."""
    return make_blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                _view_curves("/loss", "Loss: cross-entropy [nats]", rrb.Corner2D.RightTop),
                _view_curves("/accuracy", "Accuracy [share of the views]", rrb.Corner2D.RightBottom),
                _view_curves("/overfitting", "Overfitting: validation loss - training loss [nats]"),
                _view_curves("/views_per_second", "Views trained on per second"),
                row_shares=[3, 3, 2, 1],
            ),
            rrb.Vertical(
                view_matrix(
                    "/confusion", "Validation views: true category (row), found one (column)", categories, categories
                ),
                rrb.Tabs(
                    rrb.TextDocumentView(origin="/summary", name="Summary"),
                    rrb.TextDocumentView(origin="/settings", name="Settings"),
                ),
                row_shares=[3, 1],
            ),
            column_shares=[1, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline=EPOCH_TIMELINE, fps=2.0, play_state="following"),
    )


def describe_epoch(record: EpochRecord, categories: tuple[str, ...], epochs: int) -> str:
    """An epoch in words, with the pairs of categories that are confused most, as Markdown."""
    counts = np.array(record.confusion)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    np.fill_diagonal(share, 0.0)
    worst = np.argsort(-share, axis=None, kind="stable")[:_SHOWN_CONFUSIONS]
    confused = [
        f"{categories[true]} taken for {categories[found]}: {share[true, found]:.1%} of its views"
        for true, found in (divmod(int(i), len(categories)) for i in worst)
        if share[true, found] > 0
    ]
    lines = [
        f"## Epoch {record.epoch} of {epochs}",
        "",
        f"Of the validation views **{record.validation_accuracy:.2%}** are right, of the training views "
        f"{record.train_accuracy:.2%}. The loss is {record.validation_loss:.4f} on validation, "
        f"{record.train_loss:.4f} on training: overfitting {record.overfitting:.4f}.",
        "",
    ]
    if confused:
        lines += ["Confused most:", "", *(f"- {pair}" for pair in confused)]
    return "\n".join(lines)


def tabulate_settings(settings: TrainingSettings) -> str:
    """All settings as a Markdown table."""
    return "\n".join(write_table(["setting", "value"], list(_flatten(asdict(settings)))))


def _flatten(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, f"{value}" if value != "" else "(default)"


def _view_curves(origin: str, title: str, legend: rrb.Corner2D | rrb.PlotLegend = HIDDEN) -> rrb.TimeSeriesView:
    axis_y = rrb.ScalarAxis(range=(0.0, 1.02)) if origin == "/accuracy" else None
    return view_curves(origin, title, legend, axis_x=rrb.TimeAxis(link="LinkToGlobal"), axis_y=axis_y)
