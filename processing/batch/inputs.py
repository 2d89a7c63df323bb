"""What the commands take for recordings: files, folders and patterns, and nothing that lies in results."""

import glob
from collections.abc import Iterable, Sequence
from pathlib import Path

from orbitscan.recorder.exceptions import InvalidOption, UnreadableRecording


def find_recordings(inputs: Sequence[Path]) -> list[Path]:
    """The recordings that files, folders and patterns name, in order; not those that lie in results.

    Raises ScanError for none, or two of one name.
    """
    found = [path for name in inputs for path in _expand(name)]
    by_name: dict[str, Path] = {}
    for path in dict.fromkeys(found):
        if path.stem.endswith((".part", ".part.old")):
            raise InvalidOption(path, "has the name of a folder that is not finished", "rename it")
        if (other := by_name.setdefault(path.stem, path)) is not path:
            raise InvalidOption(path, f"has the same name as {other}", "rename one: results are kept by name")
    return list(by_name.values())


def find_unfinished(inputs: Sequence[Path]) -> list[Path]:
    """The recordings in folders that `orbitscan convert` or `simulate` has not finished, or was stopped at."""
    return [path for folder in inputs if folder.is_dir() for path in _outside_results(folder.rglob("*.mcap.part"))]


def _expand(name: Path) -> list[Path]:
    if name.is_dir():
        if inside := _outside_results(name.rglob("*.mcap")):
            return inside
        raise UnreadableRecording(name, "the folder holds no recording (*.mcap)", "name one that does")
    if name.exists() or not glob.has_magic(str(name)):
        return [name]
    if fitting := _outside_results(map(Path, glob.glob(str(name), recursive=True))):
        return fitting
    raise UnreadableRecording(name, "no recording fits the pattern", "name recordings (*.mcap)")


def _outside_results(paths: Iterable[Path]) -> list[Path]:
    """Recordings in order, but for those that are part of results, which may be unfinished."""
    return sorted(p for p in paths if p.parent.suffix != ".part" and not (p.parent / "results.json").exists())
