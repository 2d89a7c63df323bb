"""What registration says of a pair, of a view and of all views by a method: pose, status, evidence, errors. Frozen.

results.json holds them, and they are read back from it as they were written, by pydantic, without what it leaves out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import (
    Field,
    PlainSerializer,
    PlainValidator,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from orbitscan.processing.results.status import Status
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.recorder import poses

_UNUSUAL = 5.0  # deviations from the usual misfit
_LEAST_DEVIATION = 0.1  # of misfits, as a share of the usual one
_FEW_PAIRS = 3  # tell what is usual
_MAD = 0.6745  # the median of a standard normal deviate's size
Array = Annotated[np.ndarray, PlainValidator(np.asarray), PlainSerializer(np.ndarray.tolist)]


class _ErrorsInline:
    """A record whose errors stand in results.json among its own fields."""

    @model_serializer(mode="wrap")
    def _take_out(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content = handler(self)
        return content | content.pop("errors")

    @model_validator(mode="before")
    @classmethod
    def _put_in(cls, content: Any) -> Any:
        if not isinstance(content, Mapping):
            return content
        names = [name for name in content if "_error_" in name]
        rest = {name: value for name, value in content.items() if name not in names}
        return rest | {"errors": {name: content[name] for name in names}}


@dataclass(frozen=True)
class Evidence:
    """What speaks for an estimate, from many points to few inliers; None where the method does not look at it."""

    points: int = 0  # of the source view's working cloud
    keypoints: int | None = None
    valid_frames: int | None = None  # keypoints whose local reference frame, and so descriptor, exists
    matches: int | None = None
    inliers: int | None = None
    inlier_ratio: float | None = None
    converged: bool | None = None  # whether the refinement came to rest within its iterations
    rmse_m: float | None = None  # of the overlapping points, along the surface's normal
    overlap: float | None = None  # share of the smaller view that lies on the other
    misfit: float | None = None  # the rmse in standard deviations of both surfaces
    violations: float | None = None  # share of points in front of a surface that the other sensor saw: free space
    unseen: float | None = None  # share of points that face the other sensor, which saw nothing there
    color_misfit: float | None = None  # of colours, rms in standard deviations; only where they settled the pose
    observability: float | None = None  # how firmly the overlap holds its weakest motion; near 0 it slides


@dataclass(frozen=True)
class Candidate:
    """A start that competed for a pair, and how the views agree where a first, coarse alignment took it.

    Its name says where it came from: `identity` (no motion), `previous` (the step from the view before), `ransac` (the
    thesis's consensus set), `consensus 3` (the fourth best pose that single correspondences propose), `color 1` (the
    second best that corners of colours propose), `graph` (the poses of the joint refinement so far), `first look` (the
    best of a first competition, where there was a second); or another one's name and `turned by 15`: from there, so
    many degrees about an axis that the views hardly determine.
    """

    start: str
    status: Status  # as it would be the pair's
    score: float  # see `Verification`; at most 1


@dataclass(frozen=True, eq=False)
class Freedom:
    """A motion that views cannot determine: a turn about an axis through a point, or a shift along it."""

    kind: Literal["turn", "shift"]
    axis: Array  # (3,) unit
    point: Array  # (3,) metres

    def moved(self, T_a_b: np.ndarray) -> "Freedom":
        """The same, of coordinates in b, for coordinates in a."""
        axis, point = poses.rotate(T_a_b, self.axis[None])[0], poses.transform(T_a_b, self.point[None])[0]
        return replace(self, axis=axis, point=point)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Turns that change nothing that views show: by any multiple of 360 / order degrees about an axis."""

    axis: Array  # (3,) unit
    point: Array  # (3,) metres, on the axis
    order: int  # 2 or more
    told_by_color: bool = False  # whether the object's colours tell its turns apart, though its shape does not

    def moved(self, T_a_b: np.ndarray) -> "Symmetry":
        """The same, of coordinates in b, for coordinates in a."""
        axis, point = poses.rotate(T_a_b, self.axis[None])[0], poses.transform(T_a_b, self.point[None])[0]
        return replace(self, axis=axis, point=point)

    def turns(self) -> list[np.ndarray]:
        """The motions (4, 4) but the identity."""
        angles = 2 * np.pi * np.arange(1, self.order) / self.order
        return [poses.turn_about(self.axis, self.point, float(angle)) for angle in angles]


