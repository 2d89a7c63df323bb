"""A recording of six views."""

import pytest

from orbitscan.recorder import mcap_file
from tests.recorder.mcap_file.session import make_session


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "mug.mcap"
    mcap_file.write(make_session(), path)
    return path
