"""Paint and light: paint stays on the object, light where its lamp stands, and neither moves a point."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.simulation.appearance import PAINTS
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.simulation.objects.solids import box
from tests.recorder.simulation.test_camera import write_mesh

DARK = 90  # of 255


def looks(what="bowl", **camera):
    """Points in the object's frame and colours of a few views."""
    session = simulate(what, views=6, noise_mm=0, **camera)
    truth = session.truth()
    return [(poses.transform(truth[view.index], view.points), view.colors.astype(float)) for view in session.views()]


def test_paint_and_light_move_no_point():
    plain = looks()
    for camera in ({"paint": "print"}, {"lamp": "room", "gloss": 0.5}, {"color_noise": 9}, {"color_shift": 2}):
        for (points, colors), (same, other) in zip(plain, looks(**camera), strict=True):
            assert (points == same).all()
            assert colors.shape == other.shape
            assert (colors != other).any()


@pytest.mark.parametrize("paint", ["label", "stripe", "print"])
def test_paint_stays_on_the_object(paint):
    """Where two views see the same place it has the same colour, up to the light."""
    first, second = looks(paint=paint, lamp="object")[:2]
    hue = [colors / np.maximum(colors.sum(axis=1, keepdims=True), 1) for _, colors in (first, second)]
    apart, nearest = cKDTree(first[0]).query(second[0])
    near = apart < 0.0005
    assert near.sum() > 200
    off = np.abs(hue[0][nearest[near]] - hue[1][near]).sum(axis=1)
    assert np.mean(off < 0.03) > 0.9


def test_what_is_painted_is_seen_from_where_it_should_be():
    red = [np.mean(colors[:, 0] > 1.5 * colors[:, 1]) for _, colors in looks("water_bottle", paint="stripe")]
    assert red[0] > 0.02  # the front
    assert red[3] < 0.1 * red[0]  # the back, over whose top a little of the front is seen
    inked = [np.ptp(colors, axis=0).max() for _, colors in looks("water_bottle", paint="label")]
    assert inked[0] > 150 > inked[3]
    assert all(len(np.unique(colors // 32, axis=0)) > 8 for _, colors in looks("water_bottle", paint="print"))
    assert all(np.ptp(colors - colors.mean(axis=1, keepdims=True)) < 12 for _, colors in looks(paint="plain"))


def test_only_a_lamp_beside_the_object_lights_the_same_places_in_all_views(tmp_path):
    """A box's lid is as bright from everywhere, but for a lamp that stands still while the box turns."""
    file = write_mesh(tmp_path / "box.stl", box(0.1, 0.06, 0.05))
    bright = {}
    for lamp in ("object", "camera", "room"):
        views = looks(file, paint="plain", lamp=lamp)
        side = [colors[np.abs(points[:, 0]) > 0.0499].mean() for points, colors in (views[0], views[3])]
        bright[lamp] = side
    assert bright["object"][0] > bright["object"][1] + 20  # one of the two ends faces the lamp
    for lamp in ("camera", "room"):
        assert bright[lamp][0] == pytest.approx(bright[lamp][1], abs=1)


def test_highlights_are_where_the_lamp_is_mirrored():
    dull, glossy = (looks("bowl", paint="plain", lamp="camera", gloss=gloss) for gloss in (0.0, 0.6))
    for (_, without), (_, with_gloss) in zip(dull, glossy, strict=True):
        more = (with_gloss - without).max(axis=1)
        assert more.min() >= 0
        assert 0 < np.mean(more > 40) < 0.5


def test_noise_is_what_was_asked_for_and_shifted_colours_show_the_background():
    clean, noisy = (looks("bowl", paint="plain", color_noise=deviation)[0][1] for deviation in (0, 6))
    assert np.std(noisy - clean) == pytest.approx(6, rel=0.05)
    shifted = looks("bowl", paint="plain", color_shift=3)[0][1]
    assert np.mean(shifted.max(axis=1) < DARK) > 0.005
    assert np.mean(clean.max(axis=1) < DARK) == 0


def test_a_mesh_without_colours_has_some_when_painted(tmp_path):
    file = write_mesh(tmp_path / "box.stl", box(0.1, 0.06, 0.05))
    for paint in PAINTS:
        colors = simulate(file, views=2, paint=paint).load(0).colors
        assert (colors is None) == (paint == "own")


@pytest.mark.parametrize(
    ("name", "value"),
    [("paint", "gold"), ("lamp", "sun"), ("gloss", 1.5), ("color_noise", -1.0), ("color_shift", np.nan)],
)
def test_what_cannot_be_is_told(name, value):
    with pytest.raises(InvalidOption, match=str(value)):
        simulate("bowl", **{name: value})


def test_the_recording_says_how_it_looks():
    assert simulate("bowl").info.sensor.count("lamp") == 0
    told = simulate("bowl", paint="print", lamp="room", gloss=0.3).info.sensor
    assert "print" in told
    assert "lamp in the room" in told
