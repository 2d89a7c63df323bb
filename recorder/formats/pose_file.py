"""A file of poses -> motions as they stand there, with their names or stamps: TUM, KITTI, 4x4 and JSON."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from natsort import natsorted

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidPose, Wording

_SHAPES = "TUM (stamp x y z qx qy qz qw), KITTI (12 numbers a line), 4x4 (16 numbers a line, or 4 lines of 4) or JSON"
_NAMES = ("pose", "traj", "truth", "extrinsic", "transform")
_SUFFIXES = (".txt", ".json", ".csv", ".log")


@dataclass(frozen=True, eq=False)
class PoseFile:
    """Poses in the order of their file, in its units, axes and direction; None for one that is unknown."""

    path: Path
    motions: tuple[np.ndarray | None, ...]  # (4, 4) each, not checked
    names: tuple[str, ...] | None = None  # of a JSON object, in natural order
    stamps_ns: tuple[int, ...] | None = None  # of a TUM file


def find(folder: Path) -> list[Path]:
    """The files of a folder whose names say that they hold poses (`poses.txt`, `trajectory.tum`, `truth.json`, ...)."""
    return sorted(path for path in folder.iterdir() if path.is_file() and _speaks_of_poses(path))


def _speaks_of_poses(path: Path) -> bool:
    suffix, stem = path.suffix.lower(), path.stem.lower()
    return suffix in (".tum", ".kitti") or (suffix in _SUFFIXES and any(name in stem for name in _NAMES))


def read(path: Path) -> PoseFile:
    """The poses of a file, its format recognised from its content; raises InvalidPose.

    JSON is a list of poses, an object {name: pose}, or {"poses": either}; a pose is 4x4 or 3x4 numbers, nested or in
    one row, or null where it is unknown.
    """
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise InvalidPose(path, f"cannot be read ({error.strerror})", Wording("check {poses}")) from None
    if path.suffix.lower() == ".json" or text.lstrip().startswith(("{", "[")):
        return _read_json(path, text)
    return _read_lines(path, text)


def _read_json(path: Path, text: str) -> PoseFile:
    try:
        content = json.loads(text)
    except ValueError as error:
        raise InvalidPose(path, f"is no JSON ({error})", "mend the file") from None
    if isinstance(content, dict) and "poses" in content:
        content = content["poses"]
    if isinstance(content, dict):
        names = tuple(natsorted(content))  # an object of JSON has no order
        return PoseFile(path, tuple(_motion(content[name], f"{path}, pose '{name}'") for name in names), names)
    if isinstance(content, list):
        return PoseFile(path, tuple(_motion(pose, f"{path}, pose {i}") for i, pose in enumerate(content)))
    remedy = 'give [4x4, ...], {"name": 4x4, ...} or {"poses": ...}'
    raise InvalidPose(path, f"holds a {type(content).__name__}", remedy)


def _motion(numbers: Any, subject: str) -> np.ndarray | None:
    """The 4x4 motion of 16 or 12 numbers in whatever nesting; None for None. Raises InvalidPose."""
    if numbers is None:
        return None
    try:
        flat = np.asarray(numbers, dtype=np.float64).ravel()
    except (ValueError, TypeError):
        flat = np.empty(0)
    if flat.size not in (12, 16):
        raise InvalidPose(subject, "is neither 4x4 nor 3x4 numbers", "give [[r, r, r, t], ...], metres")
    return np.vstack([flat.reshape(-1, 4), (0, 0, 0, 1)])[:4]


def _read_lines(path: Path, text: str) -> PoseFile:
    lines = (line.split("#")[0].replace(",", " ").split() for line in text.splitlines())
    rows = [(number, words) for number, words in enumerate(lines, 1) if words]
    widths = {len(words) for _, words in rows}
    if widths == {8}:
        pairs = [poses.from_tum_line(" ".join(words), f"{path}, line {number}") for number, words in rows]
        if early := [stamp for stamp, _ in pairs if not 0 <= stamp < 2**63]:
            raise InvalidPose(path, f"holds the stamp {early[0] / 1e9:g} s", "give seconds from 0 up")
        return PoseFile(path, tuple(T for _, T in pairs), stamps_ns=tuple(stamp for stamp, _ in pairs))
    try:
        numbers = [[float(word) for word in words] for _, words in rows]
    except ValueError as error:
        raise InvalidPose(path, f"holds a word that is no number ({error})", f"give {_SHAPES}") from None
    if widths == {4} and len(rows) % 4 == 0:
        numbers = np.array(numbers).reshape(-1, 16).tolist()
    elif widths not in ({12}, {16}):
        found = " and ".join(str(width) for width in sorted(widths)) or "no"
        raise InvalidPose(path, f"has lines of {found} numbers", f"give {_SHAPES}")
    return PoseFile(path, tuple(_motion(row, str(path)) for row in numbers))
