"""A view's story: what became of it, from its points to the overlap, its starts, errors and pairs; in words, tables."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from orbitscan.processing.results.classification import ViewClassification
from orbitscan.processing.results.estimates import PairEstimate, ViewEstimate, speaking_pairs
from orbitscan.processing.results.records import ViewResult
from orbitscan.processing.results.status import METHODS, Method, Status
from orbitscan.processing.review.markdown import count, describe_bounds, in_mm, name_view, number, percent, write_table
from orbitscan.processing.review.session import findings
from orbitscan.processing.review.session.classification import describe_view


@dataclass(frozen=True)
class Seen:
    """What is kept of a view for its story."""

    view: int
    name: str
    points: int  # recorded
    damage: str | None
    classification: ViewClassification | None
    matched: tuple[int, int, int] | None  # the view whose matches are drawn, how many they are, how many are inliers

    @classmethod
    def of(cls, result: ViewResult) -> Self:
        """What is kept of a result."""
        drawn = result.correspondences
        matched = (drawn.target, len(drawn.inlier), int(drawn.inlier.sum())) if drawn is not None else None
        return cls(result.view, result.name, len(result.points), result.damage, result.classification, matched)


def tell(
    seen: Seen,
    estimates: Mapping[Method, ViewEstimate],
    pairs: Mapping[Method, Sequence[PairEstimate]],
    *,
    finished: bool,
) -> str:
    """The story as Markdown; by method where it puts the view, and the pairs that the view is the source or target of.

    `finished`: whether all that will be known is known.
    """
    methods = [method for method in reversed(METHODS) if method in estimates]
    placing = {
        m: speaking_pairs([p for p in pairs.get(m, ()) if p.source == seen.view]).get(seen.view) for m in methods
    }
    lines = [f"## {name_view(seen.view, seen.name).capitalize()}", "", *_conclude(seen, methods, estimates, placing)]
    if any(placing.values()):
        lines += ["", "### From points to overlap", "", *_funnel(methods, placing)]
    if any(estimates[method].errors.translation_error_m is not None for method in methods):
        lines += ["", "### Errors against the ground truth", "", *_errors(methods, estimates, placing)]
    compete = [(method, pair) for method in methods if (pair := placing[method]) and pair.candidates]
    if compete:
        method, pair = max(compete, key=lambda of_method: len(of_method[1].candidates))
        lines += ["", f"### Starts that competed, {method}, against view {pair.target}", ""]
        rows = [[start.start, number(start.score), fate] for start, fate in findings.list_starts(pair)]
        lines += write_table(["start", "score, at most 1", "what became of it"], rows)
    if others := [pair for pair in pairs.get(Method.REFINED, ()) if pair is not placing.get(Method.REFINED)]:
        lines += ["", "### Its other pairs in the graph", "", *_others(seen.view, others)]
    if seen.classification is not None:
        lines += ["", f"Alone it shows {describe_view(seen.classification)}."]
    if seen.matched is not None:
        target, matches, inliers = seen.matched
        lines += ["", f"The tab Matches draws it beside view {target}: {inliers:,} of {matches:,} matches are inliers."]
    if not finished:
        lines += ["", "The session is not finished: this is what was known when the view came."]
    return "\n".join(lines)


def _conclude(
    seen: Seen,
    methods: Sequence[Method],
    estimates: Mapping[Method, ViewEstimate],
    placing: Mapping[Method, PairEstimate | None],
) -> Iterator[str]:
    """The best method's word first, then those of others that say something else."""
    if seen.damage:
        yield f"**Not readable:** {seen.damage}."
    else:
        yield f"{seen.points:,} points."
    if not methods:
        return
    best, *lesser = methods
    estimate, pair = estimates[best], placing[best]
    status = findings.describe_status(estimate, pair)
    text = f"**{best}: {status}{'; not placed' if estimate.T_0_i is None else ''}.**"
    if estimate.note and estimate.status != Status.INCONSISTENT:
        text += f" {findings.write_clause(estimate.note)}."
    degrees, metres = estimate.rotation_bound_deg, estimate.center_bound_m
    if estimate.status == Status.OK and pair is not None and degrees is not None and metres is not None:
        text += f" Known {describe_bounds(degrees, metres)}."
    if pair is not None:
        text += f" Against view {pair.target}, confidence {number(pair.confidence)}."
        text += "".join(f" {sentence}." for sentence in findings.describe_ambiguity(pair))
    elif estimate.T_0_i is not None and np.allclose(estimate.T_0_i, np.eye(4), atol=1e-9):
        text += " All others are placed in its frame."
    yield from ("", text)
    if lesser:
        said = [f"{m} {findings.describe_status(estimates[m], placing[m])}" for m in lesser]
        yield from ("", f"The others: {'; '.join(said)}.")


def _funnel(methods: Sequence[Method], placing: Mapping[Method, PairEstimate | None]) -> list[str]:
    rows = []
    for method in methods:
        if (pair := placing[method]) is not None:
            e = pair.evidence
            counts = (e.points, e.keypoints, e.valid_frames, e.matches, e.inliers)
            shares = (percent(e.overlap), in_mm(e.rmse_m), number(e.misfit), percent(e.violations), percent(e.unseen))
            rows.append([method, pair.status, f"{pair.target}", *map(count, counts), *shares])
    header = ["by", "its pair is", "against view", "points", "keypoints", "valid frames", "matches", "inliers"]
    header += ["overlap", "residual [mm]", "misfit [σ]", "in front", "unseen"]
    return write_table(header, rows)


def _errors(
    methods: Sequence[Method], estimates: Mapping[Method, ViewEstimate], placing: Mapping[Method, PairEstimate | None]
) -> list[str]:
    rows = []
    for method in methods:
        errors, pair = estimates[method].errors, placing[method]
        of_pose = [in_mm(errors.translation_error_m), number(errors.rotation_error_chordal)]
        of_pose += [number(errors.rotation_error_deg), in_mm(errors.center_error_m)]
        of_pair = (
            (number(pair.errors.rotation_error_deg), number(findings.observable_error(pair))) if pair else ("", "")
        )
        rows.append([method, *of_pose, *of_pair])
    header = ["by", "translation [mm]", "chordal [0 to 2.83]", "angle [deg]", "centre [mm]"]
    return write_table([*header, "its pair [deg]", "observable [deg]"], rows)


def _others(view: int, pairs: Sequence[PairEstimate]) -> list[str]:
    rows = []
    for pair in sorted(pairs, key=lambda pair: (pair.status == Status.OK, -pair.confidence)):
        e = pair.evidence
        held = "left out: the others contradict it" if pair.status == Status.INCONSISTENT else pair.status
        other = pair.target if pair.source == view else pair.source
        rows.append([f"{other}", percent(e.overlap), in_mm(e.rmse_m), number(pair.confidence), held])
    return write_table(["with view", "overlap", "residual [mm]", "confidence", "status"], rows)
