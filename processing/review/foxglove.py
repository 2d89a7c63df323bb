"""How registered.mcap opens in Foxglove: a layout for its `Import from file`, beside the recording.

While the recording plays each view stays, drawn by the pose of its own time, until the object is whole. What these
settings do was read in Foxglove's published layouts, its Python types of them (foxglove-sdk) and the sources of its
open 3D panel, which Lichtblick keeps: settings that only one of the two knows are there for both.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.results.registered import FILE_NAME, Placement
from orbitscan.processing.review import entities
from orbitscan.recorder.mcap_file import POINTS_TOPIC, POSES_TOPIC
from orbitscan.recorder.session import SessionInfo

LAYOUT_NAME = "registered.foxglove.json"
FIELD_OF_VIEW_DEG = 45.0  # vertical
MARGIN = 1.25  # the object fills the panel's height but for so much
AXES = 0.12  # length of a frame's axes, in diameters of the object
UNIT_AXES = 0.2  # [m] their length at `axisScale` 1


def write_foxglove_layout(path: Path, placement: Placement, info: SessionInfo) -> None:
    """Write the layout for the registered recording of a session."""
    path.write_text(json.dumps(lay_out_foxglove(placement, info), indent=1) + "\n", encoding="utf-8")


def lay_out_foxglove(placement: Placement, info: SessionInfo) -> dict[str, Any]:
    """The layout as Foxglove exports it: the object at the left, what it is and the poses at the right."""
    return {
        "configById": {
            "3D!object": _view_3d(placement),
            "Markdown!about": {
                "foxglovePanelTitle": "About",
                "renderMode": "static",
                "markdown": _describe(placement, info),
            },
            "RawMessages!poses": {
                "foxglovePanelTitle": "Estimated pose",
                "topicPath": POSES_TOPIC,
                "expansion": "all",
                "diffEnabled": False,
                "diffMethod": "custom",
                "diffTopicPath": "",
                "showFullMessageForDiff": False,
            },
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row",
            "first": "3D!object",
            "second": {
                "direction": "column",
                "first": "Markdown!about",
                "second": "RawMessages!poses",
                "splitPercentage": 45,
            },
            "splitPercentage": 72,
        },
    }


def _view_3d(placement: Placement) -> dict[str, Any]:
    low, high = np.percentile(placement.points, [1, 99], axis=0)
    diameter = max(float(np.linalg.norm(high - low)), 1e-6)
    distance = MARGIN * diameter / 2 / np.sin(np.radians(FIELD_OF_VIEW_DEG / 2))
    farthest = max(float(np.linalg.norm(T[:3, 3])) for T in placement.T_object_i.values())
    stamps = placement.stamps_ns.values()
    points = {
        "visible": True,
        "pointSize": 2,
        "pointShape": "circle",
        "decayTime": float(np.ceil((max(stamps) - min(stamps)) / 1e9) + 1),  # [s] all views, to the last
        **_colors(placement),
    }
    return {
        "foxglovePanelTitle": "Object",
        "followTf": "object",
        "fixedFrame": "object",  # in which accumulated clouds are kept
        "followMode": "follow-pose",
        "cameraState": {
            "perspective": True,
            "distance": _rounded(distance),
            "phi": 60.0,  # from straight above
            "thetaOffset": -25.0,  # 0 looks along y, as the first view did; to its right
            "fovy": FIELD_OF_VIEW_DEG,
            "near": _rounded(distance / 100),
            "far": _rounded(2 * (distance + max(diameter, farthest))),
            "target": [0.0, 0.0, 0.0],
            "targetOffset": [0.0, 0.0, 0.0],  # the frame's origin is amid the object
            "targetOrientation": [0.0, 0.0, 0.0, 1.0],
        },
        "scene": {
            "backgroundColor": _hex(entities.BACKGROUND),
            "transforms": {
                "visible": True,
                "showLabel": False,
                "axisScale": _rounded(AXES * diameter / UNIT_AXES),
                "axisSize": _rounded(AXES * diameter),
                "lineWidth": 1,
                "lineColor": _hex(entities.METHOD_COLORS[placement.method]),
                "enablePreloading": True,
            },
        },
        "transforms": {},
        "topics": {POINTS_TOPIC: points},
        "layers": {},
    }


def _colors(placement: Placement) -> dict[str, Any]:
    """How points are coloured: as captured, else by height: along the first camera's y, which points down."""
    if placement.colored:
        return {"colorMode": "rgba-fields"}
    T_object_0 = next(iter(placement.T_object_i.values()))
    down = (placement.points - T_object_0[:3, 3]) @ T_object_0[:3, 1]
    top, bottom = np.percentile(down, [1, 99])
    return {
        "colorMode": "gradient",
        "colorField": "y",
        "gradient": [_hex(entities.TOP_COLOR), _hex(entities.FOOT_COLOR)],
        "minValue": _rounded(top),
        "maxValue": _rounded(bottom),
    }


def _describe(placement: Placement, info: SessionInfo) -> str:
    count = len(placement.T_object_i)
    views = "1 view" if count == 1 else f"{count} views"
    missing = f" {placement.left_out} more were not placed so, and are left out." if placement.left_out else ""
    return f"""# {info.name}

`{FILE_NAME}`: {views} that `{placement.method}` placed with confidence.{missing}

The poses on `{POSES_TOPIC}` are **estimates**, no ground truth.

**Press play:** each view stays where its pose puts it, until the object is whole. A jump in time clears the views;
go back to the start and play again.

Frame `object`: z up, y away from the first view's sensor, the origin amid the object; metres.
"""


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _hex(color: entities.Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
