"""Views of known category, read from recordings and kept compactly; split by instance."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from typing import Literal

import numpy as np
import torch
from natsort import natsorted

from orbitscan.processing.classification.voxels import Clouds, trim
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.exceptions import InvalidOption, Wording, setting
from orbitscan.recorder.session import Session

MAX_POINTS = 8192  # kept of a view, each then standing for several: 50 kB, so that 30,000 views stay below 1.5 GB
FEWEST_POINTS = 16  # a view with less shows nothing to learn from
_STEPS = np.iinfo(np.int16).max


@dataclass(frozen=True, eq=False)
class LabelledViews:
    """Many views, a row each, their points relative to centroid and radius: six bytes a point."""

    points: np.ndarray  # (N, 3) int16, 32767 = r
    starts: np.ndarray  # (V + 1,) int64: view i holds points starts[i] to starts[i + 1]
    weights: np.ndarray  # (V,) float32: measured points that each kept one stands for
    radii: np.ndarray  # (V,) float32 [m], from the centroid to the farthest point
    up: np.ndarray  # (V, 3) float32, the vertical in the view's frame; NaN where the camera's elevation is not known
    categories: np.ndarray  # (V,) int64, index into `names`; -1: none of them
    turns: np.ndarray  # (V,) float64, the share of a turn from the circle's first view; NaN where not known
    units: np.ndarray  # (V,) str, the instance each belongs to, `category/instance`
    sessions: np.ndarray  # (V,) str, the name of each one's recording
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.radii)

    def clouds(self, rows: np.ndarray, device: torch.device | str = "cpu") -> Clouds:
        """The chosen views as a batch, each of radius 1 about 0."""
        points = np.concatenate([self.points[self.starts[i] : self.starts[i + 1]] for i in rows])
        lengths = torch.from_numpy(self.starts[rows + 1] - self.starts[rows]).to(device)
        weights = torch.from_numpy(self.weights[rows]).to(device).repeat_interleave(lengths)
        return Clouds(torch.from_numpy(points).to(device).float() / _STEPS, lengths, weights)

    def cloud(self, row: int) -> np.ndarray:
        """The points (K, 3) of one view, in metres about its centroid."""
        return self.points[self.starts[row] : self.starts[row + 1]] * np.float32(self.radii[row] / _STEPS)

    @property
    def fingerprint(self) -> str:
        """A hash of the points, their sizes and what they are called: of what data a model was trained on."""
        digest = hashlib.sha256(self.points.data.cast("B"))
        for numbers in (self.starts, self.weights, self.radii, self.up, self.turns):
            digest.update(numbers.tobytes())
        for words in (self.names, self.categories.tolist(), self.units.tolist()):
            digest.update(repr(words).encode())
        return digest.hexdigest()


@dataclass(frozen=True, eq=False)
class Split:
    """Rows of LabelledViews; no instance that is trained on is validated or tested on."""

    train: np.ndarray
    validation: np.ndarray
    test: np.ndarray


def gather(
    sessions: Iterable[Session],
    names: Sequence[str] | None = None,
    split: Literal["instances", "views"] = "instances",
    every: int = 1,
    trim_share: float = 0.0,
) -> LabelledViews:
    """The views of labelled sessions; those of a category that is not among `names` are -1. None: all their categories.

    Of every session the views 0, `every`, 2 `every` ... are read, trimmed as by `trim`; those of fewer than
    FEWEST_POINTS points are left out. With `split="views"` every view is an instance of its own. Raises InvalidOption
    for a session without category, and what reading raises.
    """
    rows = []
    for session in sessions:
        info = session.info
        if info.category is None and names is None:
            remedy = "convert it with 'orbitscan convert --category'"
            raise InvalidOption(info.name, "does not say what it shows", remedy)
        for view in session.views(range(0, info.views, every)):
            points = trim(finite(view.points)[0], trim_share)
            if len(points) < FEWEST_POINTS:
                continue
            kept, weight, radius = _compact(points)
            instance = info.instance or info.name
            unit = f"{info.category}/{instance}" + (f"/{info.name}/{view.index}" if split == "views" else "")
            turn = view.index / info.views_per_turn if info.views_per_turn else np.nan
            rows.append((kept, weight, radius, _up(info.elevation_deg), info.category, turn, unit, info.name))
    if not rows:
        raise InvalidOption("recordings", "hold no view with points", "name others")
    points, weights, radii, up, categories, turns, units, recordings = zip(*rows, strict=True)
    known = tuple(sorted(set(categories))) if names is None else tuple(names)
    index = {name: i for i, name in enumerate(known)}
    return LabelledViews(
        points=np.concatenate(points),
        starts=np.cumsum([0, *map(len, points)]),
        weights=np.array(weights, np.float32),
        radii=np.array(radii, np.float32),
        up=np.array(up, np.float32),
        categories=np.array([index.get(category, -1) for category in categories]),
        turns=np.array(turns, np.float64),
        units=np.array(units),
        sessions=np.array(recordings),
        names=known,
    )


def join(views: LabelledViews, others: LabelledViews) -> LabelledViews:
    """Two sets of views as one; the categories' names are the first one's."""
    columns = {
        f.name: np.concatenate([getattr(views, f.name), getattr(others, f.name)])
        for f in fields(views)
        if f.name not in ("starts", "names")
    }
    starts = np.concatenate([views.starts, views.starts[-1] + others.starts[1:]])
    return LabelledViews(starts=starts, names=views.names, **columns)


def split_views(views: LabelledViews, validate: str = "last", test: str = "", seed: int = 0) -> Split:
    """The rows of the views that train, validate and test.

    `validate` and `test` choose instances of each category: `last` (in natural order), a number of them, a share such
    as `20%` (drawn by the seed), and for the test also names or patterns of recordings, whose instances are tested
    whole. Raises InvalidOption where a category would be left without a training instance.
    """
    rng = np.random.default_rng(seed)
    testing = _choose(views, np.arange(len(views)), test, "test", rng)
    rest = np.setdiff1d(np.arange(len(views)), testing)
    validation = _choose(views, rest, validate, "validate", rng)
    train = np.setdiff1d(rest, validation)
    for index, name in enumerate(views.names):
        if not (views.categories[train] == index).any():
            have = len(np.unique(views.units[views.categories == index]))
            problem = f"of its {have} instance{'s' if have != 1 else ''} none is left to train on"
            remedy = Wording("record more, choose fewer with {validate} and {test}, or {split}", split="views")
            raise InvalidOption(name, problem, remedy)
    return Split(train, validation, testing)


def _choose(views: LabelledViews, rows: np.ndarray, text: str, option: str, rng: np.random.Generator) -> np.ndarray:
    """The rows among `rows` of the instances that a text chooses."""
    if not text:
        return np.empty(0, np.int64)
    share, count = text.removesuffix("%"), "1" if text == "last" else text
    drawn = text.endswith("%") and share.replace(".", "", 1).isdecimal() and 0 < float(share) < 100
    if not drawn and not count.isdecimal():
        patterns = [word.strip() for word in text.split(",")]
        chosen = [i for i in rows if any(fnmatchcase(views.sessions[i], pattern) for pattern in patterns)]
        if not chosen or option == "validate":
            remedy = "give 'last', a number, a share such as 20%" + (", or names" if option == "test" else "")
            raise InvalidOption(setting(option, text), "chooses nothing", remedy)
        return rows[np.isin(views.units[rows], views.units[chosen])]
    chosen = []
    for index in range(len(views.names)):
        units = natsorted(set(views.units[rows][views.categories[rows] == index]))
        if drawn:
            count_drawn = max(1, round(float(share) / 100 * len(units)))
            chosen += list(rng.permutation(units)[:count_drawn])
        else:
            chosen += units[len(units) - int(count) :] if int(count) < len(units) else units
    return rows[np.isin(views.units[rows], chosen)]


def _compact(points: np.ndarray) -> tuple[np.ndarray, float, float]:
    """A view's kept points (K, 3) int16, how many measured ones each stands for, and the radius [m]."""
    kept = points[np.arange(MAX_POINTS) * len(points) // MAX_POINTS] if len(points) > MAX_POINTS else points
    relative = kept - kept.mean(axis=0, dtype=np.float64)
    radius = float(np.linalg.norm(relative, axis=1).max())
    return np.rint(relative * (_STEPS / (radius or 1.0))).astype(np.int16), len(points) / len(kept), radius


def _up(elevation_deg: float | None) -> tuple[float, float, float]:
    """The vertical in the frame (x right, y down, z forward) of a camera that looks down by its elevation."""
    if elevation_deg is None:
        return np.nan, np.nan, np.nan
    elevation = np.radians(elevation_deg)
    return 0.0, -float(np.cos(elevation)), -float(np.sin(elevation))
