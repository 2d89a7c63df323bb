"""Confusion matrices with their numbers and names: a drawing, and a view of it."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review import entities

PIXELS = 24  # of a cell
_EMPTY: entities.Color = (52, 54, 60)
_GRID: entities.Color = (90, 92, 100)
_MARGIN_LEFT, _MARGIN_TOP = 2.6, 1.5  # cells for the names
_LIFT = 0.2  # of a cell: a label is drawn below its point


def draw_matrix(counts: np.ndarray, rows: Sequence[str], columns: Sequence[str]) -> dict[str, rr.AsComponents]:
    """What is logged below a matrix's entity, by name: cells coloured by their share of the row, numbers, names.

    Counts are (R, C). A cell is right, and green, where its row and column have one name; else it is red.
    """
    counts = np.asarray(counts)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    right = np.array([[row == column for column in columns] for row in rows])
    full = np.where(right[..., None], entities.GOOD_COLOR, entities.BAD_COLOR)
    strength = np.where(counts > 0, 0.1 + 0.9 * np.sqrt(share), 0.0)[..., None]  # the root: one in a hundred shows
    cells = ((1 - strength) * np.array(_EMPTY) + strength * full).round().astype(np.uint8)
    image = np.kron(cells, np.ones((PIXELS, PIXELS, 1), np.uint8))
    image[::PIXELS], image[:, ::PIXELS] = _GRID, _GRID
    row, column = np.nonzero(counts)
    numbers = np.stack([column + 0.5, row + 0.5 - _LIFT], axis=1)
    left = [[-0.5 * _MARGIN_LEFT, i + 0.5 - _LIFT] for i in range(len(rows))]
    above = [[j + 0.5, -0.6 - _LIFT] for j in range(len(columns))]
    words = [*(name.replace("_", " ") for name in rows), *(name.replace("_", "\n") for name in columns)]
    return {
        "cells": rr.Image(image),
        "numbers": label_cells(numbers, [f"{count:,}" for count in counts[row, column]]),
        "names": label_cells([*left, *above], words),
    }


def view_matrix(origin: str, name: str, rows: int, columns: int) -> rrb.Spatial2DView:
    """The view of a matrix that is drawn at `origin`."""
    return view_cells(origin, name, (-_MARGIN_LEFT, columns + 0.3), (-_MARGIN_TOP, rows + 0.3))


def view_cells(origin: str, name: str, x: tuple[float, float], y: tuple[float, float]) -> rrb.Spatial2DView:
    """The view of what is drawn at `origin` between two places on each axis, in cells."""
    x_range, y_range = ((PIXELS * low, PIXELS * high) for low, high in (x, y))
    bounds = rrb.VisualBounds2D(x_range=x_range, y_range=y_range)
    return rrb.Spatial2DView(origin=origin, name=name, background=entities.BACKGROUND, visual_bounds=bounds)


def label_cells(cells: Sequence[Sequence[float]] | np.ndarray, labels: Sequence[str]) -> rr.Points2D:
    """Words at places (N, 2) in cells, white on the dark bubble that Rerun puts behind labels in either theme."""
    places = np.array(cells, float).reshape(-1, 2) * PIXELS
    return rr.Points2D(places, labels=labels, show_labels=True, radii=0.01, colors=entities.LABEL_COLOR, draw_order=1.0)
