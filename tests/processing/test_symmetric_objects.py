"""What repeats itself, or hardly holds, is never called right: whole sessions in which a wrong pose overlaps more."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.results.status import WRONG_DEG
from orbitscan.processing.settings import Settings
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS


def run(tmp_path, name, views, used, step_deg=None, noise=1.0, **looks):
    """Both our methods on the first views of a solid's turn, with errors."""
    session = simulate(SOLIDS[name].write(tmp_path), views=views, noise_mm=noise, **looks)
    settings = Settings()
    settings = replace(settings, pair=replace(settings.pair, step_deg=step_deg))
    stream = process(session.views(f"0:{used}"), session.info, settings, ("pairwise", "refined"))
    *_, result = with_errors(stream, session.truth())
    return session, result.reconstruction


@pytest.mark.parametrize(("name", "views"), [("prism06", 8), ("prism03", 6), ("gear12", 18), ("flute12", 18)])
def test_no_view_is_ok_and_the_truth_is_among_what_a_pair_names(tmp_path, name, views):
    """At these steps the pose that overlaps most is a wrong one: a prism's 15 degrees back for 45 forth."""
    session, found = run(tmp_path, name, views, 3)
    for method in found.values():
        assert [view.status for view in method.views[1:]] == ["ambiguous"] * 2
        assert all(pair.errors.rotation_error_deg_observable < WRONG_DEG for pair in method.pairs)
    up = session.truth()[0][:3, :3].T @ [0, 0, 1.0]
    named = [s for pair in found["refined"].pairs for s in pair.symmetries if s.order == SOLIDS[name].order]
    assert named
    assert max(abs(symmetry.axis @ up) for symmetry in named) > np.cos(np.radians(2))


def test_a_cartons_sides_are_alike(tmp_path):
    """Three views 60 degrees apart lie on each other best at 30 degrees back."""
    _, found = run(tmp_path, "carton", 6, 3)
    for method in found.values():
        assert "ok" not in [view.status for view in method.views[1:]]


def test_the_users_step_chooses_among_what_the_views_leave_open(tmp_path):
    _, found = run(tmp_path, "prism06", 8, 3, step_deg=45)
    for method in found.values():
        assert [view.status for view in method.views] == ["ok"] * 3
        assert all(pair.start == "step" for pair in method.pairs if pair.source - pair.target == 1)
        assert max(view.errors.rotation_error_deg for view in method.views) < 1


@pytest.mark.parametrize("step_deg", [-45.0, 30.0])
def test_a_step_that_the_views_decide_against_makes_no_view_ok(tmp_path, step_deg):
    _, found = run(tmp_path, "prism06", 8, 2, step_deg=step_deg)
    assert found["pairwise"].views[1].status == "inconsistent"
    assert "step" in found["pairwise"].pairs[0].note
    assert found["refined"].views[1].status != "ok"


def test_what_all_views_show_together_is_named_where_no_two_tell(tmp_path):
    """Neighbouring views of a box share nothing that is alike; all of them show that it looks the same from behind."""
    _, found = run(tmp_path, "box", 8, 8)
    assert 2 in [symmetry.order for symmetry in found["refined"].symmetries]
    for method in found.values():
        assert "ok" not in [view.status for view in method.views[1:]]


def test_what_a_kinects_noise_hides_is_not_called_right():
    """A pepper's lobes are as large as the noise: its views were ok, and 8 to 15 degrees off."""
    session = simulate("bell_pepper", views=12, sensor="kinect")
    stream = process(session.views("0:5"), session.info, methods=("pairwise", "refined"))
    *_, result = with_errors(stream, session.truth())
    for method in result.reconstruction.values():
        assert all(v.errors.rotation_error_deg < WRONG_DEG for v in method.views if v.status == "ok")
        ambiguous = [pair for pair in method.pairs if pair.status == "ambiguous"]
        assert ambiguous


@pytest.mark.parametrize(("name", "views"), [("prism06", 8), ("carton", 6)])
def test_a_print_tells_what_the_shape_leaves_open(tmp_path, name, views):
    """The lamp stands still and shines on the print, which alone tells the sides apart."""
    looks = {"paint": "print", "lamp": "room", "gloss": 0.3, "color_noise": 3.0}
    _, found = run(tmp_path, name, views, 4, **looks)
    for method in found.values():
        assert [view.status for view in method.views] == ["ok"] * 4
        assert max(view.errors.rotation_error_deg for view in method.views) < 1
        assert "color" in [pair.start for pair in method.pairs]


def test_a_label_tells_where_it_is_seen_and_nothing_elsewhere(tmp_path):
    """The label is at the front, where views 0, 1 and 2 see it; what follows shows plain sides that are alike."""
    looks = {"paint": "label", "lamp": "camera", "gloss": 0.3, "color_noise": 3.0}
    _, found = run(tmp_path, "prism06", 12, 6, **looks)
    views = found["refined"].views
    assert [view.status for view in views[:2]] == ["ok"] * 2
    assert views[5].status != "ok"
    assert all(view.errors.rotation_error_deg < 1 for view in views if view.status == "ok")


@pytest.mark.parametrize("paint", ["plain", "own"])
def test_a_plain_bottle_before_a_lamp_is_as_without_colours(paint):
    """Where light is all that colours show, statuses are what they are without."""
    session = simulate("water_bottle", views=12, paint=paint, lamp="camera", gloss=0.5, color_noise=3)
    statuses = []
    for color in (True, False):
        settings = replace(Settings(), pair=replace(Settings().pair, color=color))
        *_, result = process(session.views("0:2"), session.info, settings, ("pairwise", "refined"))
        statuses.append([[view.status for view in method.views] for method in result.reconstruction.values()])
    assert statuses[0] == statuses[1]
