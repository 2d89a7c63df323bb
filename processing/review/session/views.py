"""Where each method puts the views: poses, frusta, clouds and the pairs between them, as a session's 3D views show."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from orbitscan.processing.results.estimates import Correspondences, MethodResult, ViewEstimate
from orbitscan.processing.results.records import ViewResult
from orbitscan.processing.results.status import Method, Status
from orbitscan.processing.review import entities
from orbitscan.processing.review.session import marks
from orbitscan.processing.review.session.scene import Scene
from orbitscan.recorder import poses
from orbitscan.recorder.session import SessionInfo

LESSER_POINTS = 3000  # points of a view's cloud by any method but the best
PAIR_POINTS = 3000  # points of either cloud that matches are drawn between
_TRUTH_WIDTH, _WIDTH, _FAILED_WIDTH = -1.0, -2.0, -3.5  # of a frustum's lines, in pixels


class PlacedViews:
    """Writes views where methods, or the truth, put them.

    The clouds of the best method are complete. Those of the others are thinned to LESSER_POINTS a view, so that the
    file does not hold every cloud once a method.
    """

    def __init__(self, stream: rr.RecordingStream, info: SessionInfo, best: str) -> None:
        self._stream = stream
        self._info = info
        self._best = best
        self.scene: Scene  # how large the object is and where frusta stand; set before anything is placed
        self._samples: dict[int, np.ndarray] = {}  # view -> thinned cloud, for the views matched to it later
        self._drawn: dict[tuple[str, int], ViewEstimate] = {}  # by method and view
        self._clouds: set[tuple[str, int]] = set()

    def set_time(self, view: int, stamp_ns: int) -> None:
        """Sets the time of all that the stream gets next."""
        self._stream.set_time(entities.VIEW_TIMELINE, sequence=view)
        self._stream.set_time(entities.STAMP_TIMELINE, timestamp=np.datetime64(stamp_ns, "ns"))

    def keep(self, result: ViewResult) -> None:
        """Keeps a few of a view's points: the whole cloud is dropped."""
        step = _step(len(result.points), PAIR_POINTS)
        self._samples[result.view] = result.points[::step].copy()  # a slice would keep the whole cloud in memory

    def get_points(self, view: int) -> np.ndarray:
        """A few points (N, 3) of a view that was kept."""
        return self._samples[view]

    def log_truth(self, view: int, T_0_i: np.ndarray) -> None:
        """The true frustum, as a thin outline."""
        self._log_pose("truth", view, T_0_i, entities.TRUTH_COLOR, _TRUTH_WIDTH)

    def log_placed(self, method: Method, estimate: ViewEstimate) -> None:
        """Draw the frustum where a method puts it, if anywhere, with the status in words where that is not ok."""
        if estimate.T_0_i is None:
            return
        self._drawn[method, estimate.view] = estimate
        wrong = entities.status_color(estimate.status)
        color, width = (entities.METHOD_COLORS[method], _WIDTH) if wrong is None else (wrong, _FAILED_WIDTH)
        self._log_pose(method, estimate.view, estimate.T_0_i, color, width)
        points = self._samples[estimate.view]
        if wrong is not None and len(points):
            place = self._above(points) if self.scene.sensor is None else self.scene.sensor
            label = marks.draw_label(place, f"view {estimate.view}: {estimate.status}")
            self._stream.log(f"{entities.view_path(method, estimate.view)}/label", label)

    def log_cloud(self, method: Method, result: ViewResult, status: Status) -> None:
        """A view's points in its status's colour; where that is ok as captured, or in the view's own."""
        if not len(result.points):
            return
        self._clouds.add((method, result.view))
        step = 1 if method == self._best else _step(len(result.points), LESSER_POINTS)
        colors: entities.Color | np.ndarray
        if (color := entities.status_color(status)) is not None:
            colors = color
        elif result.colors is not None:
            colors = result.colors[::step]
        else:
            colors = entities.view_color(result.view, self._info.views)
        path = entities.cloud_path(method, result.view)
        self._stream.log(path, rr.Points3D(result.points[::step], colors=colors, radii=-1.5))

    def log_final(self, method: Method, found: MethodResult, stamps_ns: Mapping[int, int]) -> None:
        """Where a method puts the views when all is known, as far as that is not drawn yet."""
        for estimate in found.views:
            drawn, T = self._drawn.get((method, estimate.view)), estimate.T_0_i
            self.set_time(estimate.view, stamps_ns[estimate.view])
            if T is None:
                if drawn is not None or (method, estimate.view) in self._clouds:
                    self._stream.log(entities.view_path(method, estimate.view), rr.Clear(recursive=True))
                continue
            if _same(drawn, estimate):
                continue
            if drawn is not None and drawn.status != Status.OK == estimate.status:
                self._stream.log(f"{entities.view_path(method, estimate.view)}/label", rr.Clear(recursive=False))
            self.log_placed(method, estimate)
            self._color_cloud(method, estimate, again=drawn is not None and drawn.status != estimate.status)

    def log_edges(self, found: MethodResult, stamps_ns: Mapping[int, int]) -> None:
        """The edges of the graph."""
        drawn = marks.draw_edges(found.pairs, self.sensors(found.views), list(stamps_ns))
        for view, lines in drawn.items():
            self.set_time(view, stamps_ns[view])
            self._stream.log(f"/graph/view_{view:03d}", lines)

    def sensors(self, views: Sequence[ViewEstimate]) -> dict[int, np.ndarray]:
        """View -> where its frustum stands in frame {0}, (3,), or the middle of its cloud where that is unknown."""
        places = {}
        for view in views:
            points = self._samples[view.view]
            if view.T_0_i is not None and len(points):
                place = points.mean(axis=0) if self.scene.sensor is None else self.scene.sensor
                places[view.view] = poses.transform(view.T_0_i, place[None])[0]
        return places

    def log_matches(self, found: Correspondences) -> None:
        """The two clouds side by side, each about its own centre as its sensor saw it, and the matches across."""
        source, target = self._samples[found.source], self._samples[found.target]
        if not len(source) or not len(target):
            return
        path = f"/pairs/{found.target:03d}_{found.source:03d}"  # target first: view 17 registered to 16 is 016_017
        aside = np.array([0.65 * self.scene.diameter, 0.0, 0.0])
        to_right, to_left = aside - source.mean(axis=0), -aside - target.mean(axis=0)
        for name, points, view in (
            ("source", source + to_right, found.source),
            ("target", target + to_left, found.target),
        ):
            self._stream.log(f"{path}/{name}", rr.Points3D(points, colors=entities.PLAIN_COLOR, radii=-1.5))
            self._stream.log(f"{path}/{name}/label", marks.draw_label(self._above(points), f"view {view}"))
        lines = np.stack([found.source_points + to_right, found.target_points + to_left], axis=1)
        for name, keep, color, width in (
            ("matches", ~found.inlier, entities.BAD_COLOR, -0.35),
            ("inliers", found.inlier, entities.GOOD_COLOR, -0.9),
        ):
            self._stream.log(f"{path}/{name}", rr.LineStrips3D(lines[keep], colors=color, radii=width))
        words = f"{int(found.inlier.sum()):,} of {len(lines):,} matches are inliers"
        below = np.array([0.0, max((source + to_right)[:, 1].max(), (target + to_left)[:, 1].max()), 0.0])
        below[1] += 0.08 * self.scene.diameter
        self._stream.log(f"{path}/label", marks.draw_label(below, words))

    def _log_pose(self, method: str, view: int, T_0_i: np.ndarray, color: entities.Color, line_width: float) -> None:
        path = entities.view_path(method, view)
        self._stream.log(path, rr.Transform3D(translation=T_0_i[:3, 3], mat3x3=T_0_i[:3, :3]))
        if self.scene.sensor is None:
            return
        if self.scene.sensor.any():
            self._stream.log(f"{path}/camera", rr.Transform3D(translation=self.scene.sensor))
        frustum = rr.Pinhole(
            fov_y=0.7,
            aspect_ratio=4 / 3,
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=0.1 * self.scene.diameter,
            color=color,
            line_width=line_width,
        )
        self._stream.log(f"{path}/camera", frustum)

    def _color_cloud(self, method: Method, estimate: ViewEstimate, *, again: bool) -> None:
        """Colour a cloud by its status; one that stood nowhere when it came is drawn by a few of its points."""
        view, points = estimate.view, self._samples[estimate.view]
        color, path = entities.status_color(estimate.status), entities.cloud_path(method, view)
        if not len(points):
            return
        if again:  # its colours are those of another status
            color = color or entities.view_color(view, self._info.views)
        if (method, view) not in self._clouds:
            color = color or entities.view_color(view, self._info.views)
            self._stream.log(path, rr.Points3D(points, colors=color, radii=-1.5))
        elif color is not None:
            self._stream.log(path, rr.Points3D.from_fields(colors=color))

    def _above(self, points: np.ndarray) -> np.ndarray:
        """A place above points in a camera's frame, whose -y is up."""
        x, _, z = points.mean(axis=0)
        return np.array([x, points[:, 1].min() - 0.05 * self.scene.diameter, z])


def _step(count: int, wanted: int) -> int:
    return max(1, -(-count // wanted))


def _same(drawn: ViewEstimate | None, estimate: ViewEstimate) -> bool:
    """Whether a view is drawn where an estimate puts it, and as what."""
    if drawn is None or drawn.T_0_i is None or estimate.T_0_i is None:
        return False
    return drawn.status == estimate.status and np.array_equal(drawn.T_0_i, estimate.T_0_i)
