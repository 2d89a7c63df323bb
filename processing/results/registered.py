"""registered.mcap: the views that the best method placed, with the estimated poses as /tf, for Foxglove and Rerun.

Its views are those of model.ply, the ok ones: a cloud without a pose would be drawn by the pose before it, and a wrong
pose would pass for a right one. Its frame `object` stands upright about the object, as these viewers expect: z up, y
away from the first view's sensor, the origin amid the model. As T_0_0 is the identity, T_0_i is inv(tf_0) tf_i.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orbitscan.processing.results.records import SessionResult, Turntable
from orbitscan.processing.results.status import Method
from orbitscan.recorder import poses
from orbitscan.recorder.session import ESTIMATED, Session, SessionInfo, View

FILE_NAME = "registered.mcap"
STEEP = 0.1  # sine of the angle to the vertical, below which looking forward tells no direction on the ground


@dataclass(frozen=True, eq=False)
class Placement:
    """Where the best method run puts the views that are ok, in a frame that stands upright about the object."""

    method: Method
    T_object_i: Mapping[int, np.ndarray]  # by recorded index, in the order of use
    stamps_ns: Mapping[int, int]  # of the capture; made up, a second apart, where those are not distinct
    made_up: bool  # whether the stamps are
    left_out: int  # views that were used and are not ok
    points: np.ndarray  # (N, 3) of the model, metres
    colored: bool  # whether every view is


def place(result: SessionResult) -> Placement | None:
    """The placement by the best method run; None where there is no model, as no view has enough points."""
    model = result.model
    if model is None:
        return None
    T_object_0 = stand_upright(model.points, result.turntable, result.info.elevation_deg)
    placed = result.reconstruction[model.method].placed
    T_object_i = {view: T_object_0 @ T_0_i for view, T_0_i in placed.items()}
    stamps_ns = dict(zip(result.views_used, result.stamps_ns, strict=True))
    stamps_ns = {view: stamps_ns[view] for view in T_object_i}
    made_up = len(set(stamps_ns.values())) < len(stamps_ns)
    if made_up:  # viewers know a cloud's pose by its time: of equal stamps the last pose would place all clouds
        stamps_ns = {view: (number + 1) * 10**9 for number, view in enumerate(T_object_i)}
    points = poses.transform(T_object_0, model.points)
    left_out = len(result.views_used) - len(T_object_i)
    return Placement(model.method, T_object_i, stamps_ns, made_up, left_out, points, model.colors is not None)


def stand_upright(points: np.ndarray, turntable: Turntable | None, elevation_deg: float | None) -> np.ndarray:
    """T_object_0 of a frame with z up, y away from the sensor of frame {0} and the origin amid points (N, 3).

    Up is along the turntable's axis, else as the sensor's elevation tells; where nothing does, the sensor is level.
    """
    elevation = np.radians(elevation_deg or 0.0)
    up = np.array([0.0, -np.cos(elevation), -np.sin(elevation)])  # a sensor's y points down
    if turntable is not None:
        up = turntable.axis if turntable.axis @ up >= 0 else -turntable.axis
    right = np.cross([0.0, 0.0, 1.0], up)
    if np.linalg.norm(right) < STEEP:
        right = np.array([1.0, 0.0, 0.0]) - up[0] * up
    right /= np.linalg.norm(right)
    turn = poses.make(np.stack([right, np.cross(up, right), up]), np.zeros(3))
    low, high = np.percentile(poses.transform(turn, points), [1, 99], axis=0)
    return poses.make(turn[:3, :3], -(low + high) / 2)


def registered(session: Session, placement: Placement) -> Session:
    """The placed views of a session with the estimated poses in place of the true ones.

    They keep names and stamps and are numbered anew, as a recording's views are; `source_poses` says that the poses
    are estimates, by which method, and which recorded views these are, as `select_views` reads them. Views are read
    from the session when asked for.
    """
    recorded = tuple(placement.T_object_i)

    def load(number: int) -> View:
        view = recorded[number]
        return replace(session.load(view), index=number, stamp_ns=placement.stamps_ns[view])

    return Session(
        info=_describe(session.info, placement, recorded),
        names=tuple(session.names[view] for view in recorded),
        load=load,
        load_truth=lambda: dict(enumerate(placement.T_object_i.values())),
    )


def _describe(info: SessionInfo, placement: Placement, recorded: Sequence[int]) -> SessionInfo:
    said = f"{ESTIMATED} {placement.method}, recorded views {_select(recorded)}"
    said += ", stamps made up as the recorded ones are not distinct" if placement.made_up else ""
    steps = set(np.diff(recorded).tolist())
    (step,) = steps if len(steps) == 1 else (None,)
    per_turn = info.views_per_turn / step if info.views_per_turn and step else None
    return replace(info, views=len(recorded), source_poses=said, views_per_turn=per_turn)


def _select(views: Sequence[int]) -> str:
    """The text that selects these, as `select_views` reads it."""
    if list(views) == list(range(views[0], views[-1] + 1)):
        return f"{views[0]}:{views[-1] + 1}"
    return ",".join(map(str, views))
