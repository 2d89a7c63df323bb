"""What the review draws beside the clouds: the graph, the turntable, free motions, the mesh, matches."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.results.status import METHODS
from orbitscan.processing.review import entities
from orbitscan.processing.review.session.recording import SessionReview
from orbitscan.processing.review.session.scene import Scene
from orbitscan.recorder.mesh import Mesh
from tests.processing.review.made_results import AXIS, CENTER, make_info, make_results
from tests.processing.review.recordings import packed, read_rows


def test_graph_is_drawn_between_the_cameras(reviewed):
    path, (_, session) = reviewed
    strips = read_rows(path, "/graph/**", "LineStrips3D:strips")
    colors = read_rows(path, "/graph/**", "LineStrips3D:colors")
    T_0 = {view.view: view.T_0_i for view in session.reconstruction["refined"].views}
    assert {entity: list(cells) for entity, cells in strips.items()} == {f"/graph/view_00{i}": [i] for i in (1, 2, 3)}
    ends = [[T_0[source][:3, 3], T_0[target][:3, 3]] for source, target in ((2, 1), (2, 0))]
    assert np.allclose(np.array(strips["/graph/view_002"][2]), ends, atol=1e-6)
    assert colors["/graph/view_002"][2] == [packed(entities.GOOD_COLOR), packed(entities.BAD_COLOR)]
    assert colors["/graph/view_003"][3] == [packed(entities.FREE_COLOR)]


def test_turntable_is_drawn_and_plotted(reviewed):
    path, (_, session) = reviewed
    (origin,) = read_rows(path, "/turntable/axis", "Arrows3D:origins")["/turntable/axis"][-1]
    (vector,) = read_rows(path, "/turntable/axis", "Arrows3D:vectors")["/turntable/axis"][-1]
    assert np.allclose(np.cross(vector, AXIS), 0, atol=1e-6)
    assert np.dot(vector, AXIS) > 0
    assert np.linalg.norm(np.cross(CENTER - origin, AXIS)) < 1e-6
    curves = read_rows(path, "/turntable/**", "Scalars:scalars")
    for quantity, field, factor in (
        ("slip_deg", "slip_deg", 1),
        ("wobble_deg", "wobble_deg", 1),
        ("shift_mm", "shift_m", 1e3),
    ):
        expected = {d.view: [pytest.approx(factor * getattr(d, field))] for d in session.turntable.deviations}
        assert curves[f"/turntable/{quantity}/refined"] == expected


def test_free_motion_is_dashed_along_its_axis(reviewed):
    strips = read_rows(reviewed[0], "/free/**", "LineStrips3D:strips")["/free/00"][-1]
    points = np.array([point for strip in strips for point in strip])
    off = np.linalg.norm(np.cross(points - CENTER, AXIS), axis=1)
    assert (off < 1e-6).sum() >= 40
    ring = off[off >= 1e-6]
    assert len(ring) >= 40
    assert np.allclose(ring, ring[0], rtol=1e-4)


def test_mesh_is_drawn(tmp_path):
    views, session = make_results()
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]), np.full((3, 3), 90, np.uint8))
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views:
            review.add_view(result)
        review.add_session(replace(session, model=replace(session.model, mesh=mesh)))
    normals = read_rows(tmp_path / "review.rrd", "/model/mesh", "Mesh3D:vertex_normals")["/model/mesh"][-1]
    assert np.allclose(np.array(normals), 1 / np.sqrt(3))


def test_matches_are_drawn_between_two_clouds(reviewed):
    path, _ = reviewed
    strips = read_rows(path, "/pairs/**", "LineStrips3D:strips")
    assert len(strips["/pairs/000_001/inliers"][1]) == 40
    assert len(strips["/pairs/000_001/matches"][1]) == 50


def test_a_gap_is_an_arc_of_its_azimuths_about_the_foot(reviewed):
    strips = read_rows(reviewed[0], "/coverage/**", "LineStrips3D:strips")
    assert list(strips) == ["/coverage/gap_00"]
    arc = np.array(strips["/coverage/gap_00"][-1][0])
    away = arc - CENTER
    away -= (away @ AXIS)[:, None] * AXIS
    assert np.allclose(np.linalg.norm(away, axis=1), np.linalg.norm(away[0]), rtol=1e-5)
    first = -CENTER - (-CENTER @ AXIS) * AXIS  # camera 0 stands at 0 degrees
    azimuth = np.degrees(np.arctan2(away @ np.cross(AXIS, first), away @ first)) % 360
    assert azimuth[0] == pytest.approx(40, abs=0.1)  # the third view's, the last that is ok
    assert (azimuth[-1] + 180) % 360 == pytest.approx(180, abs=0.1)
    assert np.all(np.diff(azimuth[:-1]) > 0)
    (label,) = read_rows(reviewed[0], "/coverage/gap_00/label", "Points3D:labels")["/coverage/gap_00/label"][-1]
    assert label == "no view between 40° and 360°"


def test_the_scale_of_colours_has_words_beside_its_dots(reviewed):
    dots = read_rows(reviewed[0], "/scale", "Points3D:positions")["/scale"][-1]
    words = read_rows(reviewed[0], "/scale/label", "Points3D:labels")["/scale/label"][-1]
    assert words[:5] == ["0.01 mm", "0.1 mm", "1 mm", "10 mm", "100 mm"]
    assert words[-1] == "error of the object's centre"
    assert len(dots) == len(words) - 1
    height = np.array(dots) @ Scene.around(reviewed[1][0][0].points, 30.0, None).up
    assert np.all(np.diff(height) > 0)  # much above little
