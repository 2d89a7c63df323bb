"""The Washington RGB-D Object Dataset: a tree of CATEGORY_INSTANCE_VIDEO_FRAME.pcd -> one session per circle."""

import re
from collections import defaultdict
from functools import partial
from pathlib import Path

from orbitscan.recorder.conversion import Conversion
from orbitscan.recorder.exceptions import UnknownFormat
from orbitscan.recorder.session import Session, SessionInfo
from orbitscan.recorder.sources.clouds import load_view
from orbitscan.recorder.sources.options import CaptureOptions

_NAME = re.compile(r"(?P<category>[a-z]\w*?)_(?P<instance>\d+)_(?P<video>\d+)_(?P<frame>\d+)", re.IGNORECASE)
_AXES = "RFU"  # y away from the camera, z up
_ELEVATIONS_DEG = {1: 30.0, 2: 45.0, 4: 60.0}  # of the camera above the turntable, by video
_CIRCLE = 3  # views


def recognises(path: Path) -> bool:
    """Whether a .pcd, or every .pcd below a folder, is named as the dataset names its frames."""
    files = _find_files(path)
    return bool(files) and all(_NAME.fullmatch(file.stem) for file in files)


def sessions(path: Path, options: CaptureOptions) -> list[Session]:
    """A session per category, instance and video, frames in order; a loose view is a session of its own.

    A circle covers more than one turn and which frames there are is not known, so neither are the views per turn.
    Raises UnknownFormat, InvalidOption and, when a view is loaded, UnreadableCloud.
    """
    options.allow("washington")
    circles: dict[tuple[str, int, int], dict[int, Path]] = defaultdict(dict)
    for file in _find_files(path):
        if (match := _NAME.fullmatch(file.stem)) is None:
            continue
        frames = circles[match["category"], int(match["instance"]), int(match["video"])]
        if (first := frames.setdefault(int(match["frame"]), file)) is not file:
            raise UnknownFormat(path, f"holds {first} and {file}", "keep one file for each frame")
    if not circles:
        raise UnknownFormat(path, "holds no CATEGORY_INSTANCE_VIDEO_FRAME.pcd", "name a folder of the dataset")
    return [_session(*circle, [frames[i] for i in sorted(frames)]) for circle, frames in sorted(circles.items())]


def _session(category: str, instance: int, video: int, files: list[Path]) -> Session:
    conversion = Conversion(axes=_AXES)
    info = SessionInfo(
        name=f"{category}_{instance}_{video}",
        views=len(files),
        category=category,
        instance=str(instance),
        source="washington",
        sensor="Kinect",
        capture="circle" if len(files) >= _CIRCLE else "unknown",
        source_axes=conversion.axes,
        source_units=conversion.units,
        elevation_deg=_ELEVATIONS_DEG.get(video),
    )
    stamps = tuple((i + 1) * 10**9 for i in range(len(files)))
    return Session(info, tuple(file.stem for file in files), partial(load_view, files, stamps, conversion))


def _find_files(path: Path) -> list[Path]:
    files = [path] if path.is_file() else path.rglob("*")
    return sorted(file for file in files if file.suffix.lower() == ".pcd" and file.is_file())
