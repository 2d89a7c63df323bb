"""The views that the classification studies learn from: the virtual corpus, or the Washington dataset."""

from __future__ import annotations

import io
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from orbitscan.processing.classification.labelled_views import LabelledViews, Split, gather, split_views
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.recorder import mcap_file
from orbitscan.recorder.atomic import write_whole
from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation import corpus
from orbitscan.recorder.sources import washington


@dataclass(frozen=True)
class Data:
    """A file of labelled views."""

    path: Path
    fingerprint: str  # of the views


def provide(plan: Plan) -> Data:
    """The views of a plan, gathered once: every n-th one of each circle of thesis table 3.1, n being `plan.every`.

    Raises InvalidOption where the dataset lacks a category, and what recording or reading raises.
    """
    path = plan.folder / f"views-every-{plan.every}.npz"
    source = "virtual" if plan.dataset is None else str(plan.dataset.resolve())
    fingerprint = _known(path, source)
    if fingerprint is None:
        sessions = list(open_circles(plan))
        every = 1 if plan.dataset is None else plan.every  # a virtual circle is recorded thinned
        views = gather(
            plan.progress(sessions, len(sessions), "Reading the views"), tuple(corpus.INSTANCES), every=every
        )
        split(views)
        save(views, path, source)
        fingerprint = views.fingerprint
    return Data(path, fingerprint)


def save(views: LabelledViews, path: Path, source: str) -> None:
    """Write views, whole or not at all, with the name of their source. Raises UnwritableOutput."""
    content = io.BytesIO()
    columns: dict[str, Any] = {f.name: np.asarray(getattr(views, f.name)) for f in fields(views)}
    np.savez(content, source=source, fingerprint=views.fingerprint, **columns)
    write_whole(path, content.getvalue())


@lru_cache(maxsize=1)
def load(data: Data) -> LabelledViews:
    """The views in the file; the last ones read stay in memory, since a process does many runs on them."""
    with np.load(data.path) as file:
        columns = {f.name: file[f.name] for f in fields(LabelledViews)}
    return LabelledViews(**columns | {"names": tuple(columns["names"].tolist())})


def split(views: LabelledViews) -> Split:
    """The split of table 3.1: the last instance of each category is tested.

    The thesis chooses nothing by validation views, and has none: here the test's take their place, so that what
    training records after each step are the thesis's figures.
    """
    return split_views(views, validate="last")


def open_circles(plan: Plan) -> list[Session]:
    """The sessions of a plan's circles, one for every instance and height; virtual ones are recorded first."""
    if plan.dataset is not None:
        return _find_circles(plan.dataset)
    folder = plan.folder / f"corpus-every-{plan.every}"
    circles = corpus.plan(corpus.INSTANCES)
    recorded = corpus.record_all(circles, folder, replace(corpus.CAMERA, every=plan.every), plan.workers)
    for _ in plan.progress(recorded, len(circles), "Recording the virtual corpus"):
        pass
    return [mcap_file.read(folder / f"{circle.name}.mcap") for circle in circles]


def _find_circles(dataset: Path) -> list[Session]:
    if not dataset.is_dir():
        raise InvalidOption(dataset, "no such folder", "name the Washington dataset's folder of point clouds")
    found = [s for s in washington.sessions(dataset, CaptureOptions()) if s.info.category in corpus.INSTANCES]
    categories = {session.info.category for session in found}
    if missing := [name for name in corpus.INSTANCES if name not in categories]:
        raise InvalidOption(dataset, f"holds no {missing[0]}", "name the Washington dataset's folder of point clouds")
    return found


def _known(path: Path, source: str) -> str | None:
    """The fingerprint of the views in a file; None where there are none of that source."""
    try:
        with np.load(path) as file:
            return str(file["fingerprint"]) if str(file["source"]) == source else None
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None
