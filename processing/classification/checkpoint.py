"""A trained model as one self-describing file: what classifies, what it was trained on, how well it did."""

from __future__ import annotations

import zipfile
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import torch
from pydantic import TypeAdapter, ValidationError

from orbitscan.processing.classification import PACKAGED
from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.recorder.atomic import whole_file
from orbitscan.recorder.exceptions import ScanError

FORMAT_VERSION = 1
_REMEDY = "name a model made by 'orbitscan train'"


class UnreadableModel(ScanError):
    """A file that holds no model of this program."""


@dataclass(frozen=True)
class Calibration:
    """What turns a network's logits into probabilities and into a score of being known; see `scores`."""

    temperature: float = 1.0
    threshold: float = -torch.inf  # a view whose score is below is unknown
    fused_threshold: float = -torch.inf  # the same for the mean score of several views
    size_means: tuple[float, ...] = ()  # of log(r / 1 m), a category each; empty: size does not count
    size_deviations: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """All of a trained model; `network()` builds its network again."""

    weights: dict[str, torch.Tensor]
    structure: str
    categories: tuple[str, ...]
    voxels: VoxelSettings
    orientations: tuple[int, ...]  # runs of a circle, per category; empty: no orientation head
    calibration: Calibration
    settings: dict[str, Any] = field(default_factory=dict)  # of the training
    metrics: dict[str, Any] = field(default_factory=dict)
    fingerprint: str = ""  # of the training data
    seed: int = 0
    format_version: int = FORMAT_VERSION

    def network(self, device: torch.device | str = "cpu") -> Network:
        """The network with its weights, ready to classify."""
        network = Network(self.structure, len(self.categories), self.voxels.div, max(self.orientations, default=0))
        network.load_state_dict({name: weight.float() for name, weight in self.weights.items()})
        return network.to(device).eval()


def save(checkpoint: Checkpoint, path: Path) -> None:
    """Write a checkpoint, whole or not at all. Raises UnwritableOutput."""
    content = {f.name: getattr(checkpoint, f.name) for f in fields(checkpoint)}
    content |= {"voxels": asdict(checkpoint.voxels), "calibration": asdict(checkpoint.calibration)}
    write(content, path)


def write(content: dict[str, Any], path: Path) -> None:
    """Write tensors and plain values, whole or not at all. Raises UnwritableOutput."""
    with whole_file(path) as part:
        torch.save(content, part)


def read(path: Path) -> Any:
    """The tensors and plain values that `write` wrote; a file cannot bring code along.

    Raises for a damaged file; the exceptions are pickle's, zip's or torch's, which have no common root.
    """
    with zipfile.ZipFile(path) as archive:
        if archive.testzip():  # torch does not look at the checksums
            raise zipfile.BadZipFile
    return torch.load(path, map_location="cpu", weights_only=True)


def load(path: Path = PACKAGED) -> Checkpoint:
    """The checkpoint in a file. Raises UnreadableModel."""
    if not path.is_file():
        raise UnreadableModel(path, "no such file", _REMEDY)
    try:
        content = read(path)
    except Exception as error:
        raise UnreadableModel(path, f"is damaged or no model ({type(error).__name__})", _REMEDY) from None
    if not isinstance(content, dict) or {f.name for f in fields(Checkpoint)} - content.keys():
        raise UnreadableModel(path, "is no model of orbitscan", _REMEDY)
    if str(content["format_version"]) != str(FORMAT_VERSION):
        raise UnreadableModel(path, f"is of format {content['format_version']}, not {FORMAT_VERSION}", "train it anew")
    try:
        parts = {
            "voxels": TypeAdapter(VoxelSettings).validate_python(content["voxels"]),
            "calibration": TypeAdapter(Calibration).validate_python(content["calibration"]),
            "categories": tuple(content["categories"]),
            "orientations": tuple(content["orientations"]),
        }
        checkpoint = Checkpoint(**{f.name: content[f.name] for f in fields(Checkpoint)} | parts)
        checkpoint.network()
        _check(checkpoint)
    except (RuntimeError, ScanError, ValidationError, TypeError, AttributeError, ValueError):
        raise UnreadableModel(path, "its weights do not fit the structure it names", "train it anew") from None
    return checkpoint


def _check(checkpoint: Checkpoint) -> None:
    means, deviations = checkpoint.calibration.size_means, checkpoint.calibration.size_deviations
    counts = {len(checkpoint.orientations), len(means), len(deviations)}
    if counts - {0, len(checkpoint.categories)} or len(means) != len(deviations):
        raise ValueError("runs and sizes are of each category, or of none")
    if min((checkpoint.calibration.temperature, *deviations)) <= 0:
        raise ValueError("what is divided by is positive")
