"""From a source's units and axes to metres in the camera's optical frame, for points and for poses."""

from dataclasses import dataclass, fields

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import SessionInfo

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
DIRECTIONS = ("camera-to-object", "object-to-camera")


@dataclass(frozen=True)
class Conversion:
    """How the numbers of a source are read; the fields are named as the options of `orbitscan convert`.

    Raises InvalidOption for a word that is none of the known ones.
    """

    units: str = "m"  # of the points
    scale: float = 1.0  # metres = numbers x units x scale, in points and poses
    axes: str = "RDF"  # where x, y, z of the points' frame point, as Rerun's ViewCoordinates are named
    poses_are: str = "camera-to-object"
    pose_axes: str = "RDF"  # of the camera frame the poses speak of
    pose_units: str = "m"

    def __post_init__(self) -> None:
        for option, word, known in (
            ("--units", self.units, METRES),
            ("--pose-units", self.pose_units, METRES),
            ("--poses-are", self.poses_are, DIRECTIONS),
        ):
            if word not in known:
                raise InvalidOption(f"{option} {word}", "no word that is known", f"give {' or '.join(known)}")
        if not (np.isfinite(self.scale) and self.scale > 0):
            raise InvalidOption(f"--scale {self.scale:g}", "no positive number", "give metres per unit of the source")
        for axes in (self.axes, self.pose_axes):
            poses.axes_to_rdf(axes)

    @property
    def pose_words(self) -> str:
        """How poses are read, in three words such as `camera-to-object RDF m`."""
        return f"{self.poses_are} {self.pose_axes} {self.pose_units}"

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points (N, 3) of the source, in the view's frame [m]; float32."""
        factor = METRES[self.units] * self.scale
        return poses.transform(poses.make(factor * poses.axes_to_rdf(self.axes), np.zeros(3)), points).astype(
            np.float32
        )

    def origin(self, position: tuple[float, float, float]) -> tuple[float, float, float]:
        """A position in the points' frame, in the view's frame [m]."""
        x, y, z = self.points(np.array([position], dtype=np.float64))[0].tolist()
        return x + 0.0, y + 0.0, z + 0.0  # -0 is 0

    def pose(self, T_file: np.ndarray) -> np.ndarray:
        """T_object_camera of a rigid motion as the source writes it; the object's frame keeps its axes."""
        T = poses.make(T_file[:3, :3], T_file[:3, 3] * METRES[self.pose_units] * self.scale)
        T_object_source = poses.invert(T) if self.poses_are == "object-to-camera" else T
        return T_object_source @ poses.make(poses.axes_to_rdf(self.pose_axes).T, np.zeros(3))

    def source_pose(self, T_object_camera: np.ndarray) -> np.ndarray:
        """The motion as the source writes it, of T_object_camera."""
        T = T_object_camera @ poses.make(poses.axes_to_rdf(self.pose_axes), np.zeros(3))
        T = poses.invert(T) if self.poses_are == "object-to-camera" else T
        return poses.make(T[:3, :3], T[:3, 3] / (METRES[self.pose_units] * self.scale))

    def flags(self, given: "Conversion") -> str:
        """The options of `orbitscan convert` that turn another conversion into this one."""
        said = [field.name for field in fields(self) if getattr(self, field.name) != getattr(given, field.name)]
        # What is said of the points holds for the poses too, unless it is said of these.
        for name in ("axes", "units"):
            if name in said:
                said = [other for other in said if other != f"pose_{name}"]
                said += [f"pose_{name}"] if getattr(self, f"pose_{name}") != getattr(self, name) else []
        return " ".join(f"--{name.replace('_', '-')} {getattr(self, name)}" for name in said)


def recorded(info: SessionInfo) -> Conversion:
    """The conversion that a session's facts tell of; what they do not tell, or tell wrong, is the default."""
    words = dict(zip(("poses_are", "pose_axes", "pose_units"), info.source_poses.split(), strict=False))
    try:
        return Conversion(units=info.source_units, axes=info.source_axes, **words)
    except InvalidOption:
        return Conversion()
