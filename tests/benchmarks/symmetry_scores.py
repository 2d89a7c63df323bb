"""A session of an object that repeats itself: its views and pairs against the truth, and what they declare."""

import tempfile
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import TypeAdapter

from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.results.estimates import Freedom, MethodResult, PairEstimate, Symmetry, ViewEstimate
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.status import Status
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import choose_scale
from orbitscan.recorder.session import Session, in_memory
from orbitscan.recorder.simulation.appearance import Lamp, Paint
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS

RUN = ("pairwise", "refined")
MUG = "coffee_mug"
KINDS = ("solids", "mugs", "controls")
COLOR_NOISE, COLOR_SHIFT = 4.0, {"gaussian": 0.0, "kinect": 1.0}  # of 255; pixels
VERTICAL_DEG = 10.0  # an axis so near to the vertical is meant to be it


@dataclass(frozen=True)
class Case:
    """All that makes a session."""

    object: str  # a solid, or an object of the simulation
    step: int  # degrees between successive views, of a whole turn
    noise: float = 1.0  # of the depth at 1 m [mm]
    known: bool = False  # whether the step is told
    instance: int = 1
    sensor: Literal["gaussian", "kinect"] = "gaussian"
    seed: int = 0
    paint: Paint = "own"
    lamp: Lamp = "object"
    gloss: float = 0.0
    color: bool = True  # whether colours count

    @property
    def views(self) -> int:
        """How many there are."""
        return 360 // self.step

    @property
    def kind(self) -> str:
        """One of KINDS."""
        return "solids" if self.object in SOLIDS else "mugs" if self.object == MUG else "controls"

    @property
    def has_relief(self) -> bool:
        """Whether a solid's relief exceeds the noise: below, it may as well be round."""
        return self.object in SOLIDS and 1e3 * SOLIDS[self.object].relief > self.noise

    def __str__(self) -> str:
        name = f"{self.object} {self.instance}" if self.object == MUG else self.object
        extras = [f"seed {self.seed}" * bool(self.seed), self.sensor * (self.sensor != "gaussian")]
        extras.append(
            f"{self.paint}, lamp {self.lamp}" * (self.paint != "own") + ", without colours" * (not self.color)
        )
        told = f"{self.step} deg{' known' * self.known}"
        return ", ".join(filter(None, [f"{name} {told} {self.noise:g} mm", *extras]))


@dataclass(frozen=True)
class ViewScore:
    """A placed view against the truth; None where it has no pose."""

    view: int
    status: Status
    degrees: float | None
    metres: float | None  # of the object's centre
    bound_deg: float | None
    bound_m: float | None


@dataclass(frozen=True)
class Axis:
    """What a pair or a whole session declares: a symmetry, with its order, or a free turn or shift, with None."""

    order: int | None
    kind: Literal["symmetry", "turn", "shift"]
    off_deg: float  # of the axis from the vertical

    def __str__(self) -> str:
        name = self.kind if self.order is None else f"order {self.order}"
        return f"{name} about an axis {self.off_deg:.3g} deg off the vertical"


@dataclass(frozen=True)
class PairScore:
    """A pair against the truth, what it declares open granted; None where it has no pose."""

    source: int
    target: int
    status: Status
    degrees: float | None
    metres: float | None
    bound_deg: float | None
    bound_m: float | None
    axes: tuple[Axis, ...]
    alternatives: int  # other poses
    start: str | None = None  # what it came from


@dataclass(frozen=True)
class MethodScore:
    """A session by a method, and what it declares of the whole."""

    views: tuple[ViewScore, ...]  # all but the first
    pairs: tuple[PairScore, ...]
    axes: tuple[Axis, ...]

    @property
    def claims(self) -> int:
        """How many motions, symmetries and orders are declared, of pairs and of the whole."""
        return len(self.axes) + sum(len(pair.axes) for pair in self.pairs)

    @property
    def about_vertical(self) -> Axis | None:
        """What is declared about the vertical axis: any turn before the highest order; None: nothing."""
        upright = [axis for axis in self.axes if axis.kind != "shift" and axis.off_deg <= VERTICAL_DEG]
        return max(upright, key=lambda axis: (axis.order is None, axis.order or 0, -axis.off_deg), default=None)


