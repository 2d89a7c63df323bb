"""The mesh where there is none to make: Open3D absent, or points too far apart. (`test_model` makes one.)"""

import sys

import numpy as np
import pytest

from orbitscan.processing.reconstruction.mesh import MeshSettings, reconstruct_mesh
from orbitscan.recorder.exceptions import MissingLibrary

POINTS = np.random.default_rng(0).random((20, 3))


def test_without_open3d_the_error_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(MissingLibrary, match=r"open3d.*do without a mesh"):
        reconstruct_mesh(POINTS, POINTS, None, 0.001, MeshSettings(wanted=True))


@pytest.mark.usefixtures("open3d")
def test_points_too_far_apart_make_no_mesh():
    assert reconstruct_mesh(POINTS, POINTS, None, 0.001, MeshSettings(wanted=True)) is None
