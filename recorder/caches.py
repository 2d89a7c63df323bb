"""Where caches are kept on a machine that has no place for them: a read-only installation, another user, no HOME."""

import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path


def temporary_cache(name: str) -> Path:
    """A folder of this user alone: whoever can write into it has his code run by us.

    The same from run to run, but where somebody else has taken its name: then a new one. Raises OSError where there is
    no place for temporary files either.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0  # Windows has a temporary folder for each user
    folder = Path(tempfile.gettempdir()) / f"orbitscan-{name}-{user}"
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    about = folder.lstat()
    ours = not hasattr(os, "getuid") or (about.st_uid == user and not about.st_mode & 0o022)
    return folder if stat.S_ISDIR(about.st_mode) and ours else Path(tempfile.mkdtemp(prefix=f"orbitscan-{name}-"))


def find_place_for_matplotlib() -> None:
    """Name Matplotlib a temporary cache where it cannot write its own: it would make one for each process, and warn."""
    try:
        home = Path.home()
        places = [
            os.environ.get("XDG_CONFIG_HOME") or home / ".config",
            os.environ.get("XDG_CACHE_HOME") or home / ".cache",
        ]
        if "MPLCONFIGDIR" not in os.environ and not all(_can_be_written(Path(place)) for place in places):
            os.environ["MPLCONFIGDIR"] = str(temporary_cache("matplotlib"))
    except (OSError, RuntimeError):  # neither a home nor a temporary folder
        return


def _can_be_written(folder: Path) -> bool:
    """Whether a folder can be written, or made."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
