"""The layout: where frusta stand, and that the viewer draws all of it."""

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb

from processing.review.scene import Scene
from tests import viewer
from tests.processing.review.made_results import write_review


def test_frustum_of_a_range_scanner_stands_nearer():
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3))
    far = Scene.around(points, None, (0.0, 0.0, -50.0))
    assert np.linalg.norm(far.sensor - far.center) == pytest.approx(3 * far.diameter)
    assert np.array_equal(Scene.around(points, None, (0.0, 0.0, 0.0)).sensor, np.zeros(3))
    assert Scene.around(points, None, None).sensor is None


@pytest.mark.parametrize("with_truth", [True, False])
def test_viewer_draws_everything(with_truth, tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=with_truth)
    try:
        with viewer.open_viewer(tmp_path / "review.rrd", size="960x540") as client:
            names = {view.name for view in client.get_state().views}
            assert viewer.find_reports(client) == []
    except viewer.NoViewer as reason:
        pytest.skip(str(reason))
    assert {"refined, by view", "icp", "Graph", "Slip: its turn off a multiple of the step [deg]"} <= names
    assert {"Summary", "View", "Log"} <= names
    assert ("Translation error [mm]" in names) == with_truth
    assert ("by error" in names, "by confidence" in names) == (with_truth, not with_truth)


def test_viewer_helper_finds_what_cannot_be_drawn(tmp_path):
    tabs = rrb.Tabs(rrb.TextDocumentView(origin="/words"), rrb.Spatial3DView(origin="/"))
    with rr.RecordingStream("broken") as stream:
        stream.save(tmp_path / "broken.rrd", default_blueprint=rrb.Blueprint(tabs))
        stream.log("words", rr.TextDocument("in front of the broken view"))
        stream.log("here", rr.Points3D([[0, 0, 0]]))
        stream.log("elsewhere", rr.CoordinateFrame("nowhere"), rr.Points3D([[0, 0, 0]]))
    try:
        with viewer.open_viewer(tmp_path / "broken.rrd", size="960x540") as client:
            assert any("No transform path" in report for report in viewer.find_reports(client))
    except viewer.NoViewer as reason:
        pytest.skip(str(reason))
