"""Results in words: the log lines of a view, a session's summary (what is wrong, worst first), its table."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import rerun as rr

from processing.results.records import Evidence, MethodResult, PairEstimate, SessionResult, ViewEstimate, ViewResult

WORDS = {
    "ambiguous": "several poses explain it equally well, or its surface slides along the earlier view",
    "too_few_points": "too few points to register",
    "too_few_keypoints": "too little structure for keypoints",
    "too_few_matches": "too few descriptors match",
    "no_consensus": "no motion explains enough of the matches",
    "diverged": "the refinement ran away",
    "low_overlap": "too little of the surface lies on the earlier view",
    "inconsistent": "a surface is seen through another",
    "not_connected": "no pair connects it to the other views",
    "unreadable": "its recorded cloud is damaged",
}
SHOWN_FAILURES = 10
LEGEND = "Frusta: grey by the ground truth, coloured as estimated. Red: views that are not ok, wrong matches, outliers."


def write_unfinished(name: str) -> str:
    """What stands in place of the summary until the session is done, and for ever if the run is killed."""
    return f"## {name}\n\nNot finished: the views so far are complete, the summary and the model are still missing."


def list_findings(result: ViewResult) -> Iterator[tuple[str, str]]:
    """(level, text) of all that is not in order with a view: an error where it is not placed, else a warning."""
    subject = _subject(result.view, result.name)
    if result.damage:
        yield rr.TextLogLevel.ERROR, f"{subject}: {result.damage}"
    for method, estimate in result.poses.items():
        if estimate.status != "ok":
            level = rr.TextLogLevel.ERROR if estimate.T_0_i is None else rr.TextLogLevel.WARN
            yield level, f"{subject}, {method}: {explain(estimate, result.pairs.get(method))}"


def explain(estimate: ViewEstimate, pair: PairEstimate | None) -> str:
    """Why a view is not ok: its status in words, the evidence of the pair that placed it, how each start fared."""
    text = f"{estimate.status} ({WORDS.get(estimate.status, 'see the evidence')})"
    if estimate.T_0_i is None:
        text += ", not placed"
    if pair is None:
        return text
    text += f". Against view {pair.target}: {describe_evidence(pair)}"
    if pair.candidates:
        text += ". Starts: " + ", ".join(f"{c.start} {c.status} (score {c.score:.3g})" for c in pair.candidates)
    return text


def describe_evidence(pair: PairEstimate) -> str:
    """From many points to few inliers, then overlap and residual, with units."""
    e = pair.evidence
    counts = [
        (e.points, "points"), (e.keypoints, "keypoints"), (e.valid_frames, "with a frame"),
        (e.matches, "matches"), (e.inliers, "inliers"),
    ]  # fmt: skip
    parts = [" → ".join(f"{count:,} {noun}" for count, noun in counts if count is not None)]
    if e.overlap is not None:
        parts.append(f"overlap {e.overlap:.0%}")
    if e.rmse_m is not None:
        parts.append(f"residual {_mm(e.rmse_m)} mm")
    return ", ".join(parts)


def conclude(result: SessionResult, method: str) -> str:
    """One line: how many views a method places, which not, and how far off the worst one is."""
    views = result.reconstruction[method].views
    failed = [view.view for view in views if view.status != "ok"]
    text = f"{method} places {len(views) - len(failed)} of {len(views)} views with confidence"
    text += f"; not ok: {', '.join(map(str, failed))}." if failed else "."
    off = {v.view: v.errors.center_error_m for v in views if v.errors.center_error_m is not None}
    if off:
        worst = max(off, key=off.__getitem__)
        text += f" The object's centre is at most {_mm(off[worst])} mm off the ground truth, in view {worst}."
    return text


def summarize(result: SessionResult, methods: Sequence[str]) -> str:
    """The summary as Markdown; `methods` from worst to best."""
    best = methods[-1]
    found = result.reconstruction[best]
    lines = [f"## {result.info.name}", "", f"**{conclude(result, best)}**", "", *_tabulate_methods(result, methods), ""]
    if failed := _worst_first(found):
        names = dict(zip(result.views_used, result.view_names, strict=True))
        pairs = {pair.source: pair for pair in found.pairs}
        lines += ["### What is wrong, worst first", ""]
        for estimate in failed[:SHOWN_FAILURES]:
            why = result.unreadable.get(estimate.view) or explain(estimate, pairs.get(estimate.view))
            lines.append(f"- **{_subject(estimate.view, names[estimate.view])}**: {why}")
        if len(failed) > SHOWN_FAILURES:
            lines.append(f"- and {len(failed) - SHOWN_FAILURES} more: see the log")
        lines.append("")
    lines.append(LEGEND)
    if model := result.model:
        lines.append(f"Model: {len(model.points):,} points by {model.method}, {len(model.removed):,} outliers removed.")
    if "total" in result.seconds:
        lines.append(f"Processing took {result.seconds['total']:.1f} s.")
    return "\n".join(lines)


def tabulate_views(result: SessionResult, methods: Sequence[str]) -> str:
    """A row per view as a Markdown table: status, errors and evidence of the best method, the others' statuses."""
    *lesser, best = methods
    pairs = {pair.source: pair for pair in result.reconstruction[best].pairs}
    statuses = {method: {v.view: v.status for v in result.reconstruction[method].views} for method in lesser}
    names = dict(zip(result.views_used, result.view_names, strict=True))
    rows = []
    for estimate in result.reconstruction[best].views:
        errors, pair = estimate.errors, pairs.get(estimate.view)
        e = pair.evidence if pair else Evidence()
        rows.append(
            [
                f"{estimate.view}",
                estimate.status,
                _mm(errors.translation_error_m),
                _number(errors.rotation_error_chordal),
                _mm(errors.center_error_m),
                _percent(e.overlap),
                _mm(e.rmse_m),
                *(_count(n) for n in (e.points or None, e.keypoints, e.valid_frames, e.matches, e.inliers)),
                *(statuses[method].get(estimate.view, "") for method in lesser),
                names[estimate.view],
            ]
        )
    header = ["view", "status", "translation [mm]", "chordal", "centre [mm]", "overlap", "residual [mm]"]
    header += ["points", "keypoints", "frames", "matches", "inliers", *lesser, "name"]
    return "\n".join([f"Status, errors and evidence of {best}.", "", *_markdown_table(header, rows)])


