"""A results folder: results.json, timings.json, errors.csv, TUM trajectories and model.ply, written and read back."""

import csv
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import TypeAdapter, ValidationError

from orbitscan.processing.results.classification import SessionClassification
from orbitscan.processing.results.estimates import ERROR_NAMES, MethodResult
from orbitscan.processing.results.records import Coverage, Model, SessionResult, Turntable
from orbitscan.processing.results.status import Method, best_method
from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import UnreadableRecording
from orbitscan.recorder.formats import ply
from orbitscan.recorder.session import name_views

FORMAT_VERSION = 2
MAKE_AGAIN = "make it again: orbitscan process --overwrite"
ROUNDING = 1e-9  # metres: the arithmetic itself is no better
_LIBRARIES = ("numpy", "scipy", "numba", "torch", "rerun-sdk", "mcap")


@dataclass(frozen=True)
class SessionFacts:
    """What was processed."""

    name: str
    category: str | None
    instance: str | None
    views_recorded: int
    views_used: tuple[int, ...]
    view_names: tuple[str, ...]  # of the used views


@dataclass(frozen=True)
class InputFacts:
    """The recording that was read: its file's name, wherever it lay, and what of it is lost."""

    name: str
    sha256: str
    damage: str | None


@dataclass(frozen=True)
class ModelFacts:
    """The model in numbers; its points are in model.ply."""

    method: Method
    points: int
    removed_outliers: int
    mesh_triangles: int | None

    @classmethod
    def of(cls, model: Model) -> Self:
        """The numbers of a model."""
        triangles = None if model.mesh is None else len(model.mesh.triangles)
        return cls(model.method, len(model.points), len(model.removed), triangles)


@dataclass(frozen=True, eq=False)
class Results:
    """The content of results.json: the same bytes from run to run."""

    format_version: int
    key: dict[str, Any]  # see `key.make_key`
    session: SessionFacts
    input: InputFacts
    settings: dict[str, Any]
    versions: dict[str, str]
    seed: int
    classification: SessionClassification | None
    origin: int | None  # the view whose frame is {0}
    reconstruction: dict[Method, MethodResult]  # worst to best
    turntable: Turntable | None
    coverage: Coverage | None
    model: ModelFacts | None
    model_apart: ModelFacts | None = None  # of the next most views that hold together

    @classmethod
    def of(cls, result: SessionResult, key: Mapping[str, Any], input_name: str, damage: str | None) -> Self:
        """The content for a session's result, its recording's file name and what is damaged in it."""
        info, used, model = result.info, result.views_used, result.model
        session = SessionFacts(info.name, info.category, info.instance, info.views, used, result.view_names)
        return cls(
            format_version=FORMAT_VERSION,
            key=dict(key),
            session=session,
            input=InputFacts(input_name, key["input_sha256"], describe_damage(damage, result.unreadable)),
            settings=dict(result.settings),
            versions={name: version(name) for name in ("orbitscan", *_LIBRARIES)},
            seed=result.seed,
            classification=result.classification,
            origin=result.origin,
            reconstruction=dict(result.reconstruction),
            turntable=result.turntable,
            coverage=result.coverage,
            model=ModelFacts.of(model) if model else None,
            model_apart=ModelFacts.of(result.model_apart) if result.model_apart else None,
        )

    @property
    def best(self) -> MethodResult | None:
        """The result of the best method run; None where none was."""
        best = best_method(self.reconstruction)
        return self.reconstruction[best] if best else None


_JSON = TypeAdapter(Results)


@dataclass(frozen=True, eq=False)
class Extent:
    """Where an object is in frame {0}, and how large."""

    center: np.ndarray  # (3,) metres
    lever: float  # RMS distance of its points to the centre [m]
    diameter: float  # [m]
    points: int

    @classmethod
    def of(cls, points: np.ndarray) -> Self:
        """The extent of points (N, 3)."""
        points = np.asarray(points, dtype=np.float64)
        center = points.mean(axis=0)
        lever = float(np.sqrt(((points - center) ** 2).sum(axis=1).mean()))
        low, high = np.percentile(points, [1, 99], axis=0)
        return cls(center, max(lever, ROUNDING), float(np.linalg.norm(high - low)), len(points))


