"""What training makes small: the cross-entropies of the categories and of the side that is seen (thesis 3.2.4)."""

import numpy as np
import torch
from torch.nn import functional

from orbitscan.processing.classification.labelled_views import LabelledViews


def classification_loss(logits: torch.Tensor, categories: np.ndarray, open_set: bool) -> torch.Tensor:
    """Mean categorical cross-entropy of logits (B, C); category -1 is none of them.

    With `open_set` that is a category of its own whose logit is always 0, so that a view of something else learns to
    have low logits everywhere.
    """
    targets = torch.from_numpy(categories).to(logits.device)
    if open_set:
        logits = functional.pad(logits, (0, 1))
        targets = torch.where(targets < 0, logits.shape[1] - 1, targets)
    return functional.cross_entropy(logits, targets)


def orientation_labels(views: LabelledViews, rows: np.ndarray, runs: tuple[int, ...]) -> np.ndarray:
    """The run of the circle each view lies in, floor(i m / n) (thesis 3.2.4); -1 where the circle is not known."""
    m = np.array([*runs, 1])[views.categories[rows]]
    turns = views.turns[rows]
    run = np.floor(np.nan_to_num(turns) * m + 1e-9).astype(np.int64) % m  # a circle may cover more than one turn
    return np.where(np.isnan(turns) | (views.categories[rows] < 0), -1, run)


def orientation_loss(logits: torch.Tensor, labels: np.ndarray) -> torch.Tensor:
    """Cross-entropy of the side that is seen, per view of the batch; a view without label adds nothing."""
    targets = torch.from_numpy(labels).to(logits.device)
    return functional.cross_entropy(logits, targets, ignore_index=-1, reduction="sum") / len(labels)