def _tabulate_methods(result: SessionResult, methods: Sequence[str]) -> list[str]:
    header = ["method", "views not ok", "overlap, median", "residual, median [mm]"]
    header += ["translation error, max [mm]", "chordal, max", "centre, max [mm]"]
    rows = []
    for method in reversed(methods):
        found = result.reconstruction[method]
        largest = found.summary.get
        rows.append(
            [
                method,
                f"{found.failed_views} of {len(found.views)}",
                _percent(_median(pair.evidence.overlap for pair in found.pairs)),
                _mm(_median(pair.evidence.rmse_m for pair in found.pairs)),
                _mm(largest("max_translation_error_m")),
                _number(largest("max_rotation_error_chordal")),
                _mm(largest("max_center_error_m")),
            ]
        )
    return _markdown_table(header, rows)


def _worst_first(found: MethodResult) -> list[ViewEstimate]:
    confidence = {pair.source: pair.confidence for pair in found.pairs}
    failed = [view for view in found.views if view.status != "ok"]
    return sorted(failed, key=lambda v: (v.T_0_i is not None, confidence.get(v.view, 0.0), v.view))


def _markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Its lines; a column without any content is left out."""
    columns = [column for column in zip(header, *rows, strict=True) if any(column[1:])]
    title, *content = zip(*columns, strict=True)
    return ["| " + " | ".join(cells) + " |" for cells in (title, ["---"] * len(title), *content)]


def _subject(view: int, name: str) -> str:
    return f"view {view}" if name in ("", f"view_{view:03d}") else f"view {view} ({name})"


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _mm(metres: float | None) -> str:
    return _number(None if metres is None else 1e3 * metres)


def _number(value: float | None) -> str:
    """Three digits; what is below a millionth is rounding."""
    if value is None:
        return ""
    return "0" if abs(value) < 1e-6 else f"{value:.3g}"


def _count(value: int | None) -> str:
    return "" if value is None else f"{value:,}"


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0%}"
