"""A batch's confusion: its matrices of recordings and of views, and in words which recordings are wrong."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.results.confusion import Confusion
from orbitscan.processing.review.markdown import write_table
from orbitscan.processing.review.matrix import draw_matrix, view_matrix

_MATRICES = {
    "sessions": "Recordings, fused over their views: true category (row), found one (column)",
    "views": "Views, each alone: true category (row), found one (column)",
}


def log_confusion(stream: rr.RecordingStream, found: Confusion) -> None:
    """Write both matrices below `/confusion`."""
    for matrix in _MATRICES:
        for name, drawing in draw_matrix(getattr(found, matrix), found.names, found.names).items():
            stream.log(f"/confusion/{matrix}/{name}", drawing, static=True)


def view_confusion(names: int) -> rrb.Horizontal:
    """The two matrices side by side, of so many categories."""
    views = [view_matrix(f"/confusion/{matrix}", title, names, names) for matrix, title in _MATRICES.items()]
    return rrb.Horizontal(*views, name="Categories")


def describe_confusion(found: Confusion) -> list[str]:
    """How many are right, and each recording that is not, as lines of Markdown."""
    lines = [f"**Categories.** {count_right(found)}", ""]
    wrong = [answer for answer in found.answers if not answer.right]
    if wrong:
        cells = [(a.session, a.category, a.found, f"{a.likeliest} {a.probability:.0%}") for a in wrong]
        lines += write_table(["recording", "category", "taken for", "likeliest"], cells)
    return lines


def count_right(found: Confusion) -> str:
    """One sentence: how many recordings are right, and how many views alone."""
    parts = []
    for counts, nouns in ((found.sessions, "recordings"), (found.views, "views alone")):
        right, total = int(np.trace(counts)), int(counts.sum())
        parts.append(f"{right:,} of {total:,} {nouns} ({right / max(total, 1):.1%})")
    return f"Right: {parts[0]}, {parts[1]}."
