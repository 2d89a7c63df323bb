"""A batch's confusion -> .rrd: its matrices of recordings and of views, and in words which recordings are wrong."""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from processing.results.confusion import Answer, Confusion
from processing.review import entities
from processing.review.matrix import draw_matrix, view_matrix
from recorder.exceptions import UnwritableOutput

_MATRICES = {
    "sessions": "Recordings, fused over their views: true category (row), found one (column)",
    "views": "Views, each alone: true category (row), found one (column)",
}


def write_confusion(path: Path, found: Confusion) -> None:
    """Write a confusion as a Rerun recording, whole or not at all. Raises UnwritableOutput."""
    part = path.with_name(path.name + ".part")
    try:
        with rr.RecordingStream(
            entities.APPLICATION_ID,
            recording_id=f"{entities.APPLICATION_ID}-confusion",
            send_properties=False,  # they hold the time of writing
            batcher_config=rr.ChunkBatcherConfig.NEVER(),
        ) as stream:
            stream.set_log_time_enabled(False)
            stream.save(part, default_blueprint=lay_out(len(found.names)))
            stream.send_recording_name("confusion")
            for matrix in _MATRICES:
                for name, drawing in draw_matrix(getattr(found, matrix), found.names, found.names).items():
                    stream.log(f"/confusion/{matrix}/{name}", drawing, static=True)
            words = rr.TextDocument(describe_confusion(found), media_type=rr.MediaType.MARKDOWN)
            stream.log("/summary", words, static=True)
        part.replace(path)
    except (OSError, RuntimeError) as error:
        part.unlink(missing_ok=True)
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise UnwritableOutput(path, f"cannot be written ({reason})", "choose another place with -o") from None


def lay_out(names: int) -> rrb.Blueprint:
    """The two matrices side by side, words below."""
    views = [view_matrix(f"/confusion/{matrix}", title, names, names) for matrix, title in _MATRICES.items()]
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(*views),
            rrb.TextDocumentView(origin="/summary", name="Summary"),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def describe_confusion(found: Confusion) -> str:
    """How many are right, and each recording that is not, as Markdown."""
    lines = ["## Confusion", "", f"**{count_right(found)}**", ""]
    wrong = [answer for answer in found.answers if not answer.right]
    if wrong:
        lines += ["| recording | category | taken for | likeliest |", "| --- | --- | --- | --- |"]
        lines += [f"| {a.session} | {a.category} | {a.found} | {_likeliest(a)} |" for a in wrong]
    return "\n".join(lines)


def count_right(found: Confusion) -> str:
    """One sentence: how many recordings are right, and how many views alone."""
    parts = []
    for counts, nouns in ((found.sessions, "recordings"), (found.views, "views alone")):
        right, total = int(np.trace(counts)), int(counts.sum())
        parts.append(f"{right:,} of {total:,} {nouns} ({right / max(total, 1):.1%})")
    return f"Right: {parts[0]}, {parts[1]}."


def _likeliest(answer: Answer) -> str:
    return f"{answer.likeliest} {answer.probability:.0%}"
