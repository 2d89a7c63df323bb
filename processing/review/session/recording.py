"""Results -> review.rrd: a session's recording grows view by view and opens at the finished object."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import rerun as rr

from orbitscan.processing.results.classification import ViewClassification
from orbitscan.processing.results.edges import count_edges
from orbitscan.processing.results.estimates import MethodResult
from orbitscan.processing.results.records import SessionResult, ViewResult
from orbitscan.processing.results.status import METHODS, Method, Status
from orbitscan.processing.review import entities
from orbitscan.processing.review.curves import (
    Curves,
    bound_values,
    error_values,
    evidence_values,
    timing_values,
    turntable_values,
)
from orbitscan.processing.review.session import classification, findings, marks, summary, tables
from orbitscan.processing.review.session.layout import lay_out
from orbitscan.processing.review.session.scene import Scene
from orbitscan.processing.review.session.shading import shade_views
from orbitscan.processing.review.session.view_story import Seen, tell
from orbitscan.processing.review.session.views import PlacedViews
from orbitscan.processing.review.stream import GrowingRecording, make_document
from orbitscan.recorder import poses
from orbitscan.recorder.session import SessionInfo

POINT_BYTES = 64  # of a view's point, or a point of the model, in the file: at most


class SessionReview:
    """A session's Rerun recording, written as its results come; it colours and words them and decides nothing.

    Each view is flushed: the file of a killed run is readable up to it. What `refined` says is known at the end: its
    clouds are written as they come, where they stand follows, and until then the layout shows `pairwise`.
    """

    def __init__(
        self,
        path: Path,
        info: SessionInfo,
        methods: Sequence[Method],
        truth: Mapping[int, np.ndarray] | None = None,
        *,
        identity: str = "",
        viewer: str | None = None,
    ) -> None:
        """Opens `path`; `truth` is T_object_camera by recorded index, of whichever views it is known.

        A viewer merges recordings of one session's name, unless `identity` tells them apart. It shows this one as it
        grows where it listens at `viewer`.
        """
        self._info = info
        self._methods = tuple(method for method in METHODS if method in methods)  # worst to best
        self._joint = "refined" in methods
        self._coming = tuple(  # those that place a view as it comes
            m for m in METHODS if m != "refined" and (m in methods or (m == "pairwise" and self._joint))
        )
        self._truth = dict(truth or {})
        self._T_0_object: np.ndarray | None = None  # of the truth
        self._scene: Scene | None = None
        self._origin: int | None = None  # the view whose frame is {0}
        self._errors = entities.ERRORS_ROOT  # where their curves are
        self._categories: tuple[str, ...] = ()  # of what classifies the views
        self._is_colored = False
        self._seen: dict[int, Seen] = {}
        recording_id = "-".join(filter(None, (entities.APPLICATION_ID, info.name, identity)))
        self._file = GrowingRecording(path, recording_id, viewer)
        self._stream = self._file.stream
        self._curves = Curves(self._stream)
        self._placed = PlacedViews(self._stream, info, self._methods[-1])
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
        """Writes what is known of a view; what does not exist (an estimate, a truth, points) is left out.

        Raises OSError where the disk is full.
        """
        self._file.reserve(POINT_BYTES * len(result.points))
        self._placed.set_time(result.view, result.stamp_ns)
        self._placed.keep(result)
        self._seen[result.view] = Seen.of(result)
        self._is_colored = self._is_colored or result.colors is not None
        if result.classification is not None:
            self._log_classes(result.classification)
        if result.origin == result.view:
            self._set_scene(result.view, result.points)
            self._send_first_layout()
        self._log_truth(result.view)
        for method, estimate in result.poses.items():
            if estimate.T_0_i is not None:
                self._placed.log_placed(method, estimate)
                self._placed.log_cloud(method, result, estimate.status)
        if self._joint and self._scene is not None:
            self._placed.log_cloud(Method.REFINED, result, Status.OK)
        for method in self._methods:
            if method in result.poses:
                self._curves.add(result.view, error_values(method, result.poses[method].errors))
            if method in result.pairs:
                self._curves.add(result.view, evidence_values(method, result.pairs[method]))
            if method in result.seconds:
                self._curves.add(result.view, timing_values(method, result.seconds[method]))
        if result.correspondences is not None:
            self._placed.log_matches(result.correspondences)
        pairs = {method: (pair,) for method, pair in result.pairs.items()}
        self._log_text("/story", tell(self._seen[result.view], result.poses, pairs, finished=False), static=False)
        for level, text in findings.list_findings(result, self._methods):
            self._stream.log("/log", rr.TextLog(text, level=level))
        self._file.flush()

    def add_session(self, result: SessionResult) -> None:
        """Writes what is known only at the end: `refined`, the rest of the curves, the model, summary and table.

        Raises OSError where the disk is full.
        """
        if result.model is not None:
            meshed = 0 if result.model.mesh is None else len(result.model.mesh.triangles)
            self._file.reserve(POINT_BYTES * (len(result.model.points) + meshed))
        stamps_ns = dict(zip(result.views_used, result.stamps_ns, strict=True))
        best = result.reconstruction[self._methods[-1]]
        if self._scene is not None:
            self._log_final(result, stamps_ns)
        self._complete_curves(result, stamps_ns)
        if self._scene is not None:
            self._log_marks(result, best, self._scene)
        self._send_layout(result, best)
        self._log_text("/summary", summary.summarize(result, self._methods))
        self._log_text("/table", tables.tabulate_views(result, self._methods))
        self._log_stories(result, stamps_ns)
        for view, level, text in (*findings.list_joint_findings(result), *classification.list_dissent(result)):
            self._placed.set_time(view, stamps_ns[view])
            self._stream.log("/log", rr.TextLog(text, level=level))
            self._file.flush()  # a chunk of one view: over a chunk of several the viewer mixes up the levels
        if stamps_ns:
            self._placed.set_time(*list(stamps_ns.items())[-1])
        self._stream.log("/log", rr.TextLog(summary.conclude(result, self._methods[-1]), level=rr.TextLogLevel.INFO))
        if (shown := result.classification) is not None:
            answer = classification.conclude(shown, self._info.category)
            self._stream.log("/log", rr.TextLog(answer, level=rr.TextLogLevel.INFO))
        self._file.flush()

    def _describe(self) -> None:
        self._stream.send_recording_name(self._info.name)
        known = {name: value for name, value in asdict(self._info).items() if value not in (None, "")}
        self._stream.send_property("session", rr.AnyValues(**known, methods=list(self._methods)))
        self._stream.log("/", rr.ViewCoordinates.RDF, static=True)  # frame {0} is a camera's
        self._log_text("/summary", summary.write_unfinished(self._info.name))

    def _set_scene(self, origin: int, points: np.ndarray) -> None:
        """The scene as seen from the view whose frame is {0}."""
        self._origin = origin
        self._scene = Scene.around(points, self._info.elevation_deg, self._info.sensor_origin)
        self._placed.scene = self._scene
        self._T_0_object = poses.invert(self._truth[origin]) if origin in self._truth else None

    def _log_truth(self, view: int) -> None:
        if self._T_0_object is not None and view in self._truth:
            self._placed.log_truth(view, self._T_0_object @ self._truth[view])

    def _log_final(self, result: SessionResult, stamps_ns: Mapping[int, int]) -> None:
        """All views where they stand when all is known: another view than the first may have given frame {0}."""
        if result.origin is not None and result.origin != self._origin:
            self._set_scene(result.origin, self._placed.get_points(result.origin))
            self._errors = entities.ERRORS_AGAIN
            for view, stamp_ns in stamps_ns.items():
                self._placed.set_time(view, stamp_ns)
                self._log_truth(view)
                if self._T_0_object is None:
                    self._stream.log("/object/truth", rr.Clear(recursive=True))
        for method, found in result.reconstruction.items():
            self._placed.log_final(method, found, stamps_ns)
        if self._joint:
            self._placed.log_edges(result.reconstruction[Method.REFINED], stamps_ns)

    def _send_first_layout(self) -> None:
        layout = lay_out(
            self._coming,
            self._T_0_object is not None,
            self._scene,
            is_colored=self._is_colored,
            categories=self._categories,
        )
        self._stream.send_blueprint(layout)

    def _log_classes(self, found: ViewClassification) -> None:
        if not self._categories:
            self._categories = tuple(found.probabilities)
            self._curves.styles = classification.choose_styles(self._categories, self._info.category)
        self._curves.add(found.view, classification.probability_values(found))

    def _complete_curves(self, result: SessionResult, stamps_ns: Mapping[int, int]) -> None:
        for method, found in result.reconstruction.items():
            errors = {v.view: error_values(method, v.errors, self._errors) for v in found.views}
            self._curves.complete(errors, stamps_ns)
            self._curves.complete({v.view: bound_values(method, v) for v in found.views}, stamps_ns)
            pairs = found.speaking.items()
            self._curves.complete({view: evidence_values(method, pair) for view, pair in pairs}, stamps_ns)
        if self._joint:
            held = count_edges(result.reconstruction[Method.REFINED].pairs).items()
            self._curves.complete({v: [("/evidence/edges/refined", float(count))] for v, count in held}, stamps_ns)
        if (shown := result.classification) is not None:
            self._curves.complete(classification.fused_values(shown), stamps_ns)
        if result.turntable is not None:
            of_view = {d.view: turntable_values(self._methods[-1], d) for d in result.turntable.deviations}
            self._curves.complete(of_view, stamps_ns)

    def _log_marks(self, result: SessionResult, best: MethodResult, scene: Scene) -> None:
        if result.turntable is not None:
            self._log_marked("/turntable/axis", *marks.draw_turntable(result.turntable, scene))
        for number, freedom in enumerate(best.freedoms[: summary.SHOWN_FREEDOMS]):
            self._log_marked(f"/free/{number:02d}", *marks.draw_freedom(freedom, scene))
        if (coverage := result.coverage) is not None:
            for number, gap in enumerate(coverage.gaps[: summary.SHOWN_GAPS]):
                self._log_marked(f"/coverage/gap_{number:02d}", *marks.draw_gap(gap, coverage, scene))
        if result.model is not None:
            marks.log_model(self._stream, result.model, scene.up)

    def _send_layout(self, result: SessionResult, best: MethodResult) -> None:
        drawn = self._placed.sensors(best.views) if self._scene is not None else {}
        shading = shade_views(best) if drawn else None
        if shading is not None and self._scene is not None:
            self._log_marked("/scale", *marks.draw_scale(shading, self._scene))
        shown = result.classification
        layout = lay_out(
            self._methods,
            self._T_0_object is not None,
            self._scene,
            is_colored=self._is_colored,
            view_colors={view: entities.view_color(view, self._info.views) for view in drawn},
            shading=shading,
            errors=self._errors,
            has_bounds=any(v.rotation_bound_deg for found in result.reconstruction.values() for v in found.views),
            has_turntable=result.turntable is not None,
            has_mesh=result.model is not None and result.model.mesh is not None,
            categories=classification.shown_categories(shown, self._info.category) if shown else (),
        )
        self._stream.send_blueprint(layout)

    def _log_stories(self, result: SessionResult, stamps_ns: Mapping[int, int]) -> None:
        """Each view's story again, now that all is known of it."""
        by_method = result.reconstruction.items()
        estimates = {method: {v.view: v for v in found.views} for method, found in by_method}
        for view, seen in self._seen.items():
            pairs = {m: [pair for pair in found.pairs if view in (pair.source, pair.target)] for m, found in by_method}
            of_view = {method: views[view] for method, views in estimates.items() if view in views}
            self._placed.set_time(view, stamps_ns[view])
            self._log_text("/story", tell(seen, of_view, pairs, finished=True), static=False)

    def _log_marked(self, path: str, drawing: rr.AsComponents, label: rr.Points3D) -> None:
        self._stream.log(path, drawing, static=True)
        self._stream.log(f"{path}/label", label, static=True)

    def _log_text(self, path: str, markdown: str, static: bool = True) -> None:
        self._stream.log(path, make_document(markdown), static=static)
