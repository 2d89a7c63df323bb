"""What is drawn beside the clouds: labels, scales, the graph, the turntable, free motions, gaps; and the model."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from orbitscan.processing.results.estimates import Freedom, PairEstimate
from orbitscan.processing.results.records import Coverage, Gap, Model, Turntable
from orbitscan.processing.review import entities
from orbitscan.processing.review.markdown import name_gap
from orbitscan.processing.review.session.scene import Scene
from orbitscan.processing.review.session.shading import Shading

DASHES = 24  # of the axis of a free motion
ARC_STEP_DEG = 3.0
SCALE_ASIDE = 1.0  # of a scale of colours, in object diameters
FREE_WORDS = {"turn": "nothing tells a turn about this axis", "shift": "nothing tells a shift along this line"}


def draw_label(position: np.ndarray, text: str) -> rr.Points3D:
    """Words at a position (3,)."""
    return rr.Points3D([position], labels=[text], show_labels=True, colors=entities.LABEL_COLOR, radii=-1.0)


def draw_scale(shading: Shading, scene: Scene) -> tuple[rr.Points3D, rr.Points3D]:
    """A column of coloured dots at the object's left, much above little; words beside them, their meaning above."""
    place = scene.center - SCALE_ASIDE * scene.diameter * scene.beside()
    heights = np.linspace(-0.45, 0.45, len(shading.scale))
    column = place + heights[:, None] * scene.diameter * scene.up
    colors, words = zip(*shading.scale, strict=True)
    dots = rr.Points3D(column, colors=colors, radii=-8.0)
    places = np.vstack([column, column[-1] + 0.2 * scene.diameter * scene.up])
    texts = [*words, shading.meaning]
    return dots, rr.Points3D(places, labels=texts, show_labels=True, colors=entities.LABEL_COLOR, radii=-0.1)


def draw_edges(
    edges: Sequence[PairEstimate], places: Mapping[int, np.ndarray], order: Sequence[int]
) -> dict[int, rr.LineStrips3D]:
    """View -> lines from its place (3,) to those of the views before it in `order`; views without a place have none."""
    rank = {view: k for k, view in enumerate(order)}
    lines: dict[int, list[tuple[np.ndarray, entities.Color]]] = {}
    for edge in edges:
        if edge.source in places and edge.target in places:
            color = entities.status_color(edge.status) or entities.GOOD_COLOR
            later = max(edge.source, edge.target, key=rank.__getitem__)
            lines.setdefault(later, []).append((np.stack([places[edge.source], places[edge.target]]), color))
    return {
        view: rr.LineStrips3D([line for line, _ in of_view], colors=[color for _, color in of_view], radii=-0.75)
        for view, of_view in lines.items()
    }


def draw_turntable(turntable: Turntable, scene: Scene) -> tuple[rr.Arrows3D, rr.Points3D]:
    """The axis as an arrow through the object, which the camera goes round by the right-hand rule; its label."""
    half = 0.85 * scene.diameter * turntable.axis
    middle = scene.foot(turntable.axis, turntable.point)
    arrow = rr.Arrows3D(origins=[middle - half], vectors=[2 * half], colors=entities.TURNTABLE_COLOR, radii=-2.5)
    text = f"turntable, {turntable.step_deg:.2f}° a view"
    return arrow, draw_label(middle + 1.08 * half, text)


def draw_freedom(freedom: Freedom, scene: Scene) -> tuple[rr.LineStrips3D, rr.Points3D]:
    """The axis of a motion that nothing determines, dashed, a turn's with a ring about it; its label."""
    size = scene.diameter
    dots = np.linspace(-1.1 * size, 1.1 * size, 2 * DASHES)[:, None] * freedom.axis
    dots += scene.foot(freedom.axis, freedom.point)
    strips = list(dots.reshape(DASHES, 2, 3))
    if freedom.kind == "turn":
        across = np.linalg.svd(freedom.axis[None])[2][1:]  # two unit vectors perpendicular to the axis
        angle = np.linspace(0, 2 * np.pi, 4 * DASHES)[:, None]
        ring = 0.2 * size * (np.cos(angle) * across[0] + np.sin(angle) * across[1])
        strips += list((dots[0] + ring).reshape(2 * DASHES, 2, 3))
    lines = rr.LineStrips3D(strips, colors=entities.FREE_COLOR, radii=-1.5)
    return lines, draw_label(1.1 * dots[0] - 0.1 * scene.center, FREE_WORDS[freedom.kind])


def draw_gap(gap: Gap, coverage: Coverage, scene: Scene) -> tuple[rr.LineStrips3D, rr.Points3D]:
    """An arc of azimuths that no view covers, about the object's foot as on a compass, with its ends; its label."""
    middle = scene.foot(coverage.up, coverage.center) - 0.4 * scene.diameter * coverage.up
    radius = 0.95 * scene.diameter
    degrees = np.linspace(gap.start_deg, gap.end_deg, max(3, round((gap.end_deg - gap.start_deg) / ARC_STEP_DEG)))
    arc = middle + radius * coverage.toward(degrees)
    ends = [np.stack([middle + 0.7 * (end - middle), end]) for end in (arc[0], arc[-1])]
    lines = rr.LineStrips3D([arc, *ends], colors=entities.GAP_COLOR, radii=-2.0)
    return lines, draw_label(arc[len(arc) // 2], name_gap(gap.start_deg, gap.end_deg))


def log_model(stream: rr.RecordingStream, model: Model, up: np.ndarray) -> None:
    """Writes a model; without colours it is shaded by height along `up` (3,)."""
    colors = model.colors if model.colors is not None else entities.height_colors(model.points, up)
    stream.log("/model/points", rr.Points3D(model.points, colors=colors, radii=-1.5), static=True)
    outliers = rr.Points3D(model.removed, colors=entities.BAD_COLOR, radii=-2.0)
    stream.log("/model/outliers", outliers, static=True)
    if (mesh := model.mesh) is not None:
        colors = mesh.colors if mesh.colors is not None else entities.height_colors(mesh.vertices, up)
        surface = rr.Mesh3D(
            vertex_positions=mesh.vertices,
            triangle_indices=mesh.triangles,
            vertex_colors=colors,
            vertex_normals=_vertex_normals(mesh.vertices, mesh.triangles),
        )
        stream.log("/model/mesh", surface, static=True)


def _vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(V, 3) unit: the mean of the triangles around each vertex, by area; without them the viewer shades nothing."""
    a, b, c = vertices[triangles].astype(np.float64).swapaxes(0, 1)
    across = np.cross(b - a, c - a)
    normals = np.zeros(vertices.shape)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
