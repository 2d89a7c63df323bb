"""Starts from the corners of colours: a print tells poses where a shape has no keypoints."""

import numpy as np

from orbitscan.processing.kernels.blas import SingleThreaded
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView


@SingleThreaded()
def propose_by_color(source: PreparedView, target: PreparedView, settings: PairSettings) -> np.ndarray:
    """Propose the likeliest starts T_target_source (B, 4, 4) from matched corners of colours; none without colours."""
    ours, theirs = (source.by_color, target.by_color) if settings.color else (None, None)
    if ours is None or theirs is None or not len(ours.keypoints) or not len(theirs.keypoints):
        return np.empty((0, 4, 4))
    matches = match(ours.descriptors, theirs.descriptors, settings.thorough_matching)
    return propose(ours, theirs, matches, settings.colored)
