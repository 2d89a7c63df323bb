"""What a recording holds: its views, poses, sizes, resolution and noise."""

from dataclasses import dataclass

import numpy as np

from orbitscan.recorder import cloud
from orbitscan.recorder.exceptions import InvalidPose
from orbitscan.recorder.session import DEFAULT_VIEWS, Session, SessionInfo, name_views, select_views

MEASURED = "9"  # views that are measured; the points of all are counted


@dataclass(frozen=True)
class Facts:
    """The facts of a session; lengths in metres, medians of the measured views, NaN where none has points."""

    info: SessionInfo
    names: tuple[str, ...]  # of its views
    poses: int | None  # views whose true pose is known; None where the poses cannot be read
    unreadable_poses: str  # why they cannot be
    points: tuple[int, int, int]  # finite ones of a view: least, median, most
    extent: tuple[float, float, float]  # width, height, depth of a view
    distance: float
    resolution: float
    noise: float
    used: tuple[int, ...]  # the views that are processed where nothing is said of them
    damage: str | None  # what is lost


def gather_facts(session: Session) -> Facts:
    """The facts of a session; every view is read."""
    measured = [cloud.measure(cloud.finite(view.points)[0]) for view in session.views(MEASURED)]
    measured = [fact for fact in measured if fact.points > 1]
    points, unreadable = [], []
    for view in session.views():
        points.append(len(cloud.finite(view.points)[0]))
        if view.damage:
            unreadable.append(view.index)
    lost = [f"{name_views(unreadable)} unreadable"] if unreadable else []
    try:
        known, problem = len(session.truth()), ""
    except InvalidPose as error:
        known, problem = None, error.problem
    sizes = [(*fact.extent, fact.distance, fact.resolution, fact.noise) for fact in measured]
    medians = np.median(sizes, axis=0) if sizes else np.full(6, np.nan)
    width, height, depth, distance, resolution, noise = medians.tolist()
    return Facts(
        info=session.info,
        names=session.names,
        poses=known,
        unreadable_poses=problem,
        points=(min(points), int(np.median(points)), max(points)),
        extent=(width, height, depth),
        distance=distance,
        resolution=resolution,
        noise=noise,
        used=select_views(str(DEFAULT_VIEWS), session.names),
        damage="; ".join([session.damage, *lost] if session.damage else lost) or None,
    )
