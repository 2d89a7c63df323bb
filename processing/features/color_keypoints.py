"""Keypoints where colours have corners, for surfaces whose shape has none: a print on a bottle, a label on a plate."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.processing.surface.appearance import CHANNELS, Appearance
from orbitscan.processing.surface.preparation import Surfels

_SALIENT, _DESCRIBED = 4.0, 10.0  # radii of a corner and of what is described around it, in multiples of w
_MOST = 200
_RINGS, _SECTORS = 3, 8
_CONTRAST = 0.3  # of logarithms, across a corner's radius, in both directions: what is fainter is no corner


class ColorKeypoints(NamedTuple):
    """Corners of colour, with local reference frames and descriptors as those of shape have."""

    points: np.ndarray  # (K, 3)
    descriptors: np.ndarray  # (K, 72) unit
    frames: np.ndarray  # (K, 3, 3) rows x (up the brightness), y, z (the normal)


def detect_color_keypoints(surfels: Surfels, looks: Appearance, w: float) -> ColorKeypoints:
    """Detect and describe the corners of the colours of surfels, the strongest first; w in metres.

    A corner is where colours change in two directions along the surface (Harris and Stephens, A combined corner and
    edge detector, 1988). It is described by the colours in sectors of rings around it, less their mean.
    """
    tree = cKDTree(surfels.points)
    tensors = np.einsum("sci,scj->sij", looks.gradients, looks.gradients)
    neighbors = tree.query_ball_point(surfels.points, _SALIENT * w)
    counts = np.array([len(rows) for rows in neighbors])
    flat = np.concatenate([np.asarray(rows, np.int64) for rows in neighbors]) if len(counts) else np.empty(0, np.int64)
    starts = np.cumsum(counts) - counts
    mean = np.add.reduceat(tensors[flat], starts, axis=0) / counts[:, None, None]
    strength = np.linalg.eigvalsh(mean)[:, 1]  # along the normal there is none: the second is the weaker direction
    slopes = np.add.reduceat(looks.gradients[flat, 0], starts, axis=0) / counts[:, None]
    strongest = np.maximum.reduceat(strength[flat], starts)
    peaks = np.flatnonzero((strength >= strongest) & (strength > (_CONTRAST / (_SALIENT * w)) ** 2))
    peaks = peaks[np.argsort(-strength[peaks], kind="stable")][:_MOST]
    frames = _make_frames(slopes[peaks], surfels.normals[peaks])
    around = tree.query_ball_point(surfels.points[peaks], _DESCRIBED * w)
    described = [
        _describe(frame @ (surfels.points[rows] - surfels.points[peak]).T, looks.values[rows], _DESCRIBED * w)
        for peak, frame, rows in zip(peaks, frames, around, strict=True)
    ]
    return ColorKeypoints(
        surfels.points[peaks], np.array(described).reshape(len(peaks), _RINGS * _SECTORS * CHANNELS), frames
    )


def _make_frames(slopes: np.ndarray, normals: np.ndarray) -> np.ndarray:
    along = slopes - (slopes * normals).sum(axis=1, keepdims=True) * normals
    x = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    return np.stack([x, np.cross(normals, x), normals], axis=1)


def _describe(local: np.ndarray, values: np.ndarray, radius: float) -> np.ndarray:
    """The mean colours (N, 3) in the sectors of rings about a keypoint, less all their mean, as a unit vector (72,).

    `local` (3, N) are coordinates in its frame [m]; the rings are of one area, the sectors' first begins at x."""
    far = np.hypot(local[0], local[1]) / radius
    ring = np.minimum((far**2 * _RINGS).astype(np.int64), _RINGS - 1)
    sector = np.floor((np.arctan2(local[1], local[0]) / (2 * np.pi) % 1) * _SECTORS).astype(np.int64) % _SECTORS
    cell = ring * _SECTORS + sector
    counts = np.bincount(cell, minlength=_RINGS * _SECTORS)
    sums = np.stack([np.bincount(cell, values[:, c], minlength=len(counts)) for c in range(values.shape[1])], axis=1)
    means = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], values.mean(axis=0))
    vector = (means - values.mean(axis=0)).ravel()
    return vector / max(float(np.linalg.norm(vector)), 1e-12)
