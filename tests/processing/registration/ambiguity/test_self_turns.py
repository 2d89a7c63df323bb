"""A view registered with itself: a prism's sides lie on each other; what has no symmetry only on itself."""

import numpy as np
import pytest

from orbitscan.processing.registration.ambiguity.self_turns import find_self_turns
from orbitscan.recorder import poses
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.geometry import scan
from tests.processing.scene import SETTINGS, Scene


@pytest.mark.parametrize(("name", "turned_deg"), [("prism03", 120), ("prism05", 72), ("box", 180)])
def test_sides_of_a_solid_are_exchanged(tmp_path, name, turned_deg):
    session = simulate(SOLIDS[name].write(tmp_path), views=6)
    scene = Scene(session)
    up = session.truth()[0][:3, :3].T @ [0, 0, 1.0]
    turns = find_self_turns(scene.views[0], SETTINGS.pair)
    about = [abs(np.degrees(poses.twist(T[:3, :3], up))) for T in turns if (T[:3, :3] @ up) @ up > 0.99]
    assert min(abs(angle - turned_deg) for angle in about) < 5


def test_none_is_the_identity_and_all_are_told_by_the_view(tmp_path):
    scene = Scene(simulate(SOLIDS["cube"].write(tmp_path), views=6))
    view = scene.views[0]
    pair = scene.pair(view, view)
    assert view.self_turns
    for T in view.self_turns:
        assert pair.distance(T, np.eye(4)) > 1
        assert pair.verify(T, coarse=True).overlap >= SETTINGS.pair.judgement.min_overlap / 2


def test_a_surface_without_flat_sides_has_none():
    assert Scene(scan(n_views=1)).views[0].self_turns == ()
