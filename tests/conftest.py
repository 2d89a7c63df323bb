"""What tests share: the real scans, where they are, and random tests that are the same each time."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("orbitscan", deadline=None, derandomize=True)
settings.load_profile("orbitscan")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real scans: $ORBITSCAN_DATA, else ../shared/data beside the repository."""
    folder = Path(os.environ.get("ORBITSCAN_DATA") or Path(__file__).parents[1] / ".." / "shared" / "data").resolve()
    if not folder.is_dir():
        pytest.skip(f"no real scans in {folder}; set ORBITSCAN_DATA")
    return folder
