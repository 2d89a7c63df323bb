"""What a view shows, what a session's views show together, and whether the model knows it at all."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
import torch
from scipy.special import logsumexp, softmax

from orbitscan.processing.classification import PACKAGED
from orbitscan.processing.classification import checkpoint as files
from orbitscan.processing.classification.calibration import joint_logits, log_probabilities, open_set_scores
from orbitscan.processing.classification.checkpoint import Checkpoint
from orbitscan.processing.classification.labelled_views import FEWEST_POINTS
from orbitscan.processing.classification.voxels import pack, trim, voxel_grids
from orbitscan.processing.results.classification import SessionClassification, ViewClassification
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.session import Session, View

DIGITS = 4  # of a probability: the same on every machine
ODD = 4.0  # standard deviations of log r
_BATCH = 16  # views: more do not fit a processor's cache


def classify(
    scan: Session | Iterable[View] | np.ndarray, model: str | Path = PACKAGED, device: str = "cpu"
) -> SessionClassification | None:
    """What the views of a session show together, or one view given as points (N, 3) [m] (x right, y down, z forward).

    None where no view has points enough. Raises UnreadableModel for a file that holds no model.
    """
    if isinstance(scan, np.ndarray):
        views = [View(0, "", 0, scan)]
    else:
        views = list(scan.views() if isinstance(scan, Session) else scan)
    classifier = Classifier(Path(model), device)
    found = classifier.classify_views([view.index for view in views], [view.points for view in views])
    return classifier.fuse([view for view in found if view is not None])


class Classifier:
    """A trained model at work. Raises UnreadableModel for a file that holds none."""

    def __init__(self, model: Path = PACKAGED, device: str = "cpu") -> None:
        self.path = model
        self.device = device
        self.checkpoint: Checkpoint = files.load(model)
        self.network = self.checkpoint.network(device)

    @property
    def categories(self) -> tuple[str, ...]:
        """The categories it can tell apart."""
        return self.checkpoint.categories

    @cached_property
    def sha256(self) -> str:
        """The hash of the model's file."""
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    def classify_view(self, view: int, points: np.ndarray) -> ViewClassification | None:
        """What one view's points (N, 3) [m] show; None where there are too few. It runs the network once."""
        return self.classify_views([view], [points])[0]

    def classify_views(self, views: Sequence[int], clouds: Sequence[np.ndarray]) -> list[ViewClassification | None]:
        """What each of several views shows, by recorded index and points (N, 3) [m]; None where there are too few."""
        share = self.checkpoint.voxels.trim
        kept = [(i, trim(finite(points)[0], share)) for i, points in enumerate(clouds)]
        kept = [(i, points) for i, points in kept if len(points) >= FEWEST_POINTS]
        results: list[ViewClassification | None] = [None] * len(clouds)
        for start in range(0, len(kept), _BATCH):
            batch = kept[start : start + _BATCH]
            joint, sides = self._joint_logits([points for _, points in batch])
            logs, scores = log_probabilities(joint, self.checkpoint.calibration), open_set_scores(joint)
            for row, (i, _) in enumerate(batch):
                results[i] = self._name(views[i], np.exp(logs[row]), float(scores[row]), sides[row])
        return results

    def fuse(self, views: Sequence[ViewClassification]) -> SessionClassification | None:
        """What the views show together: the geometric mean of their probabilities, renormalised; None for no view.

        The open-set score is the mean of theirs, against a threshold of its own.
        """
        if not views:
            return None
        logs = np.log([[max(v.probabilities[name], 10.0**-DIGITS / 2) for name in self.categories] for v in views])
        means = np.cumsum(logs, axis=0) / np.arange(1, len(views) + 1)[:, None]
        fused = np.exp(means - logsumexp(means, axis=1, keepdims=True))  # after each view
        entropy = -(fused * np.log(np.maximum(fused, 1e-12))).sum(axis=1)
        known = float(np.mean([view.score for view in views])) >= self.checkpoint.calibration.fused_threshold
        best = int(fused[-1].argmax())
        return SessionClassification(
            model=self.sha256,
            categories=self.categories,
            category=self.categories[best] if known else None,
            likeliest=self.categories[best],
            known=known,
            probability=round(float(fused[-1, best]), DIGITS),
            fused=tuple(self._probabilities(row) for row in fused),
            entropy=tuple(round(float(e), DIGITS) for e in entropy),
            views=tuple(views),
        )

    def odd_radius(self, clouds: Sequence[np.ndarray]) -> float | None:
        """The median radius [m] of views where it is ODD deviations or more from every category's; else None."""
        means = np.array(self.checkpoint.calibration.size_means)
        deviations = np.array(self.checkpoint.calibration.size_deviations)
        kept = [points for points in (finite(cloud)[0] for cloud in clouds) if len(points) >= FEWEST_POINTS]
        if not len(means) or not kept:
            return None
        radius = float(pack([trim(p, self.checkpoint.voxels.trim) for p in kept]).spheres[1].median())
        odd = np.abs(np.log(max(radius, 1e-9)) - means) >= ODD * deviations
        return radius if odd.all() else None

    @torch.inference_mode()
    def _joint_logits(self, clouds: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray | None]]:
        """Logits (B, C) of shape and size, and the orientation head's (B, m) where there is one."""
        packed = pack(clouds, self.device)
        logits, sides = self.network(voxel_grids(packed, self.checkpoint.voxels))
        radii = packed.spheres[1].double().cpu().numpy()
        joint = joint_logits(logits.double().cpu().numpy(), radii, self.checkpoint.calibration)
        return joint, [None] * len(clouds) if sides is None else list(sides.double().cpu().numpy())

    def _name(self, view: int, probabilities: np.ndarray, score: float, sides: np.ndarray | None) -> ViewClassification:
        best = int(probabilities.argmax())
        known = score >= self.checkpoint.calibration.threshold
        orientation = None
        if sides is not None and self.checkpoint.orientations[best] > 1:
            odds = softmax(sides[: self.checkpoint.orientations[best]])
            orientation = (int(odds.argmax()), round(float(odds.max()), DIGITS))
        return ViewClassification(
            view=view,
            category=self.categories[best] if known else None,
            likeliest=self.categories[best],
            known=known,
            score=round(score, DIGITS),
            probabilities=self._probabilities(probabilities),
            orientation=orientation,
        )

    def _probabilities(self, row: np.ndarray) -> dict[str, float]:
        return {name: round(float(p), DIGITS) for name, p in zip(self.categories, row, strict=True)}
