"""One module per kind of capture; each turns files into lazy Sessions. `open_capture` recognises which."""

from pathlib import Path

from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import UnknownFormat, Wording, setting
from orbitscan.recorder.formats import pose_file
from orbitscan.recorder.session import Session
from orbitscan.recorder.sources import category_folders, clouds, stanford, washington

FORMATS = {"clouds": clouds, "stanford": stanford, "washington": washington}
_CHOICES = (
    "name a folder of PLY, PCD, XYZ or NPY clouds (clouds), a Stanford .conf (stanford) or a tree of "
    "CATEGORY_INSTANCE_VIDEO_FRAME.pcd (washington)"
)
_OTHERS = {  # what people try
    ".mcap": ("is a recording already", "give it to 'orbitscan process'"),
    ".stl": ("is a mesh", "scan it with 'orbitscan simulate'"),
    ".obj": ("is a mesh", "scan it with 'orbitscan simulate'"),
}


def open_capture(path: Path, options: CaptureOptions | None = None) -> list[Session]:
    """The sessions of a capture, its format recognised from its content where the options name none.

    Views are read when they are loaded. Raises UnknownFormat where nothing fits, or more than one format does, and
    what the format's own module raises.
    """
    path, options = Path(path), options or CaptureOptions()
    if not path.exists():
        raise UnknownFormat(path, "no such file or folder", _CHOICES)
    if options.format is not None and options.format not in FORMATS:
        raise UnknownFormat(setting("format", options.format), "not a known format", f"give {', '.join(FORMATS)}")
    if options.categories_from_folders and options.format in (None, "clouds"):
        return category_folders.sessions(path, options)
    return FORMATS[options.format or recognise(path, options)].sessions(path, options)


def recognise(path: Path, options: CaptureOptions) -> str:
    """The one format a capture is in; raises UnknownFormat."""
    fitting = [name for name, source in FORMATS.items() if source.recognises(path)]
    # Scans of the two data sets are cloud files too: only poses of their own make plain clouds of them.
    has_poses = options.poses is not None or (path.is_dir() and bool(pose_file.find(path)))
    if len(fitting) == 2 and "clouds" in fitting and not has_poses:
        fitting.remove("clouds")
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise UnknownFormat(path, f"could be {' or '.join(fitting)}", Wording("say which with {format}"))
    if path.suffix.lower() in _OTHERS and path.is_file():
        raise UnknownFormat(path, *_OTHERS[path.suffix.lower()])
    if path.is_dir() and (folders := list(dict.fromkeys(item.folders[0] for item in category_folders.find_tree(path)))):
        some = ", ".join(folders[:3]) + (", ..." if len(folders) > 3 else "")
        remedy = Wording(
            "pass {categories_from_folders} where these are categories, else convert them one by one",
            categories_from_folders=True,
        )
        raise UnknownFormat(path, f"holds no cloud itself, but its folders do ({some})", remedy)
    raise UnknownFormat(path, "holds no captured scan that is recognised", _CHOICES)
