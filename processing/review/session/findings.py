"""What is not in order, a line each: views that are not ok and why, pairs that the graph leaves out."""

from collections.abc import Iterator, Sequence

import numpy as np
import rerun as rr

from orbitscan.processing.results.edges import Disagreement, left_out
from orbitscan.processing.results.estimates import Candidate, PairEstimate, ViewEstimate
from orbitscan.processing.results.records import SessionResult, ViewResult
from orbitscan.processing.results.status import Method, Status
from orbitscan.processing.review.ambiguity import SETTLED_BY, leaves_open
from orbitscan.processing.review.markdown import (
    describe_bounds,
    describe_freedom,
    describe_symmetry,
    in_mm,
    name_view,
    number,
)
from orbitscan.recorder import poses

SAME = 1e-6  # degrees: errors that differ by less are equal


def list_findings(result: ViewResult, methods: Sequence[Method]) -> Iterator[tuple[rr.TextLogLevel, str]]:
    """(level, text) of all that is not in order with a view: an error where it is not placed, else a warning."""
    subject = name_view(result.view, result.name)
    if result.damage:
        yield rr.TextLogLevel.ERROR, f"{subject}: {result.damage}"
    for method, estimate in result.poses.items():
        if method in methods and estimate.status != Status.OK:
            yield _level(estimate), f"{subject}, {method}: {explain(estimate, result.pairs.get(method))}"


def list_joint_findings(result: SessionResult) -> Iterator[tuple[int, rr.TextLogLevel, str]]:
    """(view, level, text) of what `refined` finds not in order: views, and edges that it leaves out, a line each."""
    found = result.reconstruction.get(Method.REFINED)
    if found is None:
        return
    names = dict(zip(result.views_used, result.view_names, strict=True))
    for estimate in found.views:
        if estimate.status not in (Status.OK, Status.UNREADABLE):  # that has been said
            subject = name_view(estimate.view, names[estimate.view])
            why = explain(estimate, found.speaking.get(estimate.view))
            yield estimate.view, _level(estimate), f"{subject}, refined: {why}"
    for pair, disagreement in left_out(found):
        yield pair.source, rr.TextLogLevel.WARN, f"refined: {explain_left_out(pair, disagreement)}"


def explain_left_out(pair: PairEstimate, disagreement: Disagreement | None) -> str:
    """Why the graph does not believe a pair."""
    text = f"pair {pair.source} to {pair.target} is left out"
    if disagreement is None:
        return f"{text}: no other pairs connect it to view {{0}}, or they contradict it"
    off = f"{number(disagreement.degrees)}° and {in_mm(disagreement.metres)} mm"
    return f"{text}: the others contradict it by {off} ({describe_evidence(pair)})"


def explain(estimate: ViewEstimate, pair: PairEstimate | None) -> str:
    """Why a view is not ok: its status in words, the evidence of the pair that placed it, how each start fared."""
    text = describe_status(estimate, pair)
    if estimate.T_0_i is None:
        text += ", not placed"
    if estimate.note and estimate.status != Status.INCONSISTENT:
        text += f". {write_clause(estimate.note)}"
    if pair is None:
        return text
    text += f". Against view {pair.target}: {describe_evidence(pair)}"
    text += "".join(f". {sentence}" for sentence in describe_ambiguity(pair))
    if (observable := observable_error(pair)) is not None:
        raw = pair.errors.rotation_error_deg
        text += f". Off by {number(raw)}°, by {number(observable)}° with that granted"
    if pair.candidates:
        text += f". Starts: {describe_starts(pair)}"
    return text


def describe_starts(pair: PairEstimate) -> str:
    """What became of the starts, best first, those of one fate together."""
    fates: dict[str, list[str]] = {}
    for start, fate in list_starts(pair):
        fates.setdefault(fate, []).append(f"{start.start} (score {number(start.score)})")
    return "; ".join(f"{', '.join(starts)} {fate}" for fate, starts in fates.items())


