"""Range scans of the Stanford 3D Scanning Repository: a .conf that places PLY files -> one session.

A line `bmesh FILE tx ty tz qx qy qz qw` means p_world = R(q)^T p + t, with R the rotation of the Hamilton quaternion
(x, y, z, w): the rotation is written inverted, the translation is not.
"""

from pathlib import Path

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.conversion import CaptureOptions, Conversion
from orbitscan.recorder.exceptions import InvalidPose, UnknownFormat, UnreadableCloud
from orbitscan.recorder.session import Session
from orbitscan.recorder.sources.clouds import make_session

_AXES = "RUB"  # y up, the surfaces face +z
# The scanner sweeps a laser sheet over parallel lines: its rays come from far in front of the object, not from a
# point near it. Ten metres away all directions agree to a degree over an object of 0.2 m.
_SENSOR_ORIGIN = (0.0, 0.0, 10.0)


def recognises(path: Path) -> bool:
    """Whether a file, or a file of a folder, is a .conf that places scans."""
    return bool(_find_confs(path))


def sessions(path: Path, options: CaptureOptions) -> list[Session]:
    """The one session of a .conf, named itself or by the folder that holds it; views in the order of its lines.

    A `mesh` line whose file is absent is skipped, as is the `camera` line. Raises UnknownFormat, UnreadableCloud,
    InvalidPose and InvalidOption.
    """
    options.allow("stanford", "category", "instance", "name")
    confs = _find_confs(path)
    if not confs:
        raise UnknownFormat(path, "holds no .conf with bmesh lines", "name the .conf of a Stanford scan")
    if len(confs) > 1:
        raise UnknownFormat(path, f"holds {' and '.join(c.name for c in confs)}", "name one of them")
    conf = confs[0]
    conversion = Conversion(axes=_AXES, pose_axes=_AXES)
    files: list[Path] = []
    truth: dict[int, np.ndarray] = {}
    for number, line in enumerate(conf.read_text(errors="replace").splitlines(), 1):
        words = line.split()
        if not words or words[0] not in ("bmesh", "mesh"):
            continue
        subject = f"{conf}, line {number}"
        if len(words) != 9:
            raise InvalidPose(subject, f"{len(words) - 2} numbers after the file, not 7", "write tx ty tz qx qy qz qw")
        file = conf.parent / words[1]
        if not file.is_file():
            if words[0] == "mesh":
                continue
            raise UnreadableCloud(file, f"no such file, but {conf.name} places it", "add the scan or remove its line")
        truth[len(files)] = conversion.pose(_motion(words[2:], subject))
        files.append(file)
    if not files:
        raise UnknownFormat(conf, "none of its scans is there", "put the .ply files beside it")
    session = make_session(
        files,
        conversion,
        truth,
        name=options.name or conf.stem,
        category=options.category,
        instance=options.instance,
        source="stanford",
        sensor="laser range scanner",
        capture="unordered",
        sensor_origin=conversion.origin(_SENSOR_ORIGIN),
    )
    return [session]


def _motion(words: list[str], subject: str) -> np.ndarray:
    """The motion T_world_scan (4, 4) that the seven numbers of a line mean. Raises InvalidPose."""
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        raise InvalidPose(subject, "a word that is no number", "write tx ty tz qx qy qz qw") from None
    T = poses.from_quaternion(numbers[:3], numbers[3:], subject)
    return poses.make(T[:3, :3].T, T[:3, 3])


def _find_confs(path: Path) -> list[Path]:
    files = [path] if path.is_file() else sorted(path.glob("*.conf"))
    return [file for file in files if file.suffix.lower() == ".conf" and b"bmesh " in file.read_bytes()]
