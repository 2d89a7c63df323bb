"""What tests share: the real scans, where they are, and random tests that are the same each time."""

import os
from pathlib import Path
from types import ModuleType

import pytest
from filelock import FileLock
from hypothesis import settings

from tests.viewer import probe

os.environ.setdefault("OMP_NUM_THREADS", "1")  # tests run side by side: torch with more threads than cores crawls
os.environ.setdefault("LP_NUM_THREADS", "1")  # and so does the software renderer

settings.register_profile("orbitscan", deadline=None, derandomize=True)
settings.load_profile("orbitscan")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real scans: $ORBITSCAN_DATA, else ../shared/data beside the repository."""
    folder = Path(os.environ.get("ORBITSCAN_DATA") or Path(__file__).parents[1] / ".." / "shared" / "data").resolve()
    if not folder.is_dir():
        pytest.skip(f"no real scans in {folder}; set ORBITSCAN_DATA")
    return folder


@pytest.fixture(scope="session")
def renderer(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Skips where the viewer draws nothing: one of a run's processes tries it once, for all."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    found = folder / "renderer.txt"
    with FileLock(f"{found}.lock"):
        if not found.exists():
            found.write_text(probe() or "", encoding="utf-8")
    if reason := found.read_text(encoding="utf-8"):
        pytest.skip(reason)


@pytest.fixture(scope="session")
def open3d() -> ModuleType:
    """Open3D, which simulates views; it needs system libraries that a bare machine may lack."""
    return pytest.importorskip("open3d", reason="Open3D does not load here", exc_type=(ImportError, OSError))
