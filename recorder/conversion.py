"""What is said of a capture, and how it brings points and poses into metres in the camera's optical frame."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption, Wording, setting
from orbitscan.recorder.session import SessionInfo

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
DIRECTIONS = ("camera-to-object", "object-to-camera")


@dataclass(frozen=True)
class Conversion:
    """How the numbers of a source are read. Raises InvalidOption for a value that a field cannot have."""

    units: str = "m"  # of the points
    scale: float = 1.0  # metres = numbers x units x scale, in points and poses
    axes: str = "RDF"  # where x, y, z of the points' frame point, as Rerun's ViewCoordinates are named
    poses_are: str = "camera-to-object"
    pose_axes: str = "RDF"  # of the camera frame the poses speak of
    pose_units: str = "m"

    def __post_init__(self) -> None:
        for name, known in (("units", METRES), ("pose_units", METRES), ("poses_are", DIRECTIONS)):
            if (word := getattr(self, name)) not in known:
                raise InvalidOption(setting(name, word), "not one of its values", f"give {' or '.join(known)}")
        if not (np.isfinite(self.scale) and self.scale > 0):
            remedy = "give metres per unit of the source"
            raise InvalidOption(setting("scale", self.scale), "not a positive number", remedy)
        for axes in (self.axes, self.pose_axes):
            poses.axes_to_rdf(axes)

    @property
    def pose_words(self) -> str:
        """How poses are read, in three words such as `camera-to-object RDF m`."""
        return f"{self.poses_are} {self.pose_axes} {self.pose_units}"

    def points(self, points: np.ndarray) -> np.ndarray:
        """The source's points (N, 3) in the view's frame [m]; float32."""
        turned_and_scaled = METRES[self.units] * self.scale * poses.axes_to_rdf(self.axes)
        return poses.transform(poses.make(turned_and_scaled, np.zeros(3)), points).astype(np.float32)

    def origin(self, position: tuple[float, float, float]) -> tuple[float, float, float]:
        """A position given in the points' frame and units, in the view's frame [m]."""
        x, y, z = self.points(np.array([position], dtype=np.float64))[0].tolist()
        return x + 0.0, y + 0.0, z + 0.0  # -0 is 0

    def pose(self, T_file: np.ndarray) -> np.ndarray:
        """T_object_camera of a rigid motion as the source writes it; the object's frame keeps its axes."""
        T = poses.make(T_file[:3, :3], T_file[:3, 3] * METRES[self.pose_units] * self.scale)
        T_object_source = poses.invert(T) if self.poses_are == "object-to-camera" else T
        return T_object_source @ poses.make(poses.axes_to_rdf(self.pose_axes).T, np.zeros(3))

    def source_pose(self, T_object_camera: np.ndarray) -> np.ndarray:
        """The motion (4, 4) that the source would write for T_object_camera: the inverse of `pose`."""
        T = T_object_camera @ poses.make(poses.axes_to_rdf(self.pose_axes), np.zeros(3))
        T = poses.invert(T) if self.poses_are == "object-to-camera" else T
        return poses.make(T[:3, :3], T[:3, 3] / (METRES[self.pose_units] * self.scale))

    def changes(self, given: "Conversion") -> dict[str, str | float]:
        """The fields of CaptureOptions, with their values, that turn another conversion into this one."""
        said = [field.name for field in fields(self) if getattr(self, field.name) != getattr(given, field.name)]
        # What is said of the points holds for the poses too, unless it is said of these.
        for name in ("axes", "units"):
            if name in said:
                said = [other for other in said if other != f"pose_{name}"]
                said += [f"pose_{name}"] if getattr(self, f"pose_{name}") != getattr(self, name) else []
        return {name: getattr(self, name) for name in said}


@dataclass(frozen=True)
class CaptureOptions:
    """What a user may say about a capture; None where nothing is said."""

    format: str | None = None  # clouds, stanford or washington; else recognised
    poses: Path | None = None  # a file of poses; else the one that lies with the clouds
    poses_are: str | None = None  # camera-to-object or object-to-camera
    units: str | None = None  # this and the next four: see Conversion; the poses' units and axes are
    pose_units: str | None = None  # those of the points where nothing is said of them
    scale: float | None = None
    axes: str | None = None
    pose_axes: str | None = None
    sensor_origin: tuple[float, float, float] | Literal["unknown"] | None = None  # in the points' units and axes
    columns: tuple[str, str, str] | None = None  # the columns of a text file that hold x, y, z; else recognised
    categories_from_folders: Literal[True] | None = None  # each cloud is an object, its category its folder's name
    category: str | None = None
    instance: str | None = None
    elevation: float | None = None  # degrees that the camera looks down; 0: the frame is level
    name: str | None = None

    def allow(self, format_name: str, *allowed: str) -> None:
        """Raises InvalidOption where an option is given that the format itself settles."""
        for field in fields(self):
            if field.name not in ("format", *allowed) and getattr(self, field.name) is not None:
                remedy = Wording("leave it out, or pass {format}", format="clouds")
                raise InvalidOption(setting(field.name), f"the {format_name} format settles it", remedy)

    def conversion(self) -> Conversion:
        """The conversion the options ask for; raises InvalidOption."""
        axes, units = (self.axes or "RDF").upper(), self.units or "m"
        return Conversion(
            units=units,
            scale=1.0 if self.scale is None else self.scale,
            axes=axes,
            poses_are=self.poses_are or "camera-to-object",
            pose_axes=(self.pose_axes or axes).upper(),
            pose_units=self.pose_units or units,
        )


def recorded(info: SessionInfo) -> Conversion:
    """The conversion that a session's facts tell of; what they do not tell, or tell wrong, is the default."""
    words: dict[str, Any] = dict(zip(("poses_are", "pose_axes", "pose_units"), info.source_poses.split(), strict=False))
    try:
        return Conversion(units=info.source_units, axes=info.source_axes, **words)
    except InvalidOption:
        return Conversion()
