"""The results folder: results.json, timings.json, errors.csv, TUM trajectories and model.ply."""

import csv
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.results.records import (
    ERROR_NAMES,
    Freedom,
    MethodResult,
    PairEstimate,
    SessionClassification,
    SessionResult,
    Turntable,
    ViewEstimate,
)
from orbitscan.recorder import poses
from orbitscan.recorder.formats import ply
from orbitscan.recorder.session import name_views

FORMAT_VERSION = 1
_LIBRARIES = ("numpy", "scipy", "numba", "torch", "rerun-sdk", "mcap")


def input_sha256(path: Path) -> str:
    """The SHA-256 of a file, hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def make_key(
    sha256: str, model: str | None, views: str, methods: tuple[str, ...], settings: Mapping[str, Any], seed: int
) -> dict[str, Any]:
    """What results depend on: a complete folder with the same key need not be made again."""
    key = {
        "orbitscan": version("orbitscan"),
        "input_sha256": sha256,
        "model_sha256": model,
        "views": views,
        "methods": list(methods),
        "settings": settings,
        "seed": seed,
    }
    return json.loads(json.dumps(key))  # as it is read back: a tuple is a list there


def read_key(folder: Path) -> dict[str, Any] | None:
    """The key of a complete results folder; None where there is none."""
    try:
        return read_results(folder)["key"]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def changed(known: Mapping[str, Any] | None, key: Mapping[str, Any]) -> str | None:
    """Which parts of the key differ from a folder's, in words; None where none does."""
    if known is None:
        return None
    return ", ".join(name.replace("_", " ") for name in key if known.get(name) != key[name]) or None


def read_results(folder: str | Path) -> dict[str, Any]:
    """The results.json of a complete results folder."""
    return json.loads((Path(folder) / "results.json").read_text(encoding="utf-8"))


def write_results(
    folder: Path,
    result: SessionResult,
    key: Mapping[str, Any],
    path: Path,
    damage: str | None,
    truth: Mapping[int, np.ndarray],
) -> None:
    """Write every file but the review into an existing folder."""
    _write_json(folder / "results.json", to_json(result, key, path, damage))
    _write_json(folder / "timings.json", dict(result.seconds))
    _write_errors(folder / "errors.csv", result)
    for method, of_method in result.reconstruction.items():
        T_0 = {view.view: view.T_0_i for view in of_method.views if view.T_0_i is not None}
        _write_trajectory(folder / f"poses_{method}.tum", result, T_0)
    if result.origin in truth:
        T_0_object = poses.invert(truth[result.origin])
        T_0 = {view: T_0_object @ truth[view] for view in result.views_used if view in truth}
        _write_trajectory(folder / "poses_truth.tum", result, T_0)
    if result.model is not None:
        ply.write(folder / "model.ply", result.model.points, result.model.colors)
        if (mesh := result.model.mesh) is not None:
            ply.write(folder / "model_mesh.ply", mesh.vertices, mesh.colors, mesh.triangles)


def to_json(result: SessionResult, key: Mapping[str, Any], path: Path, damage: str | None) -> dict[str, Any]:
    """The content of results.json: the same bytes from run to run."""
    info = result.info
    return {
        "format_version": FORMAT_VERSION,
        "key": dict(key),
        "session": {
            "name": info.name,
            "category": info.category,
            "instance": info.instance,
            "views_recorded": info.views,
            "views_used": list(result.views_used),
            "view_names": list(result.view_names),
        },
        "input": {
            "path": path.as_posix(),
            "sha256": key["input_sha256"],
            "damage": describe_damage(damage, result.unreadable),
        },
        "settings": dict(result.settings),
        "versions": {"orbitscan": version("orbitscan"), **{name: version(name) for name in _LIBRARIES}},
        "seed": result.seed,
        "classification": _classification_to_json(result.classification),
        "reconstruction": {name: _method_to_json(method) for name, method in result.reconstruction.items()},
        "turntable": _turntable_to_json(result.turntable),
        "model": None
        if result.model is None
        else {
            "method": result.model.method,
            "points": len(result.model.points),
            "removed_outliers": len(result.model.removed),
            "mesh_triangles": None if result.model.mesh is None else len(result.model.mesh.triangles),
        },
    }


def describe_damage(damage: str | None, unreadable: Mapping[int, str]) -> str | None:
    """What of a recording is lost, in a phrase: its own damage, and the unreadable views by index; None for nothing."""
    parts = [damage] if damage else []
    if unreadable:
        parts.append(f"{name_views(sorted(unreadable), len(unreadable))} unreadable")
    return "; ".join(parts) or None


def _method_to_json(method: MethodResult) -> dict[str, Any]:
    return {
        "views": [_view_to_json(view) for view in method.views],
        "pairs": [_pair_to_json(pair) for pair in method.pairs],
        "loop_closed": method.loop_closed,
        "unobservable": [_freedom_to_json(freedom) for freedom in method.freedoms],
        "summary": dict(method.summary),
    }


def _view_to_json(view: ViewEstimate) -> dict[str, Any]:
    return {"view": view.view, "status": view.status, "T_0_i": _matrix(view.T_0_i), **asdict(view.errors)}


def _pair_to_json(pair: PairEstimate) -> dict[str, Any]:
    return {
        "source": pair.source,
        "target": pair.target,
        "T_target_source": _matrix(pair.T_target_source),
        "status": pair.status,
        "confidence": pair.confidence,
        "evidence": asdict(pair.evidence),
        "start": pair.start,
        "candidates": [asdict(candidate) for candidate in pair.candidates],
        "unobservable": [_freedom_to_json(freedom) for freedom in pair.freedoms],
        "alternatives": [_matrix(T) for T in pair.alternatives],
        **asdict(pair.errors),
    }


def _freedom_to_json(freedom: Freedom) -> dict[str, Any]:
    return {"kind": freedom.kind, "axis": freedom.axis.tolist(), "point": freedom.point.tolist()}


def _classification_to_json(found: SessionClassification | None) -> dict[str, Any] | None:
    return None if found is None else asdict(found)


def _turntable_to_json(turntable: Turntable | None) -> dict[str, Any] | None:
    if turntable is None:
        return None
    return asdict(turntable) | {"axis": turntable.axis.tolist(), "point": turntable.point.tolist()}


def _matrix(T: np.ndarray | None) -> list[list[float]] | None:
    return None if T is None else T.tolist()


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _write_errors(path: Path, result: SessionResult) -> None:
    names = dict(zip(result.views_used, result.view_names, strict=True))
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("view", "name", "method", "status", *ERROR_NAMES))
        for name, method in result.reconstruction.items():
            for view in method.views:
                errors = asdict(view.errors)
                table.writerow((view.view, names[view.view], name, view.status, *errors.values()))


def _write_trajectory(path: Path, result: SessionResult, T_0: Mapping[int, np.ndarray]) -> None:
    lines = [
        poses.to_tum_line(stamp_ns, T_0[view])
        for view, stamp_ns in zip(result.views_used, result.stamps_ns, strict=True)
        if view in T_0
    ]
    path.write_text("".join(line + "\n" for line in lines), encoding="utf-8")
