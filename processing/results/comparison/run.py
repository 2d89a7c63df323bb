"""Results folders, read back: one session's, or a batch's by name; and what they were made from."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.results.comparison.uncertainty import Extent
from orbitscan.processing.results.files import FORMAT_VERSION, read_results
from orbitscan.recorder.exceptions import InvalidOption, UnreadableRecording
from orbitscan.recorder.formats import ply

SHOWN_SETTINGS = 5  # that differ
MAKE_AGAIN = "make it again: orbitscan process --overwrite"


@dataclass(frozen=True, eq=False)
class Run:
    """A results folder, read."""

    folder: Path
    results: Mapping[str, Any]
    extent: Extent | None  # of the model; None without one
    model: np.ndarray | None  # (N, 3) float32
    colors: np.ndarray | None  # (N, 3) uint8
    seconds: Mapping[str, Any]

    @property
    def origin(self) -> int | None:
        """The view whose frame is {0}: its pose is the identity, exactly."""
        for method in self.results["reconstruction"].values():
            for view in method["views"]:
                if view["T_0_i"] is not None and np.array_equal(view["T_0_i"], np.eye(4)):
                    return view["view"]
        return None


def find_sessions(folder: Path) -> dict[str, Path] | None:
    """The sessions of a batch's folder by name; None where the folder is a session's. Raises InvalidOption."""
    if (folder / "results.json").is_file():
        return None
    found = {path.parent.name: path.parent for path in sorted(folder.glob("*/results.json"))}
    found = {name: path for name, path in found.items() if not name.endswith(".part")}
    if not found:
        problem = "holds no results" if folder.is_dir() else "no such folder"
        raise InvalidOption(folder, problem, "name what 'orbitscan process -o' wrote: a session's folder or a batch's")
    return found


def read_run(folder: Path) -> Run:
    """A results folder. Raises UnreadableRecording where it is no whole one of this version."""
    try:
        results = read_results(folder)
        if results["format_version"] != FORMAT_VERSION:
            raise ValueError(f"format_version {results['format_version']}, not {FORMAT_VERSION}")
        model, colors = ply.read(folder / "model.ply") if results["model"] else (None, None)
        timings = folder / "timings.json"
        seconds = json.loads(timings.read_text(encoding="utf-8")) if timings.is_file() else {}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise UnreadableRecording(folder, f"holds no whole results ({reason})", MAKE_AGAIN) from None
    extent = Extent.of(model) if model is not None and len(model) else None
    return Run(folder, results, extent, model, colors, seconds)


def same_recording(a: Run, b: Run) -> bool:
    """Whether both were made from one recording, to the byte."""
    return a.results["key"]["input_sha256"] == b.results["key"]["input_sha256"]


def content(run: Run) -> dict[str, Any]:
    """The results but for where the recording was."""
    return {**run.results, "input": {**run.results["input"], "path": None}}


def describe_differences(a: Run, b: Run) -> Iterator[str]:
    """What else differs between two runs than what came out, a phrase each."""
    keys = [run.results["key"] for run in (a, b)]
    names = [run.results["session"]["name"] for run in (a, b)]
    if names[0] != names[1]:
        yield f"session: {names[0]} in A, {names[1]} in B"
    if not same_recording(a, b):
        yield "another recording: differences may be of the input; poses are compared by their errors alone"
    rest = [{name: value for name, value in key.items() if name not in ("input_sha256", "settings")} for key in keys]
    for name in (name for name in rest[1] if rest[0].get(name) != rest[1][name]):
        label = "model" if name == "model_sha256" else name
        values = [_brief(key.get(name)) for key in rest]
        yield f"{label}: {values[0]} in A, {values[1]} in B"
    settings = [dict(_flatten(key["settings"])) for key in keys]
    differing = [name for name in settings[1] | settings[0] if settings[0].get(name) != settings[1].get(name)]
    for name in differing[:SHOWN_SETTINGS]:
        yield f"settings: {name} = {_brief(settings[0].get(name))} in A, {_brief(settings[1].get(name))} in B"
    if len(differing) > SHOWN_SETTINGS:
        yield f"settings: {len(differing) - SHOWN_SETTINGS} more differ"
    if keys[0] == keys[1]:
        old, new = (run.results["versions"] for run in (a, b))
        libraries = [f"{name} {old.get(name)} in A, {version} in B" for name, version in new.items()]
        libraries = [text for text, name in zip(libraries, new, strict=True) if old.get(name) != new[name]]
        yield "the same recording and settings, yet other results: " + ("; ".join(libraries) or "by the same libraries")
    used = [run.results["session"]["views_used"] for run in (a, b)]
    for views, others, name in ((used[0], used[1], "A"), (used[1], used[0], "B")):
        if only := [view for view in views if view not in others]:
            yield f"views in {name} only: {', '.join(map(str, only))}"
    if a.origin != b.origin:
        yield f"frame {{0}} is view {a.origin} in A, view {b.origin} in B: poses and errors cannot be compared"
    damages = [run.results["input"]["damage"] for run in (a, b)]
    if damages[0] != damages[1]:
        yield f"damage: {damages[0] or 'none'} in A, {damages[1] or 'none'} in B"


def _flatten(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _brief(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if isinstance(value, float):
        return f"{value:.6g}"
    return f"{value[:8]}..." if isinstance(value, str) and len(value) == 64 else str(value)
