"""Results -> review.rrd: a session's recording grows view by view and opens at the finished object."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import rerun as rr

from processing.results.records import METHODS, Correspondences, Model, SessionResult, ViewEstimate, ViewResult
from processing.review import entities, summary
from processing.review.curves import Curves, error_values, evidence_values, timing_values
from processing.review.layout import Scene, lay_out
from recorder import poses
from recorder.session import SessionInfo

LESSER_POINTS = 3000  # points of a view's cloud by any method but the best
PAIR_POINTS = 3000  # points of either cloud that matches are drawn between


class SessionReview:
    """A session's Rerun recording, written as its results come; it colours and words them and decides nothing.

    The clouds of the best method are complete. Those of the others are thinned to LESSER_POINTS a view, so that the
    file does not hold every cloud once a method. Each view is flushed: the file of a killed run is readable up to it.
    """

    def __init__(
        self, path: Path, info: SessionInfo, methods: Sequence[str], truth: Mapping[int, np.ndarray] | None = None
    ) -> None:
        """Opens `path`; `truth` is T_object_camera by recorded index, of whichever views it is known."""
        self._info = info
        self._methods = tuple(method for method in METHODS if method in methods)  # worst to best
        self._truth = dict(truth or {})
        self._T_0_object: np.ndarray | None = None  # of the truth
        self._scene: Scene | None = None
        self._sensor: np.ndarray | None = None  # where frusta stand in the views' frames
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
        self._stream.set_time(entities.VIEW_TIMELINE, sequence=result.view)
        self._stream.set_time(entities.STAMP_TIMELINE, timestamp=np.datetime64(result.stamp_ns, "ns"))
        if result.origin == result.view:
            self._set_scene(result)
        if self._T_0_object is not None and result.view in self._truth:
            self._log_pose("truth", result.view, self._T_0_object @ self._truth[result.view], entities.TRUTH_COLOR)
        for method, estimate in result.poses.items():
            if estimate.T_0_i is not None:
                self._log_view(method, estimate, result)
            self._curves.add(result.view, error_values(method, estimate.errors))
        for method, pair in result.pairs.items():
            self._curves.add(result.view, evidence_values(method, pair))
        for method, seconds in result.seconds.items():
            self._curves.add(result.view, timing_values(method, seconds))
        self._samples[result.view] = _thin(result.points, PAIR_POINTS)
        if result.correspondences is not None:
            self._log_matches(result.correspondences)
        for level, text in summary.list_findings(result):
            self._stream.log("/log", rr.TextLog(text, level=level))
        self._stream.flush()

    def add_session(self, result: SessionResult) -> None:
        """Writes what is known only at the end: the rest of the curves, the model, the summary, the table."""
        stamps_ns = dict(zip(result.views_used, result.stamps_ns, strict=True))
        for method, found in result.reconstruction.items():
            self._curves.complete({v.view: error_values(method, v.errors) for v in found.views}, stamps_ns)
            self._curves.complete({p.source: evidence_values(method, p) for p in found.pairs}, stamps_ns)
        if self._scene is None:
            self._stream.send_blueprint(lay_out(self._methods, has_truth=False, scene=None))
        if result.model is not None:
            self._log_model(result.model)
        self._log_text("/summary", summary.summarize(result, self._methods))
        self._stream.log("/log", rr.TextLog(summary.conclude(result, self._methods[-1]), level=rr.TextLogLevel.INFO))
        self._log_text("/table", summary.tabulate_views(result, self._methods))
        self._stream.flush()

    def _describe(self) -> None:
        self._stream.send_recording_name(self._info.name)
        known = {name: value for name, value in asdict(self._info).items() if value not in (None, "")}
        self._stream.send_property("session", rr.AnyValues(**known, methods=list(self._methods)))
        self._stream.log("/", rr.ViewCoordinates.RDF, static=True)  # frame {0} is a camera's
        self._log_text("/summary", summary.write_unfinished(self._info.name))

    def _set_scene(self, origin: ViewResult) -> None:
        self._scene = Scene.around(origin.points, self._info.elevation_deg)
        self._sensor = self._scene.place_sensor(self._info.sensor_origin)
        if origin.view in self._truth:
            self._T_0_object = poses.invert(self._truth[origin.view])
        self._stream.send_blueprint(lay_out(self._methods, self._T_0_object is not None, self._scene))

    def _log_view(self, method: str, estimate: ViewEstimate, result: ViewResult) -> None:
        path, ok = entities.view_path(method, estimate.view), estimate.status == "ok"
        color = entities.METHOD_COLORS[method] if ok else entities.BAD_COLOR
        self._log_pose(method, estimate.view, estimate.T_0_i, color, line_width=-2.0 if ok else -3.5)
        if not len(result.points):
            return
        step = 1 if method == self._methods[-1] else _step(len(result.points), LESSER_POINTS)
        points = result.points[::step]
        if not ok:
            colors = entities.BAD_COLOR
            place = self._above(points) if self._sensor is None else self._sensor
            self._log_label(path, place, f"view {estimate.view}: {estimate.status}")
        elif result.colors is not None:
            colors = result.colors[::step]
        else:
            colors = entities.view_color(estimate.view, self._info.views)
        self._stream.log(f"{path}/points", rr.Points3D(points, colors=colors, radii=-1.5))

    def _log_pose(
        self, method: str, view: int, T_0_i: np.ndarray, color: entities.Color, line_width: float = -1.0
    ) -> None:
        path = entities.view_path(method, view)
        self._stream.log(path, rr.Transform3D(translation=T_0_i[:3, 3], mat3x3=T_0_i[:3, :3]))
        if self._sensor is None:
            return
        if self._sensor.any():
            self._stream.log(f"{path}/camera", rr.Transform3D(translation=self._sensor))
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
            self._log_label(f"{path}/{name}", self._above(points), f"view {view}")
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

    def _log_label(self, path: str, position: np.ndarray, text: str) -> None:
        label = rr.Points3D([position], labels=[text], show_labels=True, colors=entities.LABEL_COLOR, radii=-1.0)
        self._stream.log(f"{path}/label", label)

    def _log_model(self, model: Model) -> None:
        colors = model.colors if model.colors is not None else entities.height_colors(model.points, self._scene.up)
        points = rr.Points3D(model.points, colors=colors, radii=-1.5)
        outliers = rr.Points3D(model.removed, colors=entities.BAD_COLOR, radii=-2.0)
        self._stream.log("/model/points", points, static=True)
        self._stream.log("/model/outliers", outliers, static=True)

    def _log_text(self, path: str, markdown: str) -> None:
        self._stream.log(path, rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN), static=True)


def _step(count: int, wanted: int) -> int:
    return max(1, -(-count // wanted))


def _thin(points: np.ndarray, wanted: int) -> np.ndarray:
    return points[:: _step(len(points), wanted)]