@dataclass(frozen=True, eq=False)
class ResultsFolder:
    """A complete results folder, read."""

    path: Path
    results: Results
    seconds: Mapping[str, Any]  # timings.json; empty where there is none

    @cached_property
    def model(self) -> tuple[np.ndarray, np.ndarray | None] | None:
        """Points (N, 3) float32 and colours (N, 3) uint8 of the model; None without one. Raises UnreadableRecording."""
        if self.results.model is None:
            return None
        try:
            return ply.read(self.path / "model.ply")
        except (OSError, ValueError) as error:
            raise _no_results(self.path, error) from None

    @cached_property
    def extent(self) -> Extent | None:
        """The extent of the model; None without one."""
        return Extent.of(self.model[0]) if self.model and len(self.model[0]) else None


def read_results(folder: str | Path) -> ResultsFolder:
    """A results folder. Raises UnreadableRecording where it is no whole one of this version."""
    folder = Path(folder)
    try:
        content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        if content["format_version"] != FORMAT_VERSION:
            raise ValueError(f"format_version {content['format_version']}, not {FORMAT_VERSION}")
        timings = folder / "timings.json"
        seconds = json.loads(timings.read_text(encoding="utf-8")) if timings.is_file() else {}
        return ResultsFolder(folder, _JSON.validate_python(content), seconds)
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise _no_results(folder, error) from None


def _no_results(folder: Path, error: Exception) -> UnreadableRecording:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        reason = f"results.json: {'.'.join(map(str, first['loc']))}: {first['msg'].lower()}"
    return UnreadableRecording(folder, f"holds no whole results ({reason})", MAKE_AGAIN)


def write_results(folder: Path, result: SessionResult, results: Results, truth: Mapping[int, np.ndarray]) -> None:
    """Write every file but the review into an existing folder."""
    _write_json(folder / "results.json", to_json(results))
    _write_json(folder / "timings.json", dict(result.seconds))
    _write_errors(folder / "errors.csv", result)
    for method, of_method in result.reconstruction.items():
        T_0 = {view.view: view.T_0_i for view in of_method.views if view.T_0_i is not None}
        _write_trajectory(folder / f"poses_{method}.tum", result, T_0)
    if result.origin is not None and result.origin in truth:
        T_0_object = poses.invert(truth[result.origin])
        T_0 = {view: T_0_object @ truth[view] for view in result.views_used if view in truth}
        _write_trajectory(folder / "poses_truth.tum", result, T_0)
    if result.model is not None:
        ply.write(folder / "model.ply", result.model.points, result.model.colors)
        if (mesh := result.model.mesh) is not None:
            ply.write(folder / "model_mesh.ply", mesh.vertices, mesh.colors, mesh.triangles)
    if result.model_apart is not None:
        ply.write(folder / "model_component_1.ply", result.model_apart.points, result.model_apart.colors)


def to_json(results: Results) -> dict[str, Any]:
    """The content of results.json in lists, mappings and numbers."""
    return _JSON.dump_python(results, by_alias=True)


def describe_damage(damage: str | None, unreadable: Mapping[int, str]) -> str | None:
    """What of a recording is lost, in a phrase: its own damage, and the unreadable views by index; None for nothing."""
    parts = [damage] if damage else []
    if unreadable:
        parts.append(f"{name_views(sorted(unreadable), len(unreadable))} unreadable")
    return "; ".join(parts) or None


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _write_errors(path: Path, result: SessionResult) -> None:
    names = dict(zip(result.views_used, result.view_names, strict=True))
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("view", "name", "method", "status", *ERROR_NAMES, "rotation_bound_deg", "center_bound_m"))
        for name, method in result.reconstruction.items():
            for view in method.views:
                errors, bounds = asdict(view.errors), (view.rotation_bound_deg, view.center_bound_m)
                table.writerow((view.view, names[view.view], name, view.status, *errors.values(), *bounds))


def _write_trajectory(path: Path, result: SessionResult, T_0: Mapping[int, np.ndarray]) -> None:
    lines = [
        poses.to_tum_line(stamp_ns, T_0[view])
        for view, stamp_ns in zip(result.views_used, result.stamps_ns, strict=True)
        if view in T_0
    ]
    path.write_text("".join(line + "\n" for line in lines), encoding="utf-8")
