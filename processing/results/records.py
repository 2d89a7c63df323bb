"""What processing says: a ViewResult per view as soon as it is known, then one SessionResult. All frozen."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from orbitscan.processing.results.classification import SessionClassification, ViewClassification
from orbitscan.processing.results.estimates import Array, Correspondences, MethodResult, PairEstimate, ViewEstimate
from orbitscan.processing.results.status import Method
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.session import SessionInfo


@dataclass(frozen=True, eq=False)
class Centroid:
    """The mean of a view's points, and how many they are."""

    points: int
    mean: np.ndarray  # (3,) metres


@dataclass(frozen=True, eq=False)
class ViewResult:
    """All that is known of one view the moment it is placed; heavy, dropped by the reader after use."""

    view: int
    name: str
    stamp_ns: int
    points: np.ndarray  # (N, 3) float32, the finite points, in the view's frame
    colors: np.ndarray | None  # (N, 3) uint8
    keypoints: np.ndarray  # (K, 3)
    correspondences: Correspondences | None
    pairs: Mapping[Method, PairEstimate]  # empty for the first view
    poses: Mapping[Method, ViewEstimate]
    seconds: Mapping[str, Mapping[str, float]]  # method -> stage -> seconds
    origin: int | None = None  # the recorded index of the view whose frame is {0}; None before there is one
    damage: str | None = None  # why the recorded cloud could not be read
    classification: ViewClassification | None = None  # None without a model, or without points


@dataclass(frozen=True, eq=False)
class ViewRecord:
    """The light part of a ViewResult, kept for the whole session."""

    view: int
    name: str
    stamp_ns: int
    centroid: Centroid | None  # None for a view without points
    damage: str | None
    seconds: Mapping[str, Mapping[str, float]]
    classification: ViewClassification | None

    @classmethod
    def of(cls, result: ViewResult) -> Self:
        """The record of a result."""
        points = result.points
        centroid = Centroid(len(points), points.mean(axis=0, dtype=np.float64)) if len(points) else None
        damage, classification = result.damage, result.classification
        return cls(result.view, result.name, result.stamp_ns, centroid, damage, result.seconds, classification)


@dataclass(frozen=True, eq=False)
class Model:
    """The merged object in frame {0}, outliers removed."""

    method: Method
    points: np.ndarray  # (N, 3) float32
    colors: np.ndarray | None  # (N, 3) uint8
    removed: np.ndarray  # (R, 3) float32, the outliers
    mesh: Mesh | None = None  # a surface through the points, where asked for


@dataclass(frozen=True)
class TurntableDeviation:
    """How a view departs from a perfect turntable."""

    view: int
    slip_deg: float  # of its turn from a multiple of the step
    wobble_deg: float  # of the axis
    shift_m: float  # of the point on the axis


@dataclass(frozen=True, eq=False)
class Turntable:
    """What turned the object, or what the camera went round, in frame {0}."""

    axis: Array  # (3,) unit; the camera goes round it by the right-hand rule
    point: Array  # (3,) metres, on the axis
    step_deg: float  # from one recorded view to the next
    deviations: tuple[TurntableDeviation, ...]


@dataclass(frozen=True)
class Gap:
    """An arc without a view, from one view to the next counterclockwise; `end_deg` may exceed 360."""

    start_deg: float
    end_deg: float
    after: int  # the recorded index of the view it begins at
    before: int


@dataclass(frozen=True, eq=False)
class Coverage:
    """The azimuths of views about an axis that points up, counterclockwise seen from above; the first view's is 0."""

    up: Array  # (3,) unit, in frame {0}
    center: Array  # (3,) metres, on the axis
    forward: Array  # (3,) unit, toward azimuth 0
    azimuths_deg: Mapping[int, float]  # view -> 0 to 360
    gaps: tuple[Gap, ...]  # the widest first

    @property
    def widest_deg(self) -> float:
        """The largest angle between neighbours."""
        angles = sorted(self.azimuths_deg.values())
        return max(b - a for a, b in zip(angles, [*angles[1:], angles[0] + 360], strict=True))

    def toward(self, azimuth_deg: np.ndarray) -> np.ndarray:
        """Unit vectors (N, 3) from the axis toward azimuths (N,)."""
        angle = np.radians(azimuth_deg)[:, None]
        return np.cos(angle) * self.forward + np.sin(angle) * np.cross(self.up, self.forward)


@dataclass(frozen=True, eq=False)
class SessionResult:
    """The light records of a whole session."""

    info: SessionInfo
    views_used: tuple[int, ...]
    view_names: tuple[str, ...]  # of the used views
    stamps_ns: tuple[int, ...]
    origin: int | None  # the recorded index of the view whose frame is {0}
    reconstruction: Mapping[Method, MethodResult]  # worst to best
    model: Model | None
    turntable: Turntable | None
    seconds: Mapping[str, Any]  # as timings.json
    settings: Mapping[str, Any]
    seed: int
    centroids: Mapping[int, Centroid]  # of the used views that have points, each in its own view's frame
    unreadable: Mapping[int, str] = field(default_factory=dict)  # view -> damage
    classification: SessionClassification | None = None  # None without a model, or without points
    model_apart: Model | None = None  # of the next most views that hold together, in the frame of their first
    coverage: Coverage | None = None  # of the views that the best method places; None where it cannot be told

    @classmethod
    def of(cls, records: Sequence[ViewRecord], **rest: Any) -> Self:
        """The result of the views on record; `rest` are the fields that they do not tell."""
        return cls(
            views_used=tuple(record.view for record in records),
            view_names=tuple(record.name for record in records),
            stamps_ns=tuple(record.stamp_ns for record in records),
            centroids={record.view: record.centroid for record in records if record.centroid},
            unreadable={record.view: record.damage for record in records if record.damage},
            **rest,
        )
