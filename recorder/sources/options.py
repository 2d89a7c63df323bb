"""What a user may say about a capture."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

from orbitscan.recorder.conversion import Conversion
from orbitscan.recorder.exceptions import InvalidOption


@dataclass(frozen=True)
class CaptureOptions:
    """The options of `orbitscan convert`; None where the user said nothing."""

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
                raise InvalidOption(
                    f"--{field.name.replace('_', '-')}",
                    f"the {format_name} format settles it",
                    "leave it out, or pass --format clouds",
                )

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