Unobservable = Annotated[tuple[Freedom, ...], Field(alias="unobservable")]


@dataclass(frozen=True, eq=False)
class PairErrors:
    """An estimated pair against the truth; None where that is unknown.

    Observable errors are those left when the motions that the pair declares free, or the nearest of its alternatives,
    are granted.
    """

    rotation_error_deg: float | None = None
    center_error_m: float | None = None
    rotation_error_deg_observable: float | None = None
    center_error_m_observable: float | None = None


@dataclass(frozen=True, eq=False)
class PairEstimate(_ErrorsInline):
    """The registration of a source view to a target view."""

    source: int  # recorded indices
    target: int
    T_target_source: Array | None  # (4, 4), metres
    status: Status
    confidence: float
    evidence: Evidence
    candidates: tuple[Candidate, ...] = ()  # best first
    start: str | None = None  # the candidate that led to the pose; `color` or `step` where that settled it
    # (6, 6) of a turn [rad] about the centre, then a shift [m]; the inverse of the pose's covariance
    information: Annotated[Array | None, Field(exclude=True)] = None
    center: Annotated[Array | None, Field(exclude=True)] = None  # (3,) in the target's frame
    freedoms: Unobservable = ()  # in the target's frame
    symmetries: tuple[Symmetry, ...] = ()  # in the target's frame
    alternatives: tuple[Array, ...] = ()  # other T_target_source that explain the views as well
    margin: float | None = None  # standard deviations by which the next candidate explains them worse; None: no other
    # (6, 6) as the information's, about the same centre: as the residuals scatter
    covariance: Annotated[Array | None, Field(exclude=True)] = None
    rotation_bound_deg: float | None = None  # within which the turn is right with 95 % probability
    center_bound_m: float | None = None  # the same of the centre of the object
    note: str | None = None  # what else is to be said of its status
    errors: PairErrors = field(default_factory=PairErrors)

    @property
    def ends(self) -> tuple[int, int]:
        """Source and target."""
        return self.source, self.target

    def with_uncertainty(self, known: Uncertainty | None) -> Self:
        """The estimate with how well it is known; None: that nobody can tell."""
        if known is None:
            return replace(self, covariance=None, rotation_bound_deg=None, center_bound_m=None)
        bounds = known.rotation_bound_deg, known.center_bound_m
        return replace(self, covariance=known.covariance, rotation_bound_deg=bounds[0], center_bound_m=bounds[1])


class UsualMisfit(NamedTuple):
    """The misfit that pairs of a session usually have."""

    median: float
    deviation: float  # robust

    @property
    def limit(self) -> float:
        """Beyond, a pair is no usual one."""
        return self.median + _UNUSUAL * max(self.deviation, _LEAST_DEVIATION * self.median)

    @classmethod
    def of(cls, pairs: Sequence[PairEstimate]) -> Self | None:
        """That of the pairs that have one; None for too few."""
        known = [pair.evidence.misfit for pair in pairs if pair.evidence.misfit is not None]
        if len(known) < _FEW_PAIRS:
            return None
        median = float(np.median(known))
        return cls(median, float(np.median(np.abs(np.array(known) - median))) / _MAD)


@dataclass(frozen=True, eq=False)
class ViewErrors:
    """An estimated pose against the truth; None where that is unknown."""

    translation_error_m: float | None = None  # thesis (5.1)
    rotation_error_chordal: float | None = None  # thesis (5.2), 0 to 2 sqrt(2)
    rotation_error_deg: float | None = None
    center_error_m: float | None = None  # how far the object's centre is off; does not grow with the camera's distance


ERROR_NAMES = tuple(f.name for f in fields(ViewErrors))


@dataclass(frozen=True, eq=False)
class ViewEstimate(_ErrorsInline):
    """Where a method places a view, in the frame {0} of the first view of the most that hold together."""

    view: int
    status: Status
    T_0_i: Array | None  # (4, 4), metres; None where nothing holds it to view {0}
    rotation_bound_deg: float | None = None  # within which it is right with 95 % probability; None: nobody can tell
    center_bound_m: float | None = None  # the same of the centre of the object
    note: str | None = None  # what else is to be said of its status
    errors: ViewErrors = field(default_factory=ViewErrors)
    pair: tuple[int, int] | None = None  # source and target of the pair that speaks for it; None where none does
    component: int | None = None  # of views that hold together, the most first; None: it holds to no other
    T_component_i: Array | None = None  # (4, 4), in the frame of its component's first view; None in component 0


