"""A tree of folders named after what their clouds show -> a session for each cloud."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from natsort import natsorted

from orbitscan.recorder import mcap_file
from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, UnknownFormat, UnreadableCloud, Wording, setting
from orbitscan.recorder.formats import cloud_file, pose_file
from orbitscan.recorder.session import Session
from orbitscan.recorder.sources.clouds import facts_of, find_clouds, make_session


@dataclass(frozen=True)
class LabelledCloud:
    """A cloud file in a tree whose first folders are categories."""

    file: Path
    folders: tuple[str, ...]  # from the tree's root down to the file, at least one

    @property
    def category(self) -> str:
        """The category: the first folder's name as a slug."""
        return re.sub(r"[^\w.]+", "_", self.folders[0].strip().lower())

    @property
    def name(self) -> str:
        """A short name for the session: the file's stem, after the category where it does not begin with it."""
        stem = _for_file_names(self.file.stem)
        return stem if stem.lower().startswith(self.category) else f"{self.category}_{stem}"

    @property
    def full_name(self) -> str:
        """A long name for the session: the category, all folders below it, and the file's stem."""
        return "_".join((self.category, *map(_for_file_names, (*self.folders[1:], self.file.stem))))


def _for_file_names(text: str) -> str:
    return re.sub(r"[^\w.-]+", "_", text.strip())


def find_tree(path: Path) -> Iterator[LabelledCloud]:
    """The cloud files in the folders of a folder, at any depth, in natural order; hidden ones are left out."""
    for folder in natsorted((f for f in path.iterdir() if f.is_dir()), key=lambda folder: folder.name):
        if not folder.name.startswith("."):
            files = (file for file in find_clouds(folder) if not file.name.startswith("."))
            yield from (LabelledCloud(file, (folder.name,)) for file in files)
            yield from (LabelledCloud(item.file, (folder.name, *item.folders)) for item in find_tree(folder))


def sessions(path: Path, options: CaptureOptions) -> list[Session]:
    """A session of one view for each cloud of a tree whose first folders are categories, in natural order.

    The category is the folder's name as a slug, the instance the file's stem; names are as short as keeps them apart.
    Raises UnknownFormat, InvalidPose, InvalidOption, and, when a view is loaded, UnreadableCloud.
    """
    conversion = options.conversion()
    _refuse_what_folders_settle(path, options)
    found = list(find_tree(path))
    if not found:
        known = " ".join(cloud_file.READERS)
        raise UnknownFormat(path, f"its folders hold no cloud file ({known})", "name the folder above the categories")
    facts = facts_of(options, conversion)
    made = []
    for item, name in zip(found, _names(path, found), strict=True):
        facts |= {"name": name, "category": item.category, "instance": item.file.stem}
        made.append(make_session([item.file], conversion, {}, columns=options.columns, **facts))
    return made


def record(placed: Iterable[tuple[Path, Session]]) -> Iterator[Session | UnreadableCloud]:
    """Record each session where it is placed: what its recording then reads as, or why its cloud cannot be read.

    Raises UnwritableOutput.
    """
    for path, session in placed:
        try:
            mcap_file.write(session, path)
        except UnreadableCloud as error:
            yield error
        else:
            yield mcap_file.read(path)


def _refuse_what_folders_settle(path: Path, options: CaptureOptions) -> None:
    if not path.is_dir():
        remedy = Wording("leave out {categories_from_folders}")
        raise UnknownFormat(path, "is a file, not a folder of categories", remedy)
    for option in ("poses", "poses_are", "pose_axes", "pose_units"):
        if getattr(options, option) is not None:
            what = Wording("is not for {categories_from_folders}, which makes a session of each view")
            raise InvalidOption(setting(option), what, "leave one of them out")
    for option in ("category", "instance", "name"):
        if getattr(options, option) is not None:
            raise InvalidOption(setting(option), "the folders and files settle it", "leave it out")
    if loose := find_clouds(path):
        raise UnknownFormat(loose[0], "lies in no category's folder", "move it into one")
    folders = (f for f in path.rglob("*") if f.is_dir())
    if listed := next((file for folder in (path, *folders) for file in pose_file.find(folder)), None):
        raise InvalidPose(listed, "may hold poses, but each view is a session of its own", "move or rename it")


def _names(path: Path, found: Sequence[LabelledCloud]) -> list[str]:
    """A name for each cloud: the short one, or the full one where others have the same on some file system."""
    short = [item.name.lower() for item in found]
    shared = {name for name, count in Counter(short).items() if count > 1}
    names = [item.full_name if name in shared else item.name for item, name in zip(found, short, strict=True)]
    files: dict[str, Path] = {}
    for item, name in zip(found, names, strict=True):
        if (first := files.setdefault(name.lower(), item.file)) is not item.file:
            twice = f"{first.relative_to(path)} and {item.file.relative_to(path)}"
            raise UnknownFormat(path, f"holds {twice}", "keep one of them, or rename it")
    return names
