"""The runs of table 5.3: descriptors matched with a few known views, and the network on exactly the views they name."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
from natsort import natsorted

from orbitscan.processing.classification import checkpoint as files
from orbitscan.processing.classification.classifier import Classifier
from orbitscan.processing.classification.descriptor_matching import (
    DescriptorSettings,
    Kind,
    build_database,
    classify_views,
)
from orbitscan.processing.classification.labelled_views import LabelledViews, Split, gather
from orbitscan.processing.classification.training import TrainingSettings, train
from orbitscan.processing.reproduction.training import data
from orbitscan.processing.reproduction.training.data import Data
from orbitscan.recorder.session import Session, in_memory
from orbitscan.recorder.simulation import corpus

KNOWN = 20  # views of each category that descriptors are matched with; the thesis's number is not stated
TESTED = 475  # views at most, of all categories: thesis table 5.3
_WARM = 16  # views classified before the time is taken


@dataclass(frozen=True, eq=False)
class Choice:
    """Views chosen from recordings."""

    views: tuple[tuple[Session, int], ...]

    @property
    def categories(self) -> list[str]:
        """The category that each view shows."""
        return [str(session.info.category) for session, _ in self.views]

    @property
    def digest(self) -> str:
        """A hash of the views' names."""
        names = [(session.info.name, session.names[index]) for session, index in self.views]
        return hashlib.sha256(repr(names).encode()).hexdigest()

    def load(self) -> list[np.ndarray]:
        """The points (N, 3) [m] of each view in its camera's frame."""
        return [session.load(index).points for session, index in self.views]


def choose(sessions: Sequence[Session], every: int, seed: int) -> tuple[Choice, Choice]:
    """The known views, drawn by the seed, and the tested ones, the same for all seeds.

    Of the views 0, `every`, 2 `every` ... of every circle: KNOWN of each category's training instances, and TESTED in
    all, spread evenly over the test instances (thesis table 3.1: each category's last). Fewer where there are not so
    many.
    """
    known: list[tuple[Session, int]] = []
    tested: list[tuple[Session, int]] = []
    quotas = np.diff(np.arange(len(corpus.INSTANCES) + 1) * TESTED // len(corpus.INSTANCES))
    for number, (category, quota) in enumerate(zip(corpus.INSTANCES, quotas, strict=True)):
        circles = [session for session in sessions if session.info.category == category]
        last = natsorted({str(session.info.instance) for session in circles})[-1]
        views = [(session, index) for session in circles for index in range(0, session.info.views, every)]
        training = [view for view in views if str(view[0].info.instance) != last]
        testing = [view for view in views if str(view[0].info.instance) == last]
        drawn = np.random.default_rng((seed, number)).permutation(len(training))[:KNOWN]
        known += [training[i] for i in sorted(drawn)]
        count = min(int(quota), len(testing))
        tested += [testing[i * len(testing) // count] for i in range(count)]
    return Choice(tuple(known)), Choice(tuple(tested))


@dataclass(frozen=True, eq=False)
class Matching:
    """A run that names the tested views by their descriptors' nearest ones among the known views."""

    kind: Kind
    data: Data
    known: Choice
    tested: Choice
    seed: int
    settings: DescriptorSettings = field(default_factory=DescriptorSettings)

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"descriptors-{self.kind}-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """All that its result depends on, as JSON holds it."""
        return {
            "kind": self.kind,
            "views": self.data.fingerprint,
            "known": self.known.digest,
            "tested": self.tested.digest,
            "settings": asdict(self.settings),
        }


@dataclass(frozen=True, eq=False)
class Learning:
    """A run that names the tested views by a network, learnt from all training views or from the known ones alone."""

    learns: Literal["all", "known"]
    data: Data
    known: Choice
    tested: Choice
    settings: TrainingSettings
    seed: int
    device: str = "cpu"

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"descriptors-network-{self.learns}-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """All that its result depends on, as JSON holds it."""
        return {
            "learns": self.learns,
            "views": self.data.fingerprint,
            "known": self.known.digest if self.learns == "known" else None,
            "tested": self.tested.digest,
            "settings": asdict(self.settings),
            "seed": self.seed,
            "device": self.device.split(":")[0],
        }


def match_once(task: Matching) -> dict[str, Any]:
    """Match the tested views: the share of them that is named rightly, and the seconds for all of them."""
    database = build_database(task.known.load(), task.known.categories, task.kind, task.settings)
    clouds = task.tested.load()
    started = time.process_time()  # of one thread: other work on the machine does not count
    answers = classify_views(database, clouds)
    seconds = time.process_time() - started
    return {
        "accuracy": _share_right(answers.categories, task.tested),
        "known": len(task.known.views),
        "tested": len(task.tested.views),
        "descriptors": len(database.descriptors),
        "nameless": answers.categories.count(None),
        "description_s": answers.description_s,
        "search_s": answers.search_s,
        "seconds": seconds,
    }


def learn_once(task: Learning) -> dict[str, Any]:
    """Train a network: the share of the tested views that it names rightly, and the seconds from points to names.

    From few views it learns in as many batches as from all.
    """
    views, settings = data.load(task.data), task.settings
    rows = data.split(views)
    if task.learns == "known":
        settings = replace(settings, epoch_views=len(rows.train))
        views = _gather(task.known, views.names)
        rows = Split(np.arange(len(views)), np.arange(len(views)), np.empty(0, np.int64))
    *_, model = train(views, rows, settings, seed=task.seed, device=task.device)
    assert isinstance(model, files.Checkpoint)
    clouds = task.tested.load()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.pt"
        files.save(model, path)
        names, seconds = _name_views(Classifier(path), clouds)
        gpu_seconds = None if task.device == "cpu" else _name_views(Classifier(path, task.device), clouds)[1]
    return {
        "accuracy": _share_right(names, task.tested),
        "known": len(rows.train),
        "tested": len(task.tested.views),
        "seconds": seconds,
        "gpu_seconds": gpu_seconds,
    }


def run_once(task: Matching | Learning) -> dict[str, Any]:
    """The result of a run of either kind."""
    return match_once(task) if isinstance(task, Matching) else learn_once(task)


def _name_views(classifier: Classifier, clouds: list[np.ndarray]) -> tuple[list[str | None], float]:
    """What the views are taken for, None where they have too few points, and the seconds."""
    classifier.classify_views(range(len(clouds[:_WARM])), clouds[:_WARM])
    clock = time.process_time if classifier.device == "cpu" else time.perf_counter
    started = clock()
    found = classifier.classify_views(range(len(clouds)), clouds)
    seconds = clock() - started
    return [None if view is None else view.likeliest for view in found], seconds


def _share_right(names: Sequence[str | None], tested: Choice) -> float:
    return float(np.mean([name == category for name, category in zip(names, tested.categories, strict=True)]))


def _gather(choice: Choice, names: tuple[str, ...]) -> LabelledViews:
    """The chosen views to learn from, each as a session of its own."""
    sessions = [
        in_memory(replace(session.info, views=1), [replace(session.load(index), index=0)])
        for session, index in choice.views
    ]
    return gather(sessions, names)