@dataclass(frozen=True, eq=False)
class Correspondences:
    """Matched keypoints of a pair, each in its own view's frame, and which of them the consensus keeps."""

    source: int
    target: int
    source_points: np.ndarray  # (M, 3)
    target_points: np.ndarray  # (M, 3)
    inlier: np.ndarray  # (M,) bool


@dataclass(frozen=True, eq=False)
class MethodResult:
    """All views and pairs of a session by one method."""

    views: tuple[ViewEstimate, ...]
    pairs: tuple[PairEstimate, ...]
    loop_closed: bool = False
    freedoms: Unobservable = ()  # motions of views that nothing determines, in frame {0}
    symmetries: tuple[Symmetry, ...] = ()  # turns of views that nothing tells apart, in frame {0}
    summary: Mapping[str, int | float | None] = field(default_factory=dict)  # see `summarize`

    @classmethod
    def of(cls, views: Sequence[ViewEstimate], pairs: Sequence[PairEstimate], origin: int | None, **rest: Any) -> Self:
        """The result of views and pairs, each view with the pair that speaks for it, and its summary."""
        speaking = {view: (pair.source, pair.target) for view, pair in speaking_pairs(pairs).items()}
        believed = {pair.source for pair in pairs if pair.status.is_believed}
        spoken_for = {view.view for view in views if view.status != Status.OK or view.view in believed}
        named = tuple(
            replace(view, pair=speaking.get(view.view) if view.view in spoken_for else None) for view in views
        )
        return cls(named, tuple(pairs), summary=summarize(views, origin), **rest)

    @property
    def failed_views(self) -> int:
        """How many views were not placed with confidence."""
        return sum(view.status != Status.OK for view in self.views)

    @property
    def origin(self) -> int | None:
        """The view whose frame the method would call {0}: the first of those between which nothing is left open."""
        return next((view.view for view in self.views if view.status == Status.OK and view.T_0_i is not None), None)

    @property
    def placed(self) -> dict[int, np.ndarray]:
        """View -> T_0_i (4, 4) of those that are ok, in the order of use."""
        return {v.view: v.T_0_i for v in self.views if v.status == Status.OK and v.T_0_i is not None}

    @property
    def components(self) -> dict[int, dict[int, np.ndarray]]:
        """Those that hold together but not to view {0}: component, of most views first -> view -> T_component_i."""
        found: dict[int, dict[int, np.ndarray]] = {}
        for view in sorted(self.views, key=lambda view: view.component or 0):
            if view.component and view.T_component_i is not None and view.status != Status.AMBIGUOUS:
                found.setdefault(view.component, {})[view.view] = view.T_component_i
        return found

    @cached_property
    def speaking(self) -> dict[int, PairEstimate]:
        """View -> the pair that speaks for it."""
        pairs = {(pair.source, pair.target): pair for pair in self.pairs}
        return {view.view: pairs[view.pair] for view in self.views if view.pair is not None}


def speaking_pairs(pairs: Sequence[PairEstimate]) -> dict[int, PairEstimate]:
    """Source view -> the pair that speaks for it: one that the others do not contradict, then the most confident."""
    ranked = sorted(pairs, key=lambda p: (-p.status.rank, p.status == Status.INCONSISTENT, -p.confidence))
    chosen: dict[int, PairEstimate] = {}
    for pair in ranked:
        chosen.setdefault(pair.source, pair)
    return chosen


def summarize(views: Sequence[ViewEstimate], origin: int | None) -> dict[str, int | float | None]:
    """Failed views, and last, largest and median of the errors, view {0} left out; null where no truth is known."""
    summary: dict[str, int | float | None] = {"failed_views": sum(view.status != Status.OK for view in views)}
    for name in ERROR_NAMES:
        values = [getattr(view.errors, name) for view in views if view.view != origin]
        known = [value for value in values if value is not None]
        summary[f"last_{name}"] = known[-1] if known else None
        summary[f"max_{name}"] = max(known) if known else None
        summary[f"median_{name}"] = float(np.median(known)) if known else None
    return summary