@dataclass(frozen=True)
class Score:
    """A session by all methods."""

    case: Case
    diameter: float  # of the object as the views show it [m]
    seconds: float  # of processor time, for all methods together, rendering left out
    methods: Mapping[str, MethodScore]


SCORE = TypeAdapter(Score)  # to and from JSON


@dataclass(frozen=True)
class Found:
    """The scores of sessions, and what broke."""

    scores: tuple[Score, ...]
    broken: tuple[str, ...]  # a line for each


def run(case: Case) -> Score:
    """The session of a case by all methods, against the truth."""
    session, settings = build(case), Settings()
    step_deg = 360 / case.views if case.known else None
    settings = replace(settings, pair=replace(settings.pair, step_deg=step_deg, color=case.color))
    views, truth = session.views(), session.truth()
    started = time.process_time()
    results = process(views, session.info, settings, RUN, seed=case.seed)
    (last,) = deque(results, maxlen=1)
    seconds = time.process_time() - started
    (result,) = with_errors([last], truth)
    assert isinstance(result, SessionResult)
    scale = choose_scale(views, settings.surface)
    if scale is None or result.origin is None:
        raise ValueError("no view has points enough")
    up = {view: T_object_camera[:3, :3].T @ (0.0, 0.0, 1.0) for view, T_object_camera in truth.items()}
    methods = {method.value: _score(found, result.origin, up) for method, found in result.reconstruction.items()}
    return Score(case, scale.diameter, seconds, methods)


def build(case: Case) -> Session:
    """The session of a case, all rendered."""
    with tempfile.TemporaryDirectory() as folder:
        solid = SOLIDS.get(case.object)
        what = case.object if solid is None else solid.write(Path(folder))
        looks = {"paint": case.paint, "lamp": case.lamp, "gloss": case.gloss}
        looks |= {"color_noise": COLOR_NOISE, "color_shift": COLOR_SHIFT[case.sensor]} if case.paint != "own" else {}
        seen = {"views": case.views, "sensor": case.sensor, "noise_mm": case.noise, "seed": case.seed}
        session = simulate(what, case.instance, **seen, **looks)
    return in_memory(session.info, list(session.views()), session.truth())


def _score(found: MethodResult, origin: int, up: Mapping[int, np.ndarray]) -> MethodScore:
    """`up` is the object's vertical axis in the frame of every view."""
    return MethodScore(
        tuple(_score_view(view) for view in found.views if view.view != origin),
        tuple(_score_pair(pair, up[pair.target]) for pair in found.pairs),
        _score_axes(found, up[origin]),
    )


def _score_view(view: ViewEstimate) -> ViewScore:
    errors = view.errors
    bounds = view.rotation_bound_deg, view.center_bound_m
    return ViewScore(view.view, view.status, errors.rotation_error_deg, errors.center_error_m, *bounds)


def _score_pair(pair: PairEstimate, vertical: np.ndarray) -> PairScore:
    errors = pair.errors
    return PairScore(
        pair.source, pair.target, pair.status, errors.rotation_error_deg_observable, errors.center_error_m_observable,
        pair.rotation_bound_deg, pair.center_bound_m,
        _score_axes(pair, vertical), len(pair.alternatives), pair.start,
    )  # fmt: skip


def _score_axes(found: PairEstimate | MethodResult, vertical: np.ndarray) -> tuple[Axis, ...]:
    declared: tuple[Symmetry | Freedom, ...] = (*found.symmetries, *found.freedoms)
    return tuple(_score_axis(motion, vertical) for motion in declared)


def _score_axis(declared: Symmetry | Freedom, vertical: np.ndarray) -> Axis:
    axis = np.asarray(declared.axis)
    off = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, vertical)), abs(axis @ vertical))))
    if isinstance(declared, Symmetry):
        return Axis(declared.order, "symmetry", off)
    return Axis(None, declared.kind, off)
