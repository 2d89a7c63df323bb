"""How a network does on views of known category while it is trained: losses are taken in evaluation mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch.nn import functional

from orbitscan.processing.classification.calibration import joint_logits, log_probabilities
from orbitscan.processing.classification.checkpoint import Calibration
from orbitscan.processing.classification.labelled_views import LabelledViews
from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings, voxel_grids

_BATCH = 256  # views at once where nothing is learnt


@dataclass(frozen=True, eq=False)
class Scores:
    """Categorical cross-entropies [nats] and accuracies [share of the views]."""

    train_loss: float
    train_accuracy: float
    validation_loss: float
    validation_accuracy: float

    @property
    def overfitting(self) -> float:
        """Validation loss minus training loss (thesis 5.1)."""
        return self.validation_loss - self.train_loss


@dataclass(frozen=True, eq=False)
class EpochRecord(Scores):
    """How a model does after an epoch."""

    epoch: int  # from 1
    confusion: tuple[tuple[int, ...], ...]  # validation views, row: true category, column: found one
    views_per_second: float


@dataclass(frozen=True, eq=False)
class StepRecord(Scores):
    """How a model does between two epochs, on some of the views."""

    step: int  # batches trained on so far


@dataclass(frozen=True, eq=False)
class Evaluator:
    """Measures a network that is being trained."""

    views: LabelledViews
    of_size: np.ndarray  # (V, C) that a view's size adds to its logits
    voxels: VoxelSettings
    precision: Literal["float32", "bfloat16"] = "float32"
    device: str = "cpu"

    def scores(self, network: Network, train: np.ndarray, validation: np.ndarray) -> tuple[Scores, np.ndarray]:
        """The scores on the two sets of rows, and the category that is found for each validation view."""
        (loss, accuracy, _), (held_loss, held_accuracy, found) = (
            _score(self.predict(network, rows) + self.of_size[rows], self.views.categories[rows])
            for rows in (train, validation)
        )
        return Scores(loss, accuracy, held_loss, held_accuracy), found

    def confusion(self, rows: np.ndarray, found: np.ndarray) -> tuple[tuple[int, ...], ...]:
        """How many of the views of each category (row) are taken for each (column)."""
        counts = np.zeros((len(self.views.names),) * 2, np.int64)
        np.add.at(counts, (self.views.categories[rows], found), 1)
        return tuple(tuple(int(n) for n in row) for row in counts)

    @torch.inference_mode()
    def predict(self, network: Network, rows: np.ndarray) -> np.ndarray:
        """Logits (V, C) float64 of the chosen views, not augmented, by their shape alone."""
        network.eval()
        found = []
        for batch in np.array_split(rows, -(-len(rows) // _BATCH)) if len(rows) else []:
            with torch.autocast(torch.device(self.device).type, torch.bfloat16, self.precision == "bfloat16"):
                logits, _ = network(voxel_grids(self.views.clouds(batch, self.device), self.voxels))
            found.append(logits.double().cpu().numpy())
        return np.concatenate(found) if found else np.empty((0, len(self.views.names)))

    def measure(self, network: Network, rows: np.ndarray, calibration: Calibration) -> dict[str, float]:
        """Loss and accuracy of the chosen views, and the loss after calibration, which leaves the accuracy as it is."""
        joint = joint_logits(self.predict(network, rows), self.views.radii[rows], calibration)
        loss, accuracy, _ = _score(joint, self.views.categories[rows])
        calibrated_loss, *_ = _score(log_probabilities(joint, calibration), self.views.categories[rows])
        return {"views": len(rows), "loss": loss, "accuracy": accuracy, "calibrated_loss": calibrated_loss}


def _score(logits: np.ndarray, categories: np.ndarray) -> tuple[float, float, np.ndarray]:
    """The cross-entropy [nats], the accuracy and the categories found, from logits (V, C) and categories (V,)."""
    loss = functional.cross_entropy(torch.from_numpy(logits), torch.from_numpy(categories))
    found = logits.argmax(axis=1)
    return float(loss), float((found == categories).mean()), found
