"""Figures 3.4, 3.7, 5.6 and 5.7: the instances and the objects, and their views."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from matplotlib.colors import LogNorm

from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import OBJECTS
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.views import circles
from orbitscan.processing.reproduction.views.grid_drawing import draw_count_bar, draw_grid
from orbitscan.processing.reproduction.views.view_drawing import draw_view, picture_size
from orbitscan.processing.reproduction.views.voxelization import PLACE, Grid, make_grid
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.session import DEFAULT_VIEWS, Session, View
from orbitscan.recorder.simulation import corpus
from orbitscan.recorder.simulation.camera import simulate

THESIS_POINTS = {name: 90_000 if name == "helicopter" else 30_000 for name in OBJECTS}  # of a view, at least
CATEGORIES = ("cap", "coffee_mug", "cell_phone", "water_bottle")  # whose circles figure 3.7 shows
COLUMNS = 6  # pictures in a row
_OBJECT_PLACE = 1 / 9  # of the circle, where an object is shown


@dataclass(frozen=True, eq=False)
class Shot:
    """A view that a figure shows, and its voxel grid."""

    what: str
    instance: str
    view: View
    grid: Grid

    @property
    def points(self) -> int:
        """How many points the view has."""
        return int(self.grid.counts.sum())


Shots = Mapping[str, Sequence[Shot]]


def show_gallery(plan: Plan) -> Report:
    """Figures 3.4, 3.7, 5.6 and 5.7, and a row for each view that they show."""
    instances = circles.open_instances(plan)
    turned = [name for name in CATEGORIES if name in instances] or list(instances)
    objects = {name: simulate(name, views=DEFAULT_VIEWS) for name in OBJECTS}
    shown: dict[str, Shots] = {
        "figure-3.4": {
            name: [_take(session, PLACE) for session in _choose(sessions)] for name, sessions in instances.items()
        },
        "figure-3.7": {name: _take_round(instances[name][0]) for name in turned},
        "figure-5.6": {"": [_take(session, _OBJECT_PLACE) for session in objects.values()]},
        "figure-5.7": {name: _take_round(session) for name, session in objects.items()},
    }
    figures = {
        "figure-3.4": _draw(shown["figure-3.4"], lambda shot: f"instance {shot.instance}"),
        "figure-3.7": _draw(shown["figure-3.7"], lambda shot: f"view {shot.view.index}", alike=True, grids=True),
        "figure-5.6": _draw(shown["figure-5.6"], lambda shot: _spell(shot.what)),
        "figure-5.7": _draw(shown["figure-5.7"], lambda shot: f"view {shot.view.index}", alike=True),
    }
    rows = [_describe(name, shot) for name, shots in shown.items() for found in shots.values() for shot in found]
    settings = {"place_on_circle": PLACE, "object_place": _OBJECT_PLACE, "object_views": DEFAULT_VIEWS}
    said = [_count(instances), *_compare_points(shown)]
    return Report("gallery", "Instances, objects and their views", rows, said, figures=figures, settings=settings)


def _choose(sessions: Sequence[Session]) -> list[Session]:
    """As many sessions as fit a row, the last among them: it is the one that is tested."""
    return list(sessions) if len(sessions) <= COLUMNS else [*sessions[: COLUMNS - 1], sessions[-1]]


def _take(session: Session, share: float) -> Shot:
    view = circles.take_view(session, share)
    grid = make_grid(finite(view.points)[0], VoxelSettings().div)
    return Shot(session.info.category or session.info.name, session.info.instance or "", view, grid)


def _take_round(session: Session) -> list[Shot]:
    """Views equally far apart on the circle."""
    return [_take(session, i / COLUMNS) for i in range(COLUMNS)]


def _describe(figure: str, shot: Shot) -> Row:
    return {
        "figure": figure,
        "what": shot.what,
        "instance": shot.instance,
        "view": shot.view.index,
        "points": shot.points,
        "radius_mm": 1000 * shot.grid.side * len(shot.grid.counts) / 2,
        "occupied_voxels": len(shot.grid.occupied),
        "most_points_in_a_voxel": int(shot.grid.counts.max()),
    }


def _count(instances: Mapping[str, Sequence[Session]]) -> str:
    """How many instances there are, beside table 3.1, in words."""
    found = sum(len(sessions) for sessions in instances.values())
    other = [name for name, sessions in instances.items() if len(sessions) != corpus.INSTANCES[name]]
    said = f"{found} instances of {len(instances)} categories"
    if not other:
        return f"{said}, of each as many as in table 3.1."
    return f"{said}; table 3.1 has {sum(corpus.INSTANCES.values())}, other numbers of {', '.join(other)}."


def _compare_points(shown: Mapping[str, Shots]) -> list[str]:
    """How many points the views have, by category, and beside the thesis's objects, in words."""
    instances = sorted((shot for shots in shown["figure-3.4"].values() for shot in shots), key=lambda shot: shot.points)
    few, many = instances[0], instances[-1]
    objects = shown["figure-5.7"]
    fewer = [name for name, shots in objects.items() if max(shot.points for shot in shots) < THESIS_POINTS[name]]
    points = [shot.points for shots in objects.values() for shot in shots]
    return [
        f"A view of an instance has {few.points} points ({few.what}) to {many.points} ({many.what}).",
        f"A view of the five objects, virtual ones, has {min(points)} to {max(points)} points; the thesis's have "
        f"30000, the helicopter's 90000 or more: ours have fewer for {', '.join(fewer) if fewer else 'none'}.",
    ]


def _spell(name: str) -> str:
    return name.replace("_", " ")


def _draw(shots: Shots, label: Callable[[Shot], str], alike: bool = False, grids: bool = False) -> charts.Figure:
    """A figure with a row of pictures for each name; with `alike` each row has one scale.

    With `grids` a second row for each name shows the voxel grids.
    """
    lines, columns = 2 if grids else 1, max(map(len, shots.values()))
    height = lines * len(shots) * (7.2 / columns + 0.05)
    figure, axes = charts.new_figure(lines * len(shots), columns, width=7.2, height=height)
    for each in axes.flat:
        each.set(xticks=[], yticks=[])
        each.set_axis_off()
    norm = LogNorm(1, max(2, *(shot.grid.counts.max() for found in shots.values() for shot in found)))
    for i, (name, found) in enumerate(shots.items()):
        half = max(picture_size(shot.view) for shot in found) if alike else None
        charts.name_row(axes[lines * i, 0], -0.12, _spell(name))
        for j, shot in enumerate(found):
            draw_view(axes[lines * i, j], shot.view, half=half)
            axes[lines * i, j].set_title(label(shot), fontsize=7, pad=2)
            if grids:
                faces = draw_grid(axes[lines * i + 1, j], shot.grid.counts, norm, inches=1)
    if grids:
        draw_count_bar(figure, axes, faces)
    return figure