def describe_status(estimate: ViewEstimate, pair: PairEstimate | None) -> str:
    """A view's status, and in words what it means where it is not ok; the pair is that which speaks for it."""
    status = estimate.status
    if status == Status.OK:
        return status
    if status == Status.INCONSISTENT and estimate.note:
        return f"{status}: {write_clause(estimate.note)}"
    return f"{status}: {known}" if (known := _known_too_badly(estimate, pair)) else f"{status} ({status.meaning})"


def describe_ambiguity(pair: PairEstimate) -> Iterator[str]:
    """The motions that a pair leaves free, other poses of it as good, how far the next is behind, what settled it."""
    if pair.freedoms:
        yield "Free: " + ", ".join(map(describe_freedom, pair.freedoms))
    if pair.symmetries:
        yield "Symmetric: " + "; ".join(map(describe_symmetry, pair.symmetries))
    if pair.alternatives and pair.T_target_source is not None:
        turns = [f"{_angle_between(pair.T_target_source, T):.0f}°" for T in pair.alternatives]
        yield f"As good when turned by {', '.join(turns)}"
    if pair.margin is not None:
        yield f"The next candidate explains the views worse by {number(pair.margin)} standard deviations"
    if pair.start in SETTLED_BY:
        yield f"Placed by {SETTLED_BY[pair.start]}"


def list_starts(pair: PairEstimate) -> Iterator[tuple[Candidate, str]]:
    """The starts that competed for a pair, best first, and what became of each: chosen, or why it lost."""
    for start in pair.candidates:
        reason = start.status.meaning
        if start.start == pair.start:
            yield start, "was chosen" if start.status == Status.OK else f"was chosen all the same: {reason}"
        elif start.status == Status.OK:
            yield start, "would hold too, but the surfaces agree less" if pair.start else "would hold"
        else:
            yield start, f"lost: {reason}"


def describe_evidence(pair: PairEstimate) -> str:
    """A pair's evidence in words: from many points to few inliers, then overlap and residual, with units."""
    e = pair.evidence
    counts = [
        (e.points, "points"), (e.keypoints, "keypoints"), (e.valid_frames, "with a frame"),
        (e.matches, "matches"), (e.inliers, "inliers"),
    ]  # fmt: skip
    parts = [" → ".join(f"{count:,} {noun}" for count, noun in counts if count is not None)]
    if e.overlap is not None:
        parts.append(f"overlap {e.overlap:.0%}")
    if e.rmse_m is not None:
        parts.append(f"residual {in_mm(e.rmse_m)} mm")
    if e.color_misfit is not None:
        parts.append(f"colours {number(e.color_misfit)} standard deviations apart")
    if e.violations:
        parts.append(f"{e.violations:.1%} in front of what the other view saw")
    if e.unseen:
        parts.append(f"{e.unseen:.1%} that the other sensor should see and does not")
    return ", ".join(parts)


def observable_error(pair: PairEstimate) -> float | None:
    """The pair's rotation error with its free motions granted; None where that is the raw one or unknown."""
    raw, granted = pair.errors.rotation_error_deg, pair.errors.rotation_error_deg_observable
    return None if raw is None or granted is None or abs(raw - granted) < SAME else granted


def write_clause(note: str) -> str:
    """A sentence without its full stop."""
    return note.rstrip(".")


def _known_too_badly(estimate: ViewEstimate, pair: PairEstimate | None) -> str | None:
    """How far off an ambiguous view may be whose pair leaves nothing open; None for all others."""
    if estimate.status != Status.AMBIGUOUS or (pair is not None and leaves_open(pair)):
        return None
    for known in (estimate, pair):
        if known is not None and known.status == Status.AMBIGUOUS:
            degrees, metres = known.rotation_bound_deg, known.center_bound_m
            if degrees is not None and metres is not None:
                return f"known only {describe_bounds(degrees, metres)}"
    return None


def _level(estimate: ViewEstimate) -> rr.TextLogLevel:
    return rr.TextLogLevel.ERROR if estimate.T_0_i is None else rr.TextLogLevel.WARN


def _angle_between(T_a: np.ndarray, T_b: np.ndarray) -> float:
    return float(np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3])))
