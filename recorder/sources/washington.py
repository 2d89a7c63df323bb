"""The Washington RGB-D Object Dataset: a tree of CATEGORY_INSTANCE_VIDEO_FRAME.pcd -> one session per circle.

Here stands too what the thesis takes of it (tables 3.1 and 3.2), which the virtual corpus copies.
"""

import re
from collections import defaultdict
from pathlib import Path

from orbitscan.recorder.conversion import CaptureOptions, Conversion
from orbitscan.recorder.exceptions import UnknownFormat
from orbitscan.recorder.session import Session
from orbitscan.recorder.sources.clouds import make_session

_NAME = re.compile(r"(?P<category>[a-z]\w*?)_(?P<instance>\d+)_(?P<video>\d+)_(?P<frame>\d+)", re.IGNORECASE)
_AXES = "RFU"  # y away from the camera, z up
ELEVATIONS_DEG = {1: 30.0, 2: 45.0, 4: 60.0}  # of the camera above the turntable, by the number of the video
INSTANCES = {  # of each category in thesis table 3.1; the last is the test instance
    "apple": 5, "bell_pepper": 6, "bowl": 6, "cap": 4, "cell_phone": 5,
    "coffee_mug": 8, "dry_battery": 6, "notebook": 5, "pliers": 6, "water_bottle": 10,
}  # fmt: skip
RUNS = {  # thesis table 3.2: into how many equal runs a circle is cut, each a side to tell apart
    "apple": 1, "bell_pepper": 1, "bowl": 1, "cap": 6, "cell_phone": 6,
    "coffee_mug": 4, "dry_battery": 4, "notebook": 4, "pliers": 6, "water_bottle": 1,
}  # fmt: skip
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
    return make_session(
        files,
        Conversion(axes=_AXES),
        {},
        name=f"{category}_{instance}_{video}",
        category=category,
        instance=str(instance),
        source="washington",
        sensor="Kinect",
        capture="circle" if len(files) >= _CIRCLE else "unknown",
        elevation_deg=ELEVATIONS_DEG.get(video),
    )


def _find_files(path: Path) -> list[Path]:
    files = [path] if path.is_file() else path.rglob("*")
    return sorted(file for file in files if file.suffix.lower() == ".pcd" and file.is_file())
