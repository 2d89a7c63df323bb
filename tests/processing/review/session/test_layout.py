"""The layout: where frusta stand, and that the viewer draws all of it."""

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from matplotlib.image import imread

from orbitscan.processing.review import entities
from orbitscan.processing.review.session.scene import Scene
from orbitscan.processing.review.session.shading import shade_views
from tests import viewer
from tests.processing.review.made_results import make_results, write_review


def test_frustum_of_a_range_scanner_stands_nearer():
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3))
    far = Scene.around(points, None, (0.0, 0.0, -50.0))
    assert np.linalg.norm(far.sensor - far.center) == pytest.approx(3 * far.diameter)
    assert np.array_equal(Scene.around(points, None, (0.0, 0.0, 0.0)).sensor, np.zeros(3))
    assert Scene.around(points, None, None).sensor is None


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize("with_truth", [True, False])
def test_viewer_draws_everything(with_truth, tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=with_truth)
    with viewer.open_viewer(tmp_path / "review.rrd") as client:
        names = {view.name for view in client.get_state().views}
        assert viewer.find_reports(client) == []
    assert {"refined, by view", "icp", "Graph", "Slip: its turn off a multiple of the step [deg]"} <= names
    assert {"Summary", "View", "Log"} <= names
    assert {"Turn: error and 95 % bound [deg]", "Centre: error and 95 % bound [mm]"} <= names
    assert ("Translation error [mm]" in names) == with_truth
    assert ("by error" in names, "by confidence" in names) == (with_truth, not with_truth)


@pytest.mark.usefixtures("renderer")
def test_colours_by_error_and_by_view_take_the_place_of_those_captured(tmp_path):
    write_review(tmp_path / "review.rrd", colored=True)
    blue = shade_views(make_results()[1].reconstruction["refined"]).colors[2]  # a hundredth of a millimetre off
    shares = []
    with viewer.open_viewer(tmp_path / "review.rrd") as client:
        for tab, name in enumerate(("refined, as captured", "by view", "by error")):
            viewer.show_tab(client, tab)
            (shown,) = [view for view in client.get_state().views if view.name == name]
            client.save_screenshot(str(tmp_path / "shot.png"), view_id=shown.view_id)
            pixels = 255 * imread(tmp_path / "shot.png")[:, :, :3]
            shares.append([_share(pixels, color) for color in (entities.view_color(2, 5), blue)])
    assert np.array_equal(np.array(shares) > 0.001, [[False, False], [True, False], [False, True]]), shares


def _share(pixels: np.ndarray, color: entities.Color) -> float:
    """The share of pixels of a hue: that of points, which the viewer shades."""
    bright = pixels.max(axis=2, keepdims=True)
    off = np.abs(pixels / np.maximum(bright, 1) - np.array(color) / max(color)).max(axis=2)
    return float(((off < 0.06) & (bright[..., 0] > 0.75 * max(color))).mean())


@pytest.mark.usefixtures("renderer")
def test_viewer_helper_finds_what_cannot_be_drawn(tmp_path):
    tabs = rrb.Tabs(rrb.TextDocumentView(origin="/words"), rrb.Spatial3DView(origin="/"))
    with rr.RecordingStream("broken") as stream:
        stream.save(tmp_path / "broken.rrd", default_blueprint=rrb.Blueprint(tabs))
        stream.log("words", rr.TextDocument("in front of the broken view"))
        stream.log("here", rr.Points3D([[0, 0, 0]]))
        stream.log("elsewhere", rr.CoordinateFrame("nowhere"), rr.Points3D([[0, 0, 0]]))
    with viewer.open_viewer(tmp_path / "broken.rrd") as client:
        assert any("No transform path" in report for report in viewer.find_reports(client))
