"""Starts for the registration of a pair: poses that single correspondences propose and geometry does not refute.

A correspondence with its two local reference frames is a whole pose (Buch, Pose estimation using local structure,
2013): every one is a hypothesis, so that even few right ones among many wrong are enough, where samples of three would
hardly ever be free of wrong ones.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitscan.processing.registration.correspondences import Target, nearest_surfel
from orbitscan.processing.registration.free_space import RangeImage
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.registration.ransac import count_inliers
from orbitscan.recorder.kernels import kernel, over_slices

_NO_IMAGE = RangeImage(np.eye(4), 1.0, np.zeros(2), np.empty((0, 0)), np.empty((0, 0), np.bool_))  # without pixels


@dataclass(frozen=True)
class StartSettings:
    """How starts are proposed and sifted; lengths in multiples of the working resolution; not in the thesis."""

    # Every correspondence proposes a pose; the best supported ones are looked at more closely.
    tolerance: float = 5.0  # a correspondence that lies so near under a hypothesis supports it
    hypotheses: int = 250

    # The look: whether a few points of the source lie on the target, or where its sensor saw that nothing is.
    screen_points: int = 120
    screen_gate: float = 6.0  # a point so near to a surface that faces the same way lies on it
    screen_front: float = 6.0  # a point so far before a surface contradicts it
    enough_overlap: float = 0.15  # a share about half of what could count: beyond, more proves little
    contradiction: float = 3.0  # what one contradiction costs, in points that fit; half where a sensor saw nothing

    # What is kept.
    worth: float = 0.5  # share of the best score
    distinct_deg: float = 12.0  # starts less apart end in one place ...
    distinct_shift: float = 0.06  # ... unless they are moved by more than this share of the diameter
    most: int = 6


def propose(source: PreparedView, target: PreparedView, matches: np.ndarray, settings: StartSettings) -> np.ndarray:
    """Propose the likeliest starts T_target_source (B, 4, 4), best first, from matches (M, 2) of keypoints; B may be 0.

    Matched keypoints have descriptors, and so local reference frames.
    """
    w = source.scale.working
    source_points = np.ascontiguousarray(source.keypoints[matches[:, 0]])
    target_points = np.ascontiguousarray(target.keypoints[matches[:, 1]])
    hypotheses = _from_frames(source_points, target_points, source.frames[matches[:, 0]], target.frames[matches[:, 1]])
    counts = count_inliers(source_points, target_points, hypotheses, settings.tolerance * w)
    hypotheses = hypotheses[np.argsort(-counts, kind="stable")[: settings.hypotheses]]
    score = screen(hypotheses, source, target, settings)
    ranked = np.argsort(-score, kind="stable")
    ranked = ranked[score[ranked] >= settings.worth * score.max(initial=0.0)]
    return _keep_distinct(hypotheses[ranked], source, settings)


def screen(T: np.ndarray, source: PreparedView, target: PreparedView, settings: StartSettings) -> np.ndarray:
    """Score (B,) how well a few points of the source fit the target under each of many poses T_target_source (B, 4, 4).

    At most 1; less than 0 where more contradicts than fits. Nothing contradicts where the target's sensor is unknown.
    """
    w = source.scale.working
    few = source.coarse_surfels.thinned(settings.screen_points)
    image = _NO_IMAGE if target.range_image is None else target.range_image
    gate, front = settings.screen_gate * w, settings.screen_front * w
    look = _Look(few.points, few.normals, target.coarse_target, gate, image, front)
    overlaps, contradictions = np.empty(len(T)), np.empty(len(T))
    over_slices(_screen, len(T), np.ascontiguousarray(T), look, overlaps, contradictions)
    reach = (1 + settings.enough_overlap) * overlaps / (overlaps + settings.enough_overlap)
    return reach - settings.contradiction * contradictions


def _from_frames(
    source: np.ndarray, target: np.ndarray, source_frames: np.ndarray, target_frames: np.ndarray
) -> np.ndarray:
    """The motions (M, 4, 4) that take source points (M, 3) with frames (M, 3, 3), rows x y z, onto the target's."""
    T = np.zeros((len(source), 4, 4))
    T[:, :3, :3] = np.einsum("mki,mkj->mij", target_frames, source_frames)
    T[:, :3, 3] = target - np.einsum("mij,mj->mi", T[:, :3, :3], source)
    T[:, 3, 3] = 1.0
    return T


def _keep_distinct(T: np.ndarray, source: PreparedView, settings: StartSettings) -> np.ndarray:
    """Keep those of the poses (B, 4, 4) that differ from all kept before them, at most `settings.most`."""
    center = source.coarse_surfels.points.mean(axis=0)
    places = T[:, :3, :3] @ center + T[:, :3, 3]
    chordal = 2 * np.sqrt(2) * np.sin(np.radians(settings.distinct_deg) / 2)
    kept: list[int] = []
    open_ = np.ones(len(T), bool)
    while open_.any() and len(kept) < settings.most:
        first = int(open_.argmax())
        kept.append(first)
        apart = np.linalg.norm(T[:, :3, :3] - T[first, :3, :3], axis=(1, 2)) > chordal
        shifted = np.linalg.norm(places - places[first], axis=1) > settings.distinct_shift * source.scale.diameter
        open_ &= apart | shifted
    return T[kept]


class _Look(NamedTuple):
    """What is looked at under every pose: a few points of the source, and what they may lie on or contradict."""

    points: np.ndarray  # (N, 3)
    normals: np.ndarray  # (N, 3)
    target: Target
    gate: float  # [m] to a surface, within which a point lies on it
    image: RangeImage
    front: float  # [m] before a surface, from which on a point contradicts it


@kernel
def _screen(
    start: int, stop: int, T: np.ndarray, look: _Look, overlaps: np.ndarray, contradictions: np.ndarray
) -> None:
    """Fill the share of points on the target's surface, and of those where nothing can be (unseen ones count half).

    Overlaps and contradictions are (B,), of poses T (B, 4, 4); their rows [start, stop) are filled.
    """
    points, normals, target, gate = look.points, look.normals, look.target, look.gate
    T_image_view, size, corner = look.image.T_image_view, look.image.size, look.image.low
    near, empty, front = look.image.near, look.image.empty, look.front
    rows = np.empty((9, 2), np.int64)
    p, normal, q = np.empty(3), np.empty(3), np.empty(3)
    height, width = near.shape
    for h in range(start, stop):
        on, against = 0, 0.0
        for i in range(len(points)):
            for k in range(3):
                p[k] = T[h, k, 0] * points[i, 0] + T[h, k, 1] * points[i, 1] + T[h, k, 2] * points[i, 2] + T[h, k, 3]
                normal[k] = T[h, k, 0] * normals[i, 0] + T[h, k, 1] * normals[i, 1] + T[h, k, 2] * normals[i, 2]
            if nearest_surfel(target, p, normal, gate, rows) >= 0:
                on += 1
            elif height > 0:
                for k in range(3):
                    q[k] = T_image_view[k, 3]
                    for m in range(3):
                        q[k] += T_image_view[k, m] * p[m]
                if q[2] <= 0.0:
                    against += 1.0
                    continue
                column = int(np.floor((q[0] / q[2] - corner[0]) / size))
                row = int(np.floor((q[1] / q[2] - corner[1]) / size))
                if not (0 <= column < width and 0 <= row < height) or empty[row, column]:
                    against += 0.5
                elif q[2] < near[row, column] - front:
                    against += 1.0
        overlaps[h], contradictions[h] = on / len(points), against / len(points)
