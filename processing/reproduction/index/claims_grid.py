"""The verdicts of all claims at a glance: a row for each study, a coloured cell for each claim."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.reproduction.claims import Claim, Verdict
from orbitscan.processing.review import entities
from orbitscan.processing.review.matrix import PIXELS, label_cells, view_cells

_COLORS = {Verdict.HOLDS: entities.GOOD_COLOR, Verdict.FAILS: entities.BAD_COLOR, Verdict.OPEN: entities.ENTROPY_COLOR}
_MARKS = {Verdict.HOLDS: "yes", Verdict.FAILS: "no", Verdict.OPEN: "?"}  # for those who do not tell the colours apart
_GAP = 2
_NAMES = 4.5  # cells for a study's name
_LIFT = 0.25  # of a cell: a label is drawn below its point
_COLUMNS = 10  # a study with more claims goes on in the next row


def draw_claims(claims: Mapping[str, Sequence[Claim]]) -> dict[str, rr.AsComponents]:
    """The grid of each study's claims, given by the study's name: what to log below its entity, by name."""
    rows = _break_rows(claims)
    image = np.full((len(rows) * PIXELS, _COLUMNS * PIXELS, 3), entities.BACKGROUND, np.uint8)
    places, marks = [], []
    for row, (_, found) in enumerate(rows):
        for column, claim in enumerate(found):
            top, left = row * PIXELS + _GAP, column * PIXELS + _GAP
            image[top : top + PIXELS - 2 * _GAP, left : left + PIXELS - 2 * _GAP] = _COLORS[claim.verdict]
            places.append((column + 0.5, row + 0.5 - _LIFT))
            marks.append(_MARKS[claim.verdict])
    names = {row: name for row, (name, _) in enumerate(rows) if name}
    return {
        "cells": rr.Image(image),
        "marks": label_cells(places, marks),
        "studies": label_cells([(-0.5 * _NAMES, row + 0.5 - _LIFT) for row in names], list(names.values())),
    }


def view_claims(origin: str, claims: Mapping[str, Sequence[Claim]]) -> rrb.Spatial2DView:
    """The view of the grid of these claims, whose entity is `origin`."""
    title = "Claims of the thesis: green holds, red does not, grey cannot be told"
    return view_cells(origin, title, (-_NAMES, _COLUMNS + 0.3), (-0.5, len(_break_rows(claims)) + 0.5))


def _break_rows(claims: Mapping[str, Sequence[Claim]]) -> list[tuple[str, Sequence[Claim]]]:
    """Each row's name, '' where it goes on with the study above, and its claims; one row at least."""
    rows: list[tuple[str, Sequence[Claim]]] = [
        (name if start == 0 else "", found[start : start + _COLUMNS])
        for name, found in claims.items()
        for start in range(0, len(found), _COLUMNS)
    ]
    return rows or [("", [])]
