"""THE PAGE: the method of the thesis (chapters 3 and 4) and what we add to it, a named call for each step, in order.

Views come without poses, and ground truth never enters here: `pose_errors.with_errors` adds errors to what this yields.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import TYPE_CHECKING

from orbitscan.processing.reconstruction.coverage import measure_coverage
from orbitscan.processing.reconstruction.session_evidence import reconsider
from orbitscan.processing.reconstruction.trajectory import Hints, begin_trajectories
from orbitscan.processing.reconstruction.turntable import fit_turntable
from orbitscan.processing.registration.competition import verify_usual
from orbitscan.processing.registration.matching import Matched, choose_correspondences
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.results.estimates import MethodResult, PairEstimate
from orbitscan.processing.results.records import SessionResult, ViewRecord, ViewResult
from orbitscan.processing.results.status import METHODS, Method, Status, best_method
from orbitscan.processing.settings import Settings
from orbitscan.processing.steps import Steps
from orbitscan.processing.surface.preparation import choose_scale
from orbitscan.processing.timing import FEATURE_METHODS, SESSION, Stopwatch, total
from orbitscan.recorder.session import SessionInfo, View, Views

if TYPE_CHECKING:
    from orbitscan.processing.classification.classifier import Classifier


def process(
    views: Views,
    info: SessionInfo,
    settings: Settings | None = None,
    methods: Sequence[str] = METHODS,
    seed: int = 0,
    classifier: "Classifier | None" = None,
) -> Iterator[ViewResult | SessionResult]:
    """A ViewResult per view as soon as it is classified and placed, then exactly one SessionResult.

    Without a classifier nothing is classified. The same input, settings and seed give the same numbers to the last
    bit, whatever the number of threads.
    """
    settings, watch = settings or Settings(), Stopwatch(methods)
    scale = choose_scale(views, settings.surface)
    steps = Steps(scale, info, settings, seed, watch)
    described = partial(prepare_view, steps) if set(methods) & set(FEATURE_METHODS) else steps.prepare
    cache = ViewCache(views, described, steps.prepare, settings.surface.kept_views)
    trajectories = begin_trajectories(methods)
    records: list[ViewRecord] = []
    origin = None
    for view in views:
        with watch("classification", SESSION):
            shown = classifier.classify_view(view.index, view.points) if classifier else None  # (3.18) to (3.22)
        current = cache.put(view)  # steps 1 and 2
        poses, pairs = {}, {}
        matched: Matched = {}
        for method, trajectory in trajectories.items():
            if not current.surface.enough:
                poses[method] = trajectory.skip(view.index, Status.UNREADABLE if view.damage else Status.TOO_FEW_POINTS)
            elif trajectory.last is None:
                origin = view.index
                poses[method] = trajectory.start(current)
            else:
                attempt = partial(register, steps, method, matched, current)  # steps 3 to 5
                pairs[method], target = trajectory.attach(attempt)
                poses[method] = trajectory.extend(current, pairs[method], target)  # (4.17)
        result = ViewResult(
            view=view.index,
            name=view.name,
            stamp_ns=view.stamp_ns,
            points=current.surface.points,
            colors=current.surface.colors,
            keypoints=current.keypoints,
            correspondences=choose_correspondences(current, pairs, matched),
            pairs=pairs,
            poses=poses,
            seconds=watch.lap(),
            origin=origin,
            damage=view.damage,
            classification=shown,
        )
        records.append(ViewRecord.of(result))
        yield result
    found: dict[Method, MethodResult] = {}
    if Method.PAIRWISE in trajectories:
        known = trajectories[Method.PAIRWISE].result()  # where `refined` begins
        if "refined" in methods:
            anew = partial(register, steps, "refined", None)
            found[Method.REFINED] = steps.refine_jointly(known, cache, anew)
        found[Method.PAIRWISE] = reconsider(known, found.get(Method.REFINED), cache, settings.pair)
    best = best_method(methods)
    origin = found[best].origin if best in found else origin
    found |= {method: trajectory.result(origin) for method, trajectory in trajectories.items() if method not in found}
    placed = found[best].placed if best else {}
    model = steps.build_model(views, placed, best)  # 4.4
    turntable = fit_turntable(placed, settings.turntable)
    yield SessionResult.of(
        records,
        info=info,
        origin=origin,
        classification=classifier.fuse([r.classification for r in records if r.classification]) if classifier else None,
        reconstruction={method: found[method] for method in METHODS if method in methods},
        model=model,
        model_apart=steps.build_model(views, found[best].components.get(1, {}), best, meshed=False) if best else None,
        turntable=turntable,
        coverage=measure_coverage(placed, info.sensor_origin, model, turntable, settings.coverage),
        seconds=total([*(record.seconds for record in records), watch.lap()], methods, watch.elapsed),
        settings=asdict(settings),
        seed=seed,
    )


def prepare_view(steps: Steps, view: View) -> PreparedView:
    """Prepare a view's surface and, where it has points enough, its described keypoints."""
    if not (prepared := steps.find_self_turns(steps.prepare(view))).surface.enough:
        return prepared
    keypoints = steps.detect_keypoints(prepared)  # step 1: ISS (4.1)
    descriptors, frames = steps.describe(prepared, keypoints)  # step 2: SHOT (4.1)
    return replace(prepared, keypoints=keypoints, descriptors=descriptors, frames=frames)


def register(
    steps: Steps, method: str, matched: Matched | None, source: PreparedView, target: PreparedView, hints: Hints
) -> PairEstimate:
    """Register a pair by one method; `matched` keeps the source's matches for the methods after it."""
    pair, matched = PairRegistration(source, target, steps.settings.pair), {} if matched is None else matched
    if method == "icp":
        return steps.register_icp(pair)  # the baseline (5.2): ICP from the identity
    if target not in matched:
        indices = steps.match(pair)  # step 3: correspondences (4.2)
        matched[target] = Matches(indices, steps.estimate_pose(pair, indices))  # step 4: RANSAC, (4.8) to (4.22)
    if method == "ransac_icp":
        return steps.register_icp(pair, matched[target])  # step 5: ICP from the consensus (4.3)
    estimate = steps.register_competing(pair, matched[target], hints)  # ours, in the place of step 5
    return verify_usual(estimate, hints.usual, steps.settings.pair)
