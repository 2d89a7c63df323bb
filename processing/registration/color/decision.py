"""What colours decide: which of the poses that explain the shapes of a pair explains its colours as well."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.kernels.blas import SingleThreaded
from orbitscan.processing.registration import verification
from orbitscan.processing.registration.color.alignment import align_by_color, measure_uncertainty
from orbitscan.processing.registration.color.candidates import approach, choose_likely, look_everywhere, tell_along
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.covisibility import Explanation
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.processing.results.estimates import PairEstimate, Symmetry
from orbitscan.processing.results.status import Status

COLOR = "color"  # the start of a pose that colours settled
AGAINST_COLOR = "its colours decide against the pose that its shape tells"
_DOUBTFUL = 30.0  # standard deviations by which the next candidate is worse: of a pose by less, colours are asked


@SingleThreaded()
def use_color(pair: PairRegistration, estimate: PairEstimate) -> PairEstimate:
    """Choose, of all that explains the shapes of an `ambiguous` pair, what explains its colours.

    A pose is chosen where it accounts for most of the contrast that both views show, and every other one that does so
    is worse by five standard deviations, as is what a lamp that stands still might pretend. As it is where none is.
    """
    T = estimate.T_target_source
    colors = ColorPair.of(pair) if estimate.status == Status.AMBIGUOUS else None
    if colors is None or T is None or not colors.is_patterned:
        return estimate
    if not all(tell_along(colors, T, freedom) for freedom in estimate.freedoms):
        return estimate
    here = pair.explain(T)
    likely, hopeless = choose_likely(colors, look_everywhere(colors, estimate))
    aligned = [align_by_color(colors, start) for start in approach(colors, likely, free=bool(estimate.freedoms))]
    told = [(end, colors.explain(end.T_target_source)) for end in aligned]
    standing = [
        (end, explained)
        for end, explained in told
        if pair.explain(end.T_target_source).worse_than(here) <= colors.refuted
        and colors.accounts_for_contrast(end.T_target_source, explained)
    ]
    if not standing:
        return estimate
    best, explained = min(standing, key=lambda found: found[1].misfit(colors.least))
    if _may_be_lamp(colors, best.T_target_source, explained):
        return estimate
    rivals = [
        (end.T_target_source, other.worse_than(explained))
        for end, other in standing
        if pair.distance(end.T_target_source, best.T_target_source) > 1.0
    ]
    others = [T for T, worse in rivals if worse <= colors.refuted]
    refuted = [worse for _, worse in rivals if worse > colors.refuted]
    seen = (colors.explain(T) for T in hopeless)
    refuted += [other.worse_than(explained) for other in seen if len(other.squares)][:1]
    return _settle(colors, estimate, best, explained, others, min(refuted, default=None))


@SingleThreaded()
def verify_color(pair: PairRegistration, estimate: PairEstimate) -> PairEstimate:
    """Return an estimate, as `inconsistent` if its shape tells it, not clearly, and its colours are against it."""
    T, margin = estimate.T_target_source, estimate.margin
    asked = estimate.status == Status.OK and estimate.start != COLOR and margin is not None and margin < _DOUBTFUL
    colors = ColorPair.of(pair) if asked else None
    if colors is None or T is None or not colors.contradicts(T):
        return estimate
    return replace(estimate, status=Status.INCONSISTENT, note=AGAINST_COLOR)


@SingleThreaded()
def doubt_color(pair: PairRegistration, estimate: PairEstimate, alike: Sequence[Symmetry]) -> PairEstimate:
    """Return an estimate that colours settled, `ambiguous` if its object's colours repeat themselves out of its sight.

    `alike` are turns (target's frame) that neither the object's shape nor its colours tell: a pair that does not show
    what they lead to says nothing against them.
    """
    colors, T = ColorPair.of(pair), estimate.T_target_source
    if estimate.start != COLOR or colors is None or T is None:
        return estimate
    told = colors.explain(T)

    def stands(turn: np.ndarray) -> bool:
        seen = colors.explain(turn @ T)
        return not len(seen.squares) or seen.worse_than(told) <= colors.refuted

    left = tuple(symmetry for symmetry in alike if all(map(stands, symmetry.turns())))
    return replace(estimate, status=Status.AMBIGUOUS, symmetries=left) if left else estimate


def _may_be_lamp(colors: ColorPair, T: np.ndarray, told: Explanation) -> bool:
    """Whether what stands still with the camera, a lamp or its shadows, explains colours as well as a pose does."""
    still = ((T, colors.explain_by_lamp(T)), (np.eye(4), colors.explain(np.eye(4))))
    return any(
        other.worse_than(told) <= colors.refuted and colors.accounts_for_most(where, other) for where, other in still
    )


def _settle(
    colors: ColorPair,
    estimate: PairEstimate,
    best: Refined,
    told: Explanation,
    others: Sequence[np.ndarray],
    margin: float | None,
) -> PairEstimate:
    """The estimate at the pose that colours tell; `ambiguous` where others stand, or it is known too badly."""
    pair, T = colors.pair, best.T_target_source
    found, motions = pair.verify(T), pair.find_motions(T)
    if verification.status_of(found, pair.settings.judgement) != Status.OK or (others and estimate.freedoms):
        return estimate
    known = measure_uncertainty(colors, best)
    is_good = known is not None and known.is_good(pair.diameter)
    evidence = pair.gather_evidence(best, found, motions, estimate.evidence)
    return replace(
        estimate,
        T_target_source=T,
        status=Status.OK if is_good and not others else Status.AMBIGUOUS,
        evidence=replace(evidence, color_misfit=float(np.sqrt(told.misfit(1.0)))),
        start=COLOR,
        information=best.information,
        center=best.center,
        freedoms=() if is_good else estimate.freedoms,
        symmetries=(),
        alternatives=tuple(others),
        margin=margin,
    ).with_uncertainty(known)
