"""What the commands take for recordings: files, folders and patterns, and nothing that lies in results."""

import glob
from collections.abc import Sequence
from itertools import filterfalse
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
    found = [path for folder in inputs if folder.is_dir() for path in sorted(folder.rglob("*.mcap.part"))]
    return list(filterfalse(_lies_in_results, found))


def _expand(name: Path) -> list[Path]:
    if name.is_dir():
        inside = list(filterfalse(_lies_in_results, sorted(name.rglob("*.mcap"))))
        if not inside:
            raise UnreadableRecording(name, "the folder holds no recording (*.mcap)", "name one that does")
        return inside
    if name.exists() or not glob.has_magic(str(name)):
        return [name]
    fitting = list(filterfalse(_lies_in_results, sorted(map(Path, glob.glob(str(name), recursive=True)))))
    if not fitting:
        raise UnreadableRecording(name, "no recording fits the pattern", "name recordings (*.mcap)")
    return fitting


def _lies_in_results(path: Path) -> bool:
    """Whether a recording is part of results, which may be unfinished."""
    return (path.parent / "results.json").exists() or path.parent.suffix == ".part"
