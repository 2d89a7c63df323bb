"""The galleries: which circles and views are shown, that they are the corpus's, and how they are drawn."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import write
from orbitscan.processing.reproduction.views import circles, gallery
from orbitscan.processing.reproduction.views.view_drawing import draw_view, picture_size
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import View
from orbitscan.recorder.simulation import corpus
from tests.processing.reproduction.views.test_voxelization import make_session, make_sphere

PCD = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"


def test_every_instance_of_table_3_1_has_a_circle_whose_views_are_the_corpus_s(tmp_path):
    found = circles.open_instances(Plan(tmp_path))
    assert {name: len(sessions) for name, sessions in found.items()} == corpus.INSTANCES
    assert {session.info.elevation_deg for sessions in found.values() for session in sessions} == {30.0}
    assert not list(tmp_path.iterdir())  # nothing is recorded
    thinned = corpus.open_circle(corpus.Circle("dry_battery", 2, 1), replace(corpus.CAMERA, every=50))
    np.testing.assert_array_equal(found["dry_battery"][1].load(100).points, thinned.load(2).points)


def test_of_a_dataset_the_lowest_circle_of_each_instance_in_their_order(tmp_path, monkeypatch):
    monkeypatch.setattr(corpus, "INSTANCES", {"bowl": 6})
    for name in ("bowl_10_1_1", "bowl_9_2_1", "bowl_9_1_1", "bowl_9_1_2"):
        (tmp_path / f"{name}.pcd").write_text(PCD + "0 1 0\n0.1 1 0\n0 1 0.1\n")
    found = circles.open_instances(Plan(tmp_path / "out", dataset=tmp_path))
    assert [session.info.name for session in found["bowl"]] == ["bowl_9_1", "bowl_10_1"]
    assert found["bowl"][0].info.views == 2


def test_a_place_on_the_circle():
    session = make_session("bowl", make_sphere(20, 0))  # 6 views
    assert [circles.take_view(session, share).index for share in (0, 0.2, 0.5, 1)] == [0, 1, 3, 0]


def test_a_view_that_shows_nothing_is_passed_over():
    full, empty = make_session("bowl", make_sphere(20, 0)), make_session("bowl", np.full((20, 3), np.nan))
    session = replace(full, load=lambda i: (empty if i in (5, 0) else full).load(i))
    assert circles.take_view(session, 0.9).index == 1
    with pytest.raises(InvalidOption, match="bowl: has no view of 16 points"):
        circles.take_view(empty, 0)


def test_the_gallery_shows_the_last_instance_and_says_what_differs_from_table_3_1(tmp_path, monkeypatch):
    bowls = [make_session("bowl", make_sphere(200 + i, i)) for i in range(8)]
    caps = [make_session("cap", make_sphere(100, 9))]
    monkeypatch.setattr(circles, "open_instances", lambda plan: {"bowl": bowls, "cap": caps})
    monkeypatch.setattr(gallery, "OBJECTS", ("bin",))
    report = gallery.show_gallery(Plan(tmp_path))
    rows = {name: [row for row in report.rows if row["figure"] == name] for name in report.figures}
    assert [row["points"] for row in rows["figure-3.4"]] == [200, 201, 202, 203, 204, 207, 100]
    assert {row["what"] for row in rows["figure-3.7"]} == {"cap"}
    assert [row["view"] for row in rows["figure-5.7"]] == [0, 3, 6, 9, 12, 15]
    assert rows["figure-5.6"][0]["what"] == "bin"
    assert rows["figure-3.4"][0]["radius_mm"] == pytest.approx(50, rel=0.1)
    assert "9 instances of 2 categories" in report.said[0]
    assert "bowl, cap" in report.said[0]
    assert "207 (bowl)" in report.said[1]
    assert sorted(path.name for path in write(report, Plan(tmp_path), "reproduce")) == sorted(
        ["gallery.csv", "gallery.json"]
        + [f"figure-{n}.{ending}" for n in ("3.4", "3.7", "5.6", "5.7") for ending in ("png", "svg")]
    )


def make_view(points, colors=None):
    return View(0, "view_000", 1, np.array(points, np.float32), colors)


def test_a_view_is_drawn_as_its_camera_saw_it():
    colors = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255), (9, 9, 9)], np.uint8)
    view = make_view([(-1, 0, 2), (1, 0, 2), (0, 1, 1), (np.nan, 0, 1)], colors)
    figure, ((axes,),) = charts.new_figure()
    draw_view(axes, view)
    figure.canvas.draw()
    (dots,) = axes.collections
    np.testing.assert_allclose(dots.get_offsets(), [(-0.5, 0), (0.5, 0), (0, -1)])  # right, up; farther is smaller
    np.testing.assert_allclose(dots.get_facecolors()[:, :3], np.eye(3))
    assert axes.get_xlim()[0] < -0.5


def test_views_drawn_alike_have_one_scale():
    near, far = make_view([(-1, 0, 1), (1, 0, 1), (0, 1, 1)]), make_view([(-1, 0, 2), (1, 0, 2), (0, 1, 2)])
    assert picture_size(near) == pytest.approx(2 * picture_size(far))
    figure, ((one, two),) = charts.new_figure(1, 2)
    for axes, view in ((one, near), (two, far)):
        draw_view(axes, view, half=picture_size(near))
    figure.canvas.draw()
    assert np.ptp(one.get_xlim()) == pytest.approx(np.ptp(two.get_xlim()))


def test_a_single_point_without_colour_is_drawn():
    figure, ((axes,),) = charts.new_figure()
    draw_view(axes, make_view([(0, 0, 1)]))
    figure.canvas.draw()
    assert len(axes.collections[0].get_offsets()) == 1
