"""The verdicts of all claims at a glance: a row for each study, a coloured cell for each claim."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.reproduction.verdicts import VERDICTS
from orbitscan.processing.review import entities

VERDICT_COLORS = dict(zip(VERDICTS, (entities.GOOD_COLOR, entities.BAD_COLOR, entities.ENTROPY_COLOR), strict=True))
MARKS = dict(zip(VERDICTS, ("yes", "no", "?"), strict=True))  # no colour alone tells what another does not
_PIXELS = 24  # of a cell
_GAP = 2
_NAMES = 4.5  # cells for a study's name
_LIFT = 0.25  # of a cell: a label is drawn below its point
_COLUMNS = 10  # a study with more claims goes on in the next row


def draw_claims(verdicts: Mapping[str, Sequence[str]]) -> dict[str, rr.AsComponents]:
    """What is logged below the grid's entity, by name; the verdicts of each study's claims, by its name."""
    rows = _break_rows(verdicts)
    image = np.full((len(rows) * _PIXELS, _COLUMNS * _PIXELS, 3), entities.BACKGROUND, np.uint8)
    places, marks = [], []
    for row, (_, found) in enumerate(rows):
        for column, verdict in enumerate(found):
            top, left = row * _PIXELS + _GAP, column * _PIXELS + _GAP
            image[top : top + _PIXELS - 2 * _GAP, left : left + _PIXELS - 2 * _GAP] = VERDICT_COLORS[verdict]
            places.append((column + 0.5, row + 0.5 - _LIFT))
            marks.append(MARKS[verdict])
    names = {row: name for row, (name, _) in enumerate(rows) if name}
    return {
        "cells": rr.Image(image),
        "marks": _label(places, marks),
        "studies": _label([(-0.5 * _NAMES, row + 0.5 - _LIFT) for row in names], list(names.values())),
    }


def view_claims(origin: str, verdicts: Mapping[str, Sequence[str]]) -> rrb.Spatial2DView:
    """The view of the grid that is drawn at `origin`."""
    rows = len(_break_rows(verdicts))
    return rrb.Spatial2DView(
        origin=origin,
        name="Claims of the thesis: green holds, red does not, grey cannot be told",
        background=entities.BACKGROUND,
        visual_bounds=rrb.VisualBounds2D(
            x_range=(-_NAMES * _PIXELS, (_COLUMNS + 0.3) * _PIXELS), y_range=(-0.5 * _PIXELS, (rows + 0.5) * _PIXELS)
        ),
    )


def _break_rows(verdicts: Mapping[str, Sequence[str]]) -> list[tuple[str, Sequence[str]]]:
    """Each row's name, '' where it goes on with the study above, and its verdicts; one row at least."""
    rows = [
        (name if start == 0 else "", found[start : start + _COLUMNS])
        for name, found in verdicts.items()
        for start in range(0, len(found), _COLUMNS)
    ]
    return rows or [("", [])]


def _label(cells: Sequence[tuple[float, float]], labels: Sequence[str]) -> rr.Points2D:
    """Words at places in cells."""
    places = np.array(cells, float).reshape(-1, 2) * _PIXELS
    return rr.Points2D(places, labels=labels, show_labels=True, radii=0.01, colors=(255, 255, 255), draw_order=1.0)
