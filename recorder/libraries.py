"""Libraries that a bare machine may be unable to load."""

from types import ModuleType

from orbitscan.recorder.exceptions import MissingLibrary


def load_open3d(instead: str) -> ModuleType:
    """Open3D, imported late: it takes a second, and system libraries that a bare machine may lack.

    Raises MissingLibrary, which says what to do `instead` of installing them.
    """
    try:
        import open3d
    except (ImportError, OSError) as error:
        problem = f"cannot be loaded ({str(error).splitlines()[0]})"
        remedy = f"install what is missing (Debian: libusb-1.0-0 libgl1 libgomp1 libegl1 libx11-6), or {instead}"
        raise MissingLibrary("open3d", problem, remedy) from None
    return open3d
