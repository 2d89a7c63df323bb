"""The vocabulary of the project: a View, a SessionInfo, and a Session of one object seen by one sensor."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import groupby
from typing import Literal

import numpy as np

from orbitscan.recorder.exceptions import InvalidOption, setting

DEFAULT_VIEWS = 18  # thesis 5.2: 20 degrees apart
ESTIMATED = "estimated by"  # how `source_poses` starts where a recording's poses are no ground truth
Capture = Literal["circle", "unordered", "unknown"]


@dataclass(frozen=True, eq=False)
class View:
    """A single-view cloud in the camera's optical frame (x right, y down, z forward), metres.

    It carries no pose: what estimates poses cannot see the true ones.
    """

    index: int  # the recorded index, also after a selection
    name: str
    stamp_ns: int
    points: np.ndarray  # (N, 3) float32; may hold NaN where the sensor saw nothing
    colors: np.ndarray | None = None  # (N, 3) uint8 RGB
    damage: str | None = None  # why the recorded cloud could not be read; points are then empty


@dataclass(frozen=True)
class SessionInfo:
    """What is known of a session besides its views."""

    name: str
    views: int = 0
    category: str | None = None
    instance: str | None = None
    source: str = ""
    sensor: str = ""
    capture: Capture = "unknown"
    sensor_origin: tuple[float, float, float] | None = (0.0, 0.0, 0.0)  # in the view's frame; None where unknown
    outline_known: bool = False  # whether the sensor looked where no points are: nothing is there, it is no hole
    source_axes: str = "RDF"
    source_units: str = "m"
    source_poses: str = ""  # how the true poses were read: direction, axes, units ("camera-to-object RDF m")
    elevation_deg: float | None = None
    views_per_turn: float | None = None

    @property
    def has_estimates(self) -> bool:
        """Whether the recorded poses are somebody's estimates: nothing is measured against them."""
        return self.source_poses.startswith(ESTIMATED)


@dataclass(frozen=True, eq=False)
class Views:
    """A lazy, re-iterable choice of a session's views: a view is read when it is asked for, and never kept."""

    indices: tuple[int, ...]
    load: Callable[[int], View] = field(repr=False)

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[View]:
        return (self.load(index) for index in self.indices)


@dataclass(frozen=True, eq=False)
class Session:
    """One object by one sensor: views without poses, and the true poses apart."""

    info: SessionInfo
    names: tuple[str, ...]  # of view 0, 1, ...
    load: Callable[[int], View] = field(repr=False)
    load_truth: Callable[[], Mapping[int, np.ndarray]] = field(default=dict, repr=False)
    damage: str | None = None  # what of the recording is lost

    def views(self, selection: str | Sequence[int] = "all") -> Views:
        """The selected views, in the order of the selection; see `select_views` for its grammar."""
        indices = select_views(selection, self.names) if isinstance(selection, str) else tuple(selection)
        return Views(indices, self.load)

    def truth(self) -> Mapping[int, np.ndarray]:
        """The true poses T_object_camera (4, 4), as far as they are known, by recorded index. Raises InvalidPose."""
        return self.load_truth()


def first_views(session: Session, count: int) -> Session:
    """The session as it was after so many views; all of it where it has fewer."""
    count = min(count, session.info.views)
    return replace(
        session,
        info=replace(session.info, views=count),
        names=session.names[:count],
        load_truth=lambda: {view: T for view, T in session.truth().items() if view < count},
    )


def in_memory(info: SessionInfo, views: Sequence[View], truth: Mapping[int, np.ndarray] | None = None) -> Session:
    """A session of views already in memory; `views[i].index` must be i."""
    views = tuple(views)
    return Session(info, tuple(view.name for view in views), views.__getitem__, lambda: dict(truth or {}))


def name_views(indices: Sequence[int], most: int = 8) -> str:
    """Indices in words, ascending ones together: `view 3`, `views 0-4, 7`; of more than `most` parts the number."""
    ascending = groupby(enumerate(indices), key=lambda pair: pair[1] - pair[0])
    runs = [[index for _, index in run] for _, run in ascending]
    words = [f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs]
    shown = ", ".join(words[:most]) + (f" and {len(words) - most} more" if len(words) > most else "")
    return f"view{'s' if len(indices) > 1 else ''} {shown}"


def select_views(selection: str, names: Sequence[str]) -> tuple[int, ...]:
    """The recorded indices that a text selects.

    `18` is a count (equally spaced: floor(i n / k); all where k >= n), `all` every view, `0,1,5` a list, `0:12` a range
    (the end is left out), `bun*` names. Raises InvalidOption.
    """
    n = len(names)
    text = selection.strip()
    remedy = f"give a count, 'all', a list 0,1,5, a range 0:12 or a name pattern; the views are 0 to {n - 1}"
    subject = setting("views", selection)
    if text == "all":
        return tuple(range(n))
    if re.fullmatch(r"\d+", text):
        count = int(text)
        if count == 0:
            raise InvalidOption(subject, "selects no view", remedy)
        return tuple(range(n)) if count >= n else tuple(i * n // count for i in range(count))
    if match := re.fullmatch(r"(\d*):(\d*)", text):
        start, stop = int(match[1] or 0), int(match[2] or n)
        indices = tuple(range(start, min(stop, n)))
    elif re.fullmatch(r"\d+(,\d+)+,?|\d+,", text):
        indices = tuple(dict.fromkeys(int(word) for word in text.split(",") if word))
        if beyond := [i for i in indices if i >= n]:
            raise InvalidOption(subject, f"there is no view {beyond[0]}", remedy)
    else:
        patterns = [word.strip() for word in text.split(",")]
        indices = tuple(i for i, name in enumerate(names) if any(fnmatchcase(name, p) for p in patterns))
    if not indices:
        raise InvalidOption(subject, "selects no view", remedy)
    return indices
