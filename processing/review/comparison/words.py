"""A comparison in words: the verdict in a sentence, rows of what changed, a session's comparison as Markdown."""

from collections import Counter
from collections.abc import Iterable, Sequence

from orbitscan.processing.results.comparison.records import (
    Comparison,
    Difference,
    SessionComparison,
    Verdict,
    ViewComparison,
)
from orbitscan.processing.review.markdown import enumerate_some, in_mm, number, plural, write_table

NAMED = 5  # sessions that a sentence names
ARROW = " → "
FLOOR_WORDS = (
    "Floors: the change over what may be chance. That is two standard deviations of the difference of two estimates, "
    "each as well known as the overlap of the views, its residual and its shape allow, but no less than the 95 % "
    "bounds of both together where both tell them. Views that are not ok are compared by their status alone."
)
SESSION_HEADER = ("session", "verdict", "worse", "changed", "better", "not ok", "taken for", "seconds")
METHOD_HEADER = ("method", "not ok", "largest centre error [mm]", "seconds")
BRIEF_HEADER = ("view", "method", "verdict", "status", "largest change", "floors")
VIEW_HEADER = ("view", "method", "verdict", "status", "transl. [mm]", "chordal", "centre [mm]", "moved [mm]", "floors")

_ERRORS = {  # name -> in words, its factor to the unit shown, the unit
    "translation_error_m": ("translation", 1e3, " mm"),
    "rotation_error_chordal": ("chordal", 1.0, ""),
    "center_error_m": ("centre", 1e3, " mm"),
}
_VERBS: dict[Verdict, str] = {"worse": "worse", "better": "better", "changed": "other, neither better nor worse,"}


def conclude(found: Comparison) -> str:
    """One sentence: where B is worse, or that it is nowhere, and what else there is to know."""
    if len(found.sessions) == 1 and not found.only_a and not found.only_b:
        return conclude_session(found.sessions[0])
    total = len(found.sessions)
    parts = [
        f"{verb} in {len(sessions)} of {total} sessions: {enumerate_some([s.name for s in sessions], NAMED)}"
        for verdict, verb in _VERBS.items()
        if (sessions := found.count(verdict))
    ]
    if not found.count("worse"):
        parts.insert(0, f"nowhere worse than A in {total} {plural(total, 'session')}")
    text = "B is " + "; ".join(parts)
    if found.only_a:
        text += f". B lacks {len(found.only_a)} session(s) of A: {enumerate_some(found.only_a, NAMED)}"
    if found.only_b:
        text += f". In B only: {enumerate_some(found.only_b, NAMED)}"
    return text + "."


def conclude_session(session: SessionComparison) -> str:
    """One sentence about one session."""
    if session.identical:
        return f"{session.name}: A and B are the same, nothing changed."
    totals = Counter(view.method for view in session.views)
    parts = []
    for verdict, words in _VERBS.items():
        counts = Counter(view.method for view in session.views if view.verdict == verdict)
        of = [f"{counts[m]} of {totals[m]} views by {m}" for m in reversed(totals) if counts[m]]
        if session.category is not None and session.category.verdict == verdict:
            of.append(f"what it is taken for ({session.category.a}{ARROW}{session.category.b})")
        if of:
            parts.append(f"{words} in {', '.join(of)}")
    if not parts:
        judged, views = sum(view.floor_m is not None for view in session.views), len(session.views)
        least = "" if judged == views else f" (views that are ok in both: {judged} of {views})"
        same = "B is as good as A: nothing changed by more than chance"
        return f"{session.name}: {same}, by {', '.join(totals)}{least}."
    if session.verdict != "worse":
        parts.insert(0, "nowhere worse")
    return f"{session.name}: B is " + "; ".join(parts) + "."


def session_rows(sessions: Iterable[SessionComparison]) -> list[tuple[str, ...]]:
    """The cells of SESSION_HEADER: of each session its counts, by all methods, and A → B of the best method in both."""
    rows = []
    for session in sessions:
        totals = list(session.methods.values())[-1]
        rows.append(
            (
                session.name,
                session.verdict,
                *(str(session.count(verdict) or "") for verdict in ("worse", "changed", "better")),
                _change(*map(str, totals.failed)),
                "" if session.category is None else _change(session.category.a, session.category.b),
                _both(totals.seconds),
            )
        )
    return rows


def method_rows(session: SessionComparison) -> list[tuple[str, ...]]:
    """The cells of METHOD_HEADER, the best method first."""
    return [
        (method, _change(*map(str, totals.failed)), _both(totals.center_error_m, 1e3), _both(totals.seconds))
        for method, totals in reversed(list(session.methods.items()))
    ]


def view_rows(views: Iterable[ViewComparison]) -> list[tuple[str, ...]]:
    """The cells of VIEW_HEADER."""
    return [
        (
            *_name(view),
            _cell(view.errors.get("translation_error_m"), 1e3),
            _cell(view.errors.get("rotation_error_chordal")),
            _cell(view.errors.get("center_error_m"), 1e3),
            in_mm(view.moved_m),
            _floors(view),
        )
        for view in views
    ]


def brief_rows(views: Iterable[ViewComparison]) -> list[tuple[str, ...]]:
    """The cells of BRIEF_HEADER, for a terminal: of the errors the one that changed most, in floors."""
    return [(*_name(view), _largest(view), _floors(view)) for view in views]


def describe_session(session: SessionComparison, most: int) -> str:
    """The summary of a session as Markdown: the verdict, what else differs, methods, and the changes, worst first."""
    lines = [f"## {session.name}: A and B", "", f"**{conclude_session(session)}**", ""]
    lines += [f"- {note}" for note in session.notes]
    lines += ["", *write_table(METHOD_HEADER, method_rows(session)), ""]
    changed = session.changed_views
    if changed:
        lines += ["### What changed, worst first", "", *write_table(VIEW_HEADER, view_rows(changed[:most])), ""]
        if len(changed) > most:
            lines += [f"And {len(changed) - most} more.", ""]
    return "\n".join([*lines, FLOOR_WORDS])


def list_notes(sessions: Sequence[SessionComparison]) -> list[str]:
    """What else differs than the outcome; in a batch once, with the number of sessions it holds for."""
    counts = Counter(note for session in sessions for note in session.notes)
    if len(sessions) == 1:
        return list(counts)
    return [f"{note} ({count} of {len(sessions)} sessions)" for note, count in counts.most_common()]


def _change(a: str, b: str) -> str:
    return a if a == b else f"{a}{ARROW}{b}"


def _both(values: tuple[float, float] | None, factor: float = 1.0) -> str:
    return "" if values is None else _change(*(number(factor * value) for value in values))


def _name(view: ViewComparison) -> tuple[str, ...]:
    """The cells that both headers of views begin with."""
    return str(view.view), view.method, view.verdict, _change(view.status_a, view.status_b)


def _floors(view: ViewComparison) -> str:
    return f"{view.size:.1f}" if view.floor_m is not None else ""


def _largest(view: ViewComparison) -> str:
    if view.errors:
        name, changed = max(view.errors.items(), key=lambda item: (item[1].verdict == view.verdict, item[1].size))
        words, factor, unit = _ERRORS[name]
        return f"{words} {_both((changed.a, changed.b), factor)}{unit}"
    return "" if view.moved_m is None else f"moved {in_mm(view.moved_m)} mm"


def _cell(difference: Difference | None, factor: float = 1.0) -> str:
    if difference is None:
        return ""
    return _both((difference.a, difference.b), factor) + (" !" if difference.verdict == "worse" else "")
