"""What a batch's recordings are taken for: confusion matrices counted from their results, as CSV."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orbitscan.processing.results.classification import UNKNOWN
from orbitscan.processing.results.folder import Results
from orbitscan.recorder.atomic import whole_file

FEWEST = 2  # recordings that make a batch


@dataclass(frozen=True)
class Answer:
    """What a recording is, and what its views together are taken for."""

    session: str
    category: str  # as recorded
    found: str  # a category of the model, or UNKNOWN
    likeliest: str
    probability: float  # of the likeliest
    right: bool


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of recordings and of views alone; row: true category, column: the one found; the last is UNKNOWN."""

    names: tuple[str, ...]  # of the C rows and of the columns
    sessions: np.ndarray  # (C, C), fused over a session's views
    views: np.ndarray  # (C, C), each view alone
    answers: tuple[Answer, ...]


def count_confusion(sessions: Sequence[Results]) -> Confusion | None:
    """The confusion of the sessions whose category is known and which were classified.

    None where they are fewer than FEWEST. What the model has no category for is in the row UNKNOWN.
    """
    judged = [
        (session.session, session.session.category, session.classification)
        for session in sorted(sessions, key=lambda session: session.session.name)
        if session.session.category and session.classification
    ]
    if len(judged) < FEWEST:
        return None
    categories = dict.fromkeys(name for _, _, found in judged for name in found.categories)
    names = (*(name for name in categories if name != UNKNOWN), UNKNOWN)
    fused, views = np.zeros((2, len(names), len(names)), np.int64)
    answers = []
    for facts, category, found in judged:
        truth = category if category in found.categories else UNKNOWN
        row = names.index(truth)
        fused[row, names.index(found.answer)] += 1
        for view in found.views:
            views[row, names.index(view.answer)] += 1
        right = found.answer == truth
        answers.append(Answer(facts.name, category, found.answer, found.likeliest, found.probability, right))
    return Confusion(names, fused, views, tuple(answers))


def tabulate(found: Confusion) -> list[tuple[str, str, str, str]]:
    """A row per true category that occurs: its name, recordings right, views right, what recordings are taken for."""
    rows = []
    for i, name in enumerate(found.names):
        if total := int(found.sessions[i].sum()):
            wrong = [(int(n), other) for n, other in zip(found.sessions[i], found.names, strict=True) if other != name]
            taken = ", ".join(f"{other} {n}" for n, other in sorted(wrong, key=lambda w: -w[0]) if n)
            views = found.views[i, i] / max(found.views[i].sum(), 1)
            rows.append((name, f"{found.sessions[i, i]} of {total}", f"{views:.1%}", taken))
    return rows


def write_csv(path: Path, found: Confusion) -> None:
    """Both matrices as one table, a row per true category; whole or not at all. Raises UnwritableOutput."""
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("counted", "true", *found.names))
        for counted, counts in (("recordings", found.sessions), ("views", found.views)):
            table.writerows((counted, name, *row) for name, row in zip(found.names, counts.tolist(), strict=True))
