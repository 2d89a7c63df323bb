"""Results -> review.rrd: a session's recording grows view by view and opens at the finished object."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import rerun as rr

from processing.results.records import (
    METHODS,
    Correspondences,
    MethodResult,
    Model,
    SessionResult,
    ViewClassification,
    ViewEstimate,
    ViewResult,
)
from processing.review import classification, entities, findings, marks, summary, tables
from processing.review.curves import Curves, error_values, evidence_values, timing_values, turntable_values
from processing.review.edges import count_edges, strongest
from processing.review.layout import Scene, lay_out
from recorder import poses
from recorder.session import SessionInfo

LESSER_POINTS = 3000  # points of a view's cloud by any method but the best
PAIR_POINTS = 3000  # points of either cloud that matches are drawn between
SHOWN_FREEDOMS = 3  # motions that nothing determines, as drawn


class SessionReview:
    """A session's Rerun recording, written as its results come; it colours and words them and decides nothing.

    The clouds of the best method are complete. Those of the others are thinned to LESSER_POINTS a view, so that the
    file does not hold every cloud once a method. Each view is flushed: the file of a killed run is readable up to it.
    What `refined` says is known at the end: its clouds are written as they come, where they stand follows, and until
    then the layout shows `pairwise`.
    """

    def __init__(
        self, path: Path, info: SessionInfo, methods: Sequence[str], truth: Mapping[int, np.ndarray] | None = None
    ) -> None:
        """Opens `path`; `truth` is T_object_camera by recorded index, of whichever views it is known."""
        self._info = info
        self._methods = tuple(method for method in METHODS if method in methods)  # worst to best
        self._joint = "refined" in methods
        self._coming = tuple(  # those that place a view as it comes
            m for m in METHODS if m != "refined" and (m in methods or (m == "pairwise" and self._joint))
        )
        self._truth = dict(truth or {})
        self._T_0_object: np.ndarray | None = None  # of the truth
        self._scene: Scene | None = None
        self._categories: tuple[str, ...] = ()  # of what classifies the views
        self._samples: dict[int, np.ndarray] = {}  # view -> thinned cloud, for the views matched to it later
        self._stream = rr.RecordingStream(
            entities.APPLICATION_ID,
            recording_id=f"{entities.APPLICATION_ID}-{info.name}",
            send_properties=False,  # they hold the time of writing
            batcher_config=rr.ChunkBatcherConfig.NEVER(),  # flushed here only: the same chunks in every run
        )
        self._stream.set_log_time_enabled(False)
        self._stream.save(path)
        self._curves = Curves(self._stream)
        self._describe()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Completes the file."""
        self._stream.disconnect()

    def add_view(self, result: ViewResult) -> None:
        """Writes what is known of a view; what does not exist (an estimate, a truth, points) is left out."""
        self._set_time(result.view, result.stamp_ns)
        if result.classification is not None:
            self._log_classes(result.classification)
        if result.origin == result.view:
            self._set_scene(result)
        if self._T_0_object is not None and result.view in self._truth:
            self._log_pose("truth", result.view, self._T_0_object @ self._truth[result.view], entities.TRUTH_COLOR)
        self._samples[result.view] = _thin(result.points, PAIR_POINTS)
        for method, estimate in result.poses.items():
            if estimate.T_0_i is not None:
                self._log_placed(method, estimate)
                self._log_cloud(method, result, entities.status_color(estimate.status))
        if self._joint and self._scene is not None:
            self._log_cloud("refined", result, None)
        for method in self._methods:
            if method in result.poses:
                self._curves.add(result.view, error_values(method, result.poses[method].errors))
            if method in result.pairs:
                self._curves.add(result.view, evidence_values(method, result.pairs[method]))
            if method in result.seconds:
                self._curves.add(result.view, timing_values(method, result.seconds[method]))
        if result.correspondences is not None:
            self._log_matches(result.correspondences)
        for level, text in findings.list_findings(result, self._methods):
            self._stream.log("/log", rr.TextLog(text, level=level))
        self._stream.flush()

    def add_session(self, result: SessionResult) -> None:
        """Writes what is known only at the end: `refined`, the rest of the curves, the model, summary and table."""
        stamps_ns = dict(zip(result.views_used, result.stamps_ns, strict=True))
        best = result.reconstruction[self._methods[-1]]
        if self._joint and self._scene is not None:
            self._log_joint(result.reconstruction["refined"], stamps_ns)
        for method, found in result.reconstruction.items():
            self._curves.complete({v.view: error_values(method, v.errors) for v in found.views}, stamps_ns)
            pairs = strongest(found.pairs).items()
            self._curves.complete({view: evidence_values(method, pair) for view, pair in pairs}, stamps_ns)
        if self._joint:
            held = count_edges(result.reconstruction["refined"].pairs).items()
            self._curves.complete({v: [("/evidence/edges/refined", float(count))] for v, count in held}, stamps_ns)
        if (shown := result.classification) is not None:
            self._curves.complete(classification.fused_values(shown), stamps_ns)
        if result.turntable is not None:
            of_view = {d.view: turntable_values(self._methods[-1], d) for d in result.turntable.deviations}
            self._curves.complete(of_view, stamps_ns)
            self._log_marked("/turntable/axis", *marks.draw_turntable(result.turntable, self._scene))
        for number, freedom in enumerate(best.freedoms[:SHOWN_FREEDOMS]):
            self._log_marked(f"/free/{number:02d}", *marks.draw_freedom(freedom, self._scene))
        if result.model is not None:
            self._log_model(result.model)
        layout = lay_out(
            self._methods,
            self._T_0_object is not None,
            self._scene,
            has_turntable=result.turntable is not None,
            has_mesh=result.model is not None and result.model.mesh is not None,
            categories=classification.shown_categories(shown, self._info.category) if shown else (),
        )
        self._stream.send_blueprint(layout)
        self._log_text("/summary", summary.summarize(result, self._methods))
        for view, level, text in (*findings.list_joint_findings(result), *classification.list_dissent(result)):
            self._set_time(view, stamps_ns[view])
            self._stream.log("/log", rr.TextLog(text, level=level))
            self._stream.flush()  # a chunk of one view: over a chunk of several the viewer mixes up the levels
        if stamps_ns:
            self._set_time(*list(stamps_ns.items())[-1])
        self._stream.log("/log", rr.TextLog(summary.conclude(result, self._methods[-1]), level=rr.TextLogLevel.INFO))
        if shown is not None:
            answer = classification.conclude(shown, self._info.category)
            self._stream.log("/log", rr.TextLog(answer, level=rr.TextLogLevel.INFO))
        self._log_text("/table", tables.tabulate_views(result, self._methods))
        self._stream.flush()

    def _set_time(self, view: int, stamp_ns: int) -> None:
        self._stream.set_time(entities.VIEW_TIMELINE, sequence=view)
        self._stream.set_time(entities.STAMP_TIMELINE, timestamp=np.datetime64(stamp_ns, "ns"))

    def _describe(self) -> None:
        self._stream.send_recording_name(self._info.name)
        known = {name: value for name, value in asdict(self._info).items() if value not in (None, "")}
        self._stream.send_property("session", rr.AnyValues(**known, methods=list(self._methods)))
        self._stream.log("/", rr.ViewCoordinates.RDF, static=True)  # frame {0} is a camera's
        self._log_text("/summary", summary.write_unfinished(self._info.name))

    def _set_scene(self, origin: ViewResult) -> None:
        self._scene = Scene.around(origin.points, self._info.elevation_deg, self._info.sensor_origin)
        if origin.view in self._truth:
            self._T_0_object = poses.invert(self._truth[origin.view])
        layout = lay_out(self._coming, self._T_0_object is not None, self._scene, categories=self._categories)
        self._stream.send_blueprint(layout)

    def _log_classes(self, found: ViewClassification) -> None:
        if not self._categories:
            self._categories = tuple(found.probabilities)
            self._curves.choose_styles(classification.choose_styles(self._categories, self._info.category))
        self._curves.add(found.view, classification.probability_values(found))

    def _log_placed(self, method: str, estimate: ViewEstimate) -> None:
        """The frustum where a method puts it, with the status in words where that is not ok."""
        wrong = entities.status_color(estimate.status)
        color, width = (entities.METHOD_COLORS[method], -2.0) if wrong is None else (wrong, -3.5)
        self._log_pose(method, estimate.view, estimate.T_0_i, color, width)
        points = self._samples[estimate.view]
        if wrong is not None and len(points):
            place = self._above(points) if self._scene.sensor is None else self._scene.sensor
            label = marks.draw_label(place, f"view {estimate.view}: {estimate.status}")
            self._stream.log(f"{entities.view_path(method, estimate.view)}/label", label)

    def _log_cloud(self, method: str, result: ViewResult, color: entities.Color | None) -> None:
        """A view's points in one colour, else as captured or in the view's own."""
        if not len(result.points):
            return
        step = 1 if method == self._methods[-1] else _step(len(result.points), LESSER_POINTS)
        if color is not None:
            colors = color
        elif result.colors is not None:
            colors = result.colors[::step]
        else:
            colors = entities.view_color(result.view, self._info.views)
        path = entities.view_path(method, result.view)
        self._stream.log(f"{path}/points", rr.Points3D(result.points[::step], colors=colors, radii=-1.5))

    def _log_joint(self, found: MethodResult, stamps_ns: Mapping[int, int]) -> None:
        """Where `refined` puts the views, whose clouds are written already, and the edges of its graph."""
        for estimate in found.views:
            self._set_time(estimate.view, stamps_ns[estimate.view])
            path = entities.view_path("refined", estimate.view)
            if estimate.T_0_i is None:
                self._stream.log(path, rr.Clear(recursive=True))  # its cloud, which stands nowhere
                continue
            self._log_placed("refined", estimate)
            color = entities.status_color(estimate.status)
            if color is not None and len(self._samples[estimate.view]):
                self._stream.log(f"{path}/points", rr.Points3D.from_fields(colors=color))
        self._log_edges(found, stamps_ns)

    def _log_edges(self, found: MethodResult, stamps_ns: Mapping[int, int]) -> None:
        """Lines from each view's frustum, or the middle of its cloud, to those of the views before it."""
        places = {}
        for view in found.views:
            points = self._samples[view.view]
            if view.T_0_i is not None and len(points):
                place = points.mean(axis=0) if self._scene.sensor is None else self._scene.sensor
                places[view.view] = poses.transform(view.T_0_i, place[None])[0]
        for view, lines in marks.draw_edges(found.pairs, places, list(stamps_ns)).items():
            self._set_time(view, stamps_ns[view])
            self._stream.log(entities.graph_path(view), lines)

    def _log_marked(self, path: str, drawing: rr.AsComponents, label: rr.Points3D) -> None:
        self._stream.log(path, drawing, static=True)
        self._stream.log(f"{path}/label", label, static=True)

    def _log_pose(
        self, method: str, view: int, T_0_i: np.ndarray, color: entities.Color, line_width: float = -1.0
    ) -> None:
        path = entities.view_path(method, view)
        self._stream.log(path, rr.Transform3D(translation=T_0_i[:3, 3], mat3x3=T_0_i[:3, :3]))
        if self._scene.sensor is None:
            return
        if self._scene.sensor.any():
            self._stream.log(f"{path}/camera", rr.Transform3D(translation=self._scene.sensor))
        frustum = rr.Pinhole(
            fov_y=0.7,
            aspect_ratio=4 / 3,
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=0.1 * self._scene.diameter,
            color=color,
            line_width=line_width,
        )
        self._stream.log(f"{path}/camera", frustum)

    def _log_matches(self, found: Correspondences) -> None:
        """The two clouds side by side, each about its own centre as its sensor saw it, and the matches across."""
        source, target = self._samples[found.source], self._samples[found.target]
        if not len(source) or not len(target):
            return
        path = entities.pair_path(found.source, found.target)
        aside = np.array([0.65 * self._scene.diameter, 0.0, 0.0])
        to_right, to_left = aside - source.mean(axis=0), -aside - target.mean(axis=0)
        for name, points, view in (
            ("source", source + to_right, found.source),
            ("target", target + to_left, found.target),
        ):
            self._stream.log(f"{path}/{name}", rr.Points3D(points, colors=entities.PLAIN_COLOR, radii=-1.5))
            self._stream.log(f"{path}/{name}/label", marks.draw_label(self._above(points), f"view {view}"))
        lines = np.stack([found.source_points + to_right, found.target_points + to_left], axis=1)
        for name, keep, color in (
            ("matches", ~found.inlier, entities.BAD_COLOR),
            ("inliers", found.inlier, entities.GOOD_COLOR),
        ):
            self._stream.log(f"{path}/{name}", rr.LineStrips3D(lines[keep], colors=color, radii=-0.5))

    def _above(self, points: np.ndarray) -> np.ndarray:
        """A place above points in a camera's frame, whose -y is up."""
        x, _, z = points.mean(axis=0)
        return np.array([x, points[:, 1].min() - 0.05 * self._scene.diameter, z])

    def _log_model(self, model: Model) -> None:
        colors = model.colors if model.colors is not None else entities.height_colors(model.points, self._scene.up)
        points = rr.Points3D(model.points, colors=colors, radii=-1.5)
        outliers = rr.Points3D(model.removed, colors=entities.BAD_COLOR, radii=-2.0)
        self._stream.log("/model/points", points, static=True)
        self._stream.log("/model/outliers", outliers, static=True)
        if (mesh := model.mesh) is not None:
            colors = mesh.colors if mesh.colors is not None else entities.height_colors(mesh.vertices, self._scene.up)
            surface = rr.Mesh3D(
                vertex_positions=mesh.vertices,
                triangle_indices=mesh.triangles,
                vertex_colors=colors,
                vertex_normals=_vertex_normals(mesh.vertices, mesh.triangles),
            )
            self._stream.log("/model/mesh", surface, static=True)

    def _log_text(self, path: str, markdown: str) -> None:
        self._stream.log(path, rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN), static=True)


def _vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(V, 3) unit: the mean of the triangles around each vertex, by area; without them the viewer shades nothing."""
    a, b, c = vertices[triangles].astype(np.float64).swapaxes(0, 1)
    across = np.cross(b - a, c - a)
    normals = np.zeros(vertices.shape)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _step(count: int, wanted: int) -> int:
    return max(1, -(-count // wanted))


def _thin(points: np.ndarray, wanted: int) -> np.ndarray:
    return points[:: _step(len(points), wanted)].copy()  # a slice would keep the whole cloud in memory
