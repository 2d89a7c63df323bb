"""Training, top to bottom: labelled views in, an EpochRecord after each epoch, one Checkpoint out (thesis 3.2)."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Generator, Iterator
from dataclasses import asdict, dataclass, field
from math import cos, pi
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import torch
from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveInt

from orbitscan.processing.classification import checkpoint as files
from orbitscan.processing.classification.augmentation import AugmentationSettings, augment
from orbitscan.processing.classification.calibration import calibrate, joint_logits, measure_sizes
from orbitscan.processing.classification.checkpoint import Calibration, Checkpoint
from orbitscan.processing.classification.evaluation import EpochRecord, Evaluator, StepRecord
from orbitscan.processing.classification.initialization import Init, initialize
from orbitscan.processing.classification.labelled_views import LabelledViews, Split
from orbitscan.processing.classification.losses import classification_loss, orientation_labels, orientation_loss
from orbitscan.processing.classification.network import BODY, DROPOUT, Network
from orbitscan.processing.classification.voxels import VoxelSettings, voxel_grids
from orbitscan.recorder.exceptions import InvalidOption, Wording
from orbitscan.recorder.sources.washington import RUNS

_EVALUATED = 2000  # training views at most that the training loss is measured on, in evaluation mode
_CURVE = 100  # views of either set at most that a StepRecord is measured on


@dataclass(frozen=True)
class TrainingSettings:
    """How a network is trained so that it holds on other sensors; `THESIS` is how the thesis does it."""

    structure: str = ""  # empty: table 5.1's best, with a dense layer for the categories
    epochs: PositiveInt = 14
    init: Init = "glorot"  # thesis 3.2.1 to 3.2.3
    orientation: bool = False  # thesis 3.2.4: a second softmax for the side that is seen
    runs: dict[str, PositiveInt] = field(default_factory=lambda: dict(RUNS))  # thesis table 3.2; 1 for others
    voxels: VoxelSettings = field(default_factory=lambda: VoxelSettings(values="density", trim=0.005))
    augmentation: AugmentationSettings = field(
        default_factory=lambda: AugmentationSettings(
            turn_deg=45,
            tilt_deg=15,
            roll_deg=8,
            level=0.2,
            stretch=0.12,
            crop=0.15,
            occlusion=0.2,
            thin=0.6,
            noise=0.03,
            strays=0.1,
        )
    )
    # The rest is not in the thesis.
    epoch_views: NonNegativeInt = 1000  # that an epoch has at least: of a small set each is varied several times
    dropout: Annotated[float, Field(ge=0, lt=1)] = DROPOUT
    batch: PositiveInt = 64
    learning_rate: NonNegativeFloat = 1e-3  # of Adam, falling to 0 as a half cosine
    unknown_share: NonNegativeFloat = 1.0  # views of other things for each view of the categories, where there are any
    size: bool = True  # the metric radius counts too
    precision: Literal["float32", "bfloat16"] = "float32"


THESIS = TrainingSettings(  # counts, 2 epochs (3 in the orientation study), no augmentation, the shape alone
    epochs=2, voxels=VoxelSettings(), augmentation=AugmentationSettings(), epoch_views=0, size=False
)


def train(
    views: LabelledViews,
    split: Split,
    settings: TrainingSettings | None = None,
    *,
    seed: int = 0,
    device: str = "cpu",
    state: Path | None = None,
    curve: int = 0,
) -> Iterator[StepRecord | EpochRecord | Checkpoint]:
    """Train a network: an EpochRecord after each epoch with `curve` StepRecords in it, and at last the Checkpoint.

    Views of category -1 teach what is none of the categories. `state` is a file for what is reached after each epoch:
    begun again with the same data, settings and seed, training goes on from there (its records come first) and ends
    with the same weights, if on as many threads. Raises InvalidOption for a structure that does not fit, one category
    only, or no validation.
    """
    settings = settings or TrainingSettings()
    if len(views.names) < 2:
        raise InvalidOption(views.names[0], "is the only category", "give recordings of another one, too")
    if not (views.categories[split.validation] >= 0).any():
        raise InvalidOption("the split", "leaves nothing to validate", Wording("choose instances with {validate}"))
    structure = settings.structure or f"{BODY}-FC({len(views.names)})"
    runs = tuple(settings.runs.get(name, 1) for name in views.names) if settings.orientation else ()
    key = {"settings": asdict(settings), "seed": seed, "fingerprint": views.fingerprint, "split": _hash(split)}

    torch.manual_seed(seed)
    network = Network(structure, len(views.names), settings.voxels.div, max(runs, default=0), settings.dropout)
    optimizer = torch.optim.Adam(network.to(device).parameters(), settings.learning_rate)
    records = _resume(state, key, network, optimizer)
    yield from records
    if not records:
        initialize(
            network,
            settings.init,
            views,
            split.train,
            settings.voxels,
            structure=structure,
            precision=settings.precision,
            seed=seed,
            device=device,
        )

    known, unknown = _divide(views, split.train)
    held, _ = _divide(views, split.validation)
    repeated = np.tile(known, max(1, -(-settings.epoch_views // len(known))))
    by_size = Calibration()
    if settings.size:
        by_size = measure_sizes(views.radii[repeated], views.categories[repeated], len(views.names))
    of_size = joint_logits(np.zeros((len(views), len(views.names))), views.radii, by_size)  # the shape's are added
    evaluator = Evaluator(views, of_size, settings.voxels, settings.precision, device)
    course = _Course(settings, seed, network, optimizer, evaluator, runs, repeated, unknown)
    for epoch in range(len(records), settings.epochs):
        views_per_second = yield from _train_epoch(course, epoch, _spread(known, _CURVE), _spread(held, _CURVE), curve)
        scores, found = evaluator.scores(network, _spread(known, _EVALUATED), held)
        confusion = evaluator.confusion(held, found)
        record = EpochRecord(**asdict(scores), epoch=epoch + 1, confusion=confusion, views_per_second=views_per_second)
        records.append(record)
        if state is not None:
            content = {"network": network.state_dict(), "optimizer": optimizer.state_dict()}
            files.write(key | content | {"records": [asdict(record) for record in records]}, state)
        yield record
    yield _finish(course, structure, by_size, held, _divide(views, split.test)[0])


@dataclass(frozen=True, eq=False)
class _Course:
    """What all epochs of a training share."""

    settings: TrainingSettings
    seed: int
    network: Network
    optimizer: torch.optim.Optimizer
    evaluator: Evaluator
    runs: tuple[int, ...]  # of a circle of each category, that the orientation head tells apart; () without the head
    known: np.ndarray  # rows that an epoch trains on, some of them several times
    unknown: np.ndarray  # rows of other things, of which each epoch draws `others`

    @property
    def others(self) -> int:
        """How many views of other things an epoch trains on."""
        return round(self.settings.unknown_share * len(self.known)) if len(self.unknown) else 0

    @property
    def batches(self) -> int:
        """How many batches an epoch has."""
        return -(-(len(self.known) + self.others) // self.settings.batch)


def _train_epoch(
    course: _Course, epoch: int, seen: np.ndarray, held: np.ndarray, curve: int
) -> Generator[StepRecord, None, float]:
    """Train the network for one epoch, and return how many views it was trained on in a second.

    After each of `curve` batches, evenly spread, a StepRecord measured on the rows `seen` and `held` is yielded.
    """
    settings, network, seed, device = course.settings, course.network, course.seed, course.evaluator.device
    others, batches = course.others, course.batches
    recorded = _spread(np.arange(1, batches + 1), curve)
    started = time.perf_counter()
    torch.manual_seed(seed * 1000 + epoch)  # of dropout
    generator = torch.Generator(device).manual_seed(seed * 1000 + epoch)
    rng = np.random.default_rng((seed, epoch))
    drawn = rng.choice(course.unknown, others) if others else course.unknown[:0]
    order = rng.permutation(np.concatenate([course.known, drawn]))
    network.train()
    for step, rows in enumerate(np.array_split(order, batches), epoch * batches):
        for group in course.optimizer.param_groups:
            group["lr"] = settings.learning_rate * (0.5 + 0.5 * cos(pi * step / (batches * settings.epochs)))
        course.optimizer.zero_grad()
        _measure_loss(course, rows, generator).backward()
        course.optimizer.step()
        if step + 1 - epoch * batches in recorded:
            paused = time.perf_counter()
            scores, _ = course.evaluator.scores(network, seen, held)
            yield StepRecord(**asdict(scores), step=step + 1)
            network.train()
            started += time.perf_counter() - paused
    return len(order) / (time.perf_counter() - started)


def _measure_loss(course: _Course, rows: np.ndarray, generator: torch.Generator) -> torch.Tensor:
    """The loss of a batch of views, augmented: of the categories and, with an orientation head, of the sides."""
    views, settings, device = course.evaluator.views, course.settings, course.evaluator.device
    up = torch.from_numpy(views.up[rows]).to(device)
    clouds = augment(views.clouds(rows, device), up, settings.augmentation, generator)
    with torch.autocast(torch.device(device).type, torch.bfloat16, settings.precision == "bfloat16"):
        logits, sides = course.network(voxel_grids(clouds, settings.voxels))
    joint = logits.float() + torch.from_numpy(course.evaluator.of_size[rows]).to(device).float()
    loss = classification_loss(joint, views.categories[rows], open_set=course.others > 0)
    if sides is not None:
        loss = loss + orientation_loss(sides.float(), orientation_labels(views, rows, course.runs))
    return loss


def _finish(course: _Course, structure: str, by_size: Calibration, held: np.ndarray, test: np.ndarray) -> Checkpoint:
    """The trained network as a Checkpoint: calibrated on the validation rows `held`, measured on them and on `test`."""
    network, evaluator, views = course.network, course.evaluator, course.evaluator.views
    logits = evaluator.predict(network, held)
    of_held = views.radii[held], views.categories[held], views.sessions[held]
    calibration = calibrate(logits, *of_held, by_size, course.seed)
    return Checkpoint(
        weights={name: weight.detach().cpu() for name, weight in network.state_dict().items()},
        structure=structure,
        categories=views.names,
        voxels=course.settings.voxels,
        orientations=course.runs,
        calibration=calibration,
        settings=asdict(course.settings),
        metrics={
            name: evaluator.measure(network, rows, calibration)
            for name, rows in (("validation", held), ("test", test))
            if len(rows)
        },
        fingerprint=views.fingerprint,
        seed=course.seed,
    )


def _resume(
    state: Path | None, key: dict[str, Any], network: Network, optimizer: torch.optim.Optimizer
) -> list[EpochRecord]:
    """The records of this very training in a file, whose weights are loaded; none where it is absent or of another."""
    if state is None or not state.is_file():
        return []
    try:
        content = files.read(state)
        if any(content[name] != value for name, value in key.items()):
            return []
        records = [EpochRecord(**record) for record in content["records"]]
        network.load_state_dict(content["network"])
        optimizer.load_state_dict(content["optimizer"])
        return records
    except Exception:  # a cut file is as good as none
        return []


def _divide(views: LabelledViews, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows whose category is known, and those of other things."""
    is_known = views.categories[rows] >= 0
    return rows[is_known], rows[~is_known]


def _spread(rows: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the rows, evenly chosen, the last among them."""
    if most >= len(rows) or not most:
        return rows[:most]
    return rows[np.linspace(len(rows) / most, len(rows), most).round().astype(int) - 1]


def _hash(split: Split) -> str:
    return hashlib.sha256(b"".join(rows.tobytes() for rows in (split.train, split.validation, split.test))).hexdigest()
