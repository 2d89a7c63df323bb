"""A folder of single-view clouds, or one cloud file, with or without poses -> one session."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from natsort import natsorted

from orbitscan.recorder import poses
from orbitscan.recorder.conversion import CaptureOptions, Conversion
from orbitscan.recorder.exceptions import InvalidPose, UnknownFormat, Wording
from orbitscan.recorder.formats import cloud_file, pose_file
from orbitscan.recorder.formats.pose_file import PoseFile
from orbitscan.recorder.session import Session, SessionInfo, View


def recognises(path: Path) -> bool:
    """Whether a file is a cloud, or a folder holds some."""
    return bool(find_clouds(path))


def find_clouds(path: Path) -> list[Path]:
    """The cloud files of a folder (not of its subfolders) in natural order, or the one file itself."""
    files = [path] if path.is_file() else path.iterdir()
    others = set() if path.is_file() else set(pose_file.find(path))
    return natsorted(
        (file for file in files if file.suffix.lower() in cloud_file.READERS and file.is_file() and file not in others),
        key=lambda file: file.name,
    )


def sessions(path: Path, options: CaptureOptions) -> list[Session]:
    """The one session of a folder of clouds (or a cloud file); a view per file, in natural order of the names.

    Poses come from the file that the options name, else from the one beside the clouds whose name speaks of poses. They
    go to clouds by name where the file has names (JSON), else by order, which takes as many poses as clouds. Raises
    UnknownFormat, InvalidPose, InvalidOption, and, when a view is loaded, UnreadableCloud.
    """
    conversion = options.conversion()
    files = find_clouds(path)
    if not files:
        known = " ".join(cloud_file.READERS)
        raise UnknownFormat(path, f"holds no cloud file ({known})", "name the folder that holds the clouds")
    names = tuple(file.stem for file in files)
    if len(set(names)) < len(names):
        twice = [file.name for file in files if names.count(file.stem) > 1][:2]
        raise UnknownFormat(path, f"holds {twice[0]} and {twice[1]}", "keep one file for each view")
    listed = _listed_poses(path, options)
    truth = {} if listed is None else _assign(listed, files, conversion)
    name = options.name or (path.resolve().stem if path.is_file() else path.resolve().name)
    facts = {**facts_of(options, conversion), "name": name, "category": options.category, "instance": options.instance}
    stamps_ns = listed.stamps_ns if listed else None
    return [make_session(files, conversion, truth, stamps_ns, options.columns, **facts)]


def make_session(
    files: Sequence[Path],
    conversion: Conversion,
    truth: Mapping[int, np.ndarray],
    stamps_ns: Sequence[int] | None = None,
    columns: cloud_file.Columns | None = None,
    **facts: Any,
) -> Session:
    """A session of a view per file, a second apart where there are no stamps; `facts` are fields of SessionInfo.

    To load a view raises UnreadableCloud and InvalidOption.
    """

    def load(index: int) -> View:
        points, colors = cloud_file.read(files[index], columns)
        stamp_ns = stamps_ns[index] if stamps_ns else (index + 1) * 10**9
        return View(index, files[index].stem, stamp_ns, conversion.points(points), colors)

    info = SessionInfo(
        views=len(files),
        source_axes=conversion.axes,
        source_units=conversion.units,
        source_poses=conversion.pose_words if truth else "",
        **facts,
    )
    return Session(info, tuple(file.stem for file in files), load, lambda: truth)


def facts_of(options: CaptureOptions, conversion: Conversion) -> dict[str, Any]:
    """The facts of plain clouds that hold for all of them; the sensor is at the origin where nothing is said."""
    said = options.sensor_origin
    origin = None if said == "unknown" else conversion.origin(said or (0.0, 0.0, 0.0))
    return {"source": "clouds", "sensor_origin": origin, "elevation_deg": options.elevation}


def _listed_poses(path: Path, options: CaptureOptions) -> PoseFile | None:
    if options.poses is not None:
        return pose_file.read(options.poses)
    found = pose_file.find(path) if path.is_dir() else []
    if len(found) > 1:
        problem = f"{found[0].name} and {found[1].name} may both hold poses"
        raise InvalidPose(path, problem, Wording("name one with {poses}"))
    return pose_file.read(found[0]) if found else None


def _assign(listed: PoseFile, files: Sequence[Path], conversion: Conversion) -> dict[int, np.ndarray]:
    """View -> T_object_camera: by name where the names match, by order where the counts do."""
    by_name = {name: i for i, file in enumerate(files) for name in (file.stem, file.name)}
    if listed.names and any(name in by_name for name in listed.names):
        if strangers := [name for name in listed.names if name not in by_name]:
            raise InvalidPose(listed.path, f"names '{strangers[0]}', which is no cloud", "name the clouds' files")
        views = [by_name[name] for name in listed.names]
        if len(set(views)) < len(views):
            raise InvalidPose(listed.path, "names a cloud twice", "give each cloud one pose")
    elif len(listed.motions) == len(files):
        views = list(range(len(files)))
    else:
        raise InvalidPose(
            listed.path,
            f"holds {len(listed.motions)} poses for {len(files)} clouds",
            "give a pose for each cloud, in the natural order of their names, or name the clouds in a JSON file",
        )
    motions = zip(views, listed.motions, strict=True)
    return {
        i: conversion.pose(poses.check(T, f"{listed.path}, pose of {files[i].name}"))
        for i, T in sorted(motions, key=lambda pair: pair[0])
        if T is not None
    }
