"""The layout frames the object by Foxglove's own camera, keeps every view, and says what the poses are."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.results.registered import place
from orbitscan.processing.review.foxglove import lay_out_foxglove, write_foxglove_layout
from orbitscan.recorder import poses
from tests.processing.review.made_results import FAILED, make_info, make_results


@pytest.fixture(scope="module")
def result():
    return make_results()[1]


def view_3d(placement):
    return lay_out_foxglove(placement, make_info(5))["configById"]["3D!object"]


def look(state, points):
    """Points (N, 3) in the frame of the camera that Foxglove makes of a state: x right, y up, z towards the viewer.

    Its place is at (distance, phi, theta) of three.js's spherical coordinates, whose pole is turned to z.
    """
    phi, theta = np.radians(state["phi"]), -np.radians(state["thetaOffset"])
    direction = np.array([np.sin(phi) * np.sin(theta), -np.sin(phi) * np.cos(theta), np.cos(phi)])
    turn = Rotation.from_euler("ZX", [theta, phi]).as_matrix()
    eye = np.array(state["targetOffset"]) + state["distance"] * direction
    return (points - eye) @ turn


@pytest.mark.parametrize("scale", [0.05, 1.0, 30.0])
def test_the_object_fills_the_panel_at_any_size(result, scale):
    placement = place(result)
    state = view_3d(replace(placement, points=scale * placement.points))["cameraState"]
    seen = look(state, scale * placement.points)
    depth = -seen[:, 2]
    assert state["near"] < depth.min()
    assert depth.max() < state["far"]
    height = np.abs(seen[:, 1] / depth).max() / np.tan(np.radians(state["fovy"] / 2))
    assert 0.4 < height < 1
    np.testing.assert_allclose(look(state, np.zeros((1, 3)))[0, :2], 0, atol=1e-9)  # the object's middle
    assert np.abs(look(state, np.zeros((1, 3)))[0, 2] + state["distance"]) < 1e-9


def test_it_opens_upright_from_the_side_of_the_first_view(result):
    placement = place(result)
    state = view_3d(placement)["cameraState"]
    base, top = look(state, np.array([[0, 0, 0], [0, 0, 0.1]]))
    assert top[1] - base[1] > 0.07
    assert abs(top[0] - base[0]) < 1e-9
    sensor = look(state, placement.T_object_i[0][None, :3, 3])[0]
    middle = look(state, np.zeros((1, 3)))[0]
    assert (sensor - middle)[2] > 0.5 * np.linalg.norm(sensor - middle)


def test_every_view_stays_to_the_end(result):
    slow = replace(result, stamps_ns=tuple(i * 100 * 10**9 for i in range(5)))
    points = view_3d(place(slow))["topics"]["/camera/points"]
    assert points["decayTime"] > 200  # views 0 to 2 are ok
    assert points["visible"]
    assert view_3d(place(slow))["followTf"] == "object"


def test_colours_are_the_captured_ones_else_from_the_foot_to_the_top(result):
    assert view_3d(replace(place(result), colored=True))["topics"]["/camera/points"]["colorMode"] == "rgba-fields"
    placement = place(result)
    plain = view_3d(placement)["topics"]["/camera/points"]
    assert (plain["colorMode"], plain["colorField"]) == ("gradient", "y")
    for T in placement.T_object_i.values():  # the range fits the fields of every view, in its own frame
        y = poses.transform(poses.invert(T), placement.points)[:, 1]
        middle = (plain["minValue"] + plain["maxValue"]) / 2
        assert abs(np.median(y) - middle) < 0.35 * (plain["maxValue"] - plain["minValue"])
    red, green, _ = (int(plain["gradient"][0][i : i + 2], 16) for i in (1, 3, 5))
    assert min(red, green) > 200  # small y is up: the light end


def test_it_says_that_the_poses_are_estimates_and_what_is_left_out(result):
    text = lay_out_foxglove(place(result), make_info(5))["configById"]["Markdown!about"]["markdown"]
    assert "`refined`" in text
    assert "**estimates**" in text
    assert f"{FAILED} views" in text  # 0 to 2
    assert "2 more" in text
    whole = replace(place(result), left_out=0)
    assert "more" not in lay_out_foxglove(whole, make_info(5))["configById"]["Markdown!about"]["markdown"]


def test_the_file_is_json_whose_panels_all_have_a_place(result, tmp_path):
    write_foxglove_layout(tmp_path / "layout.json", place(result), make_info(5))
    layout = json.loads((tmp_path / "layout.json").read_text())
    assert layout == lay_out_foxglove(place(result), make_info(5))

    def panels(node):
        if isinstance(node, str):
            return [node]
        assert node["direction"] in ("row", "column")
        return panels(node["first"]) + panels(node["second"])

    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
