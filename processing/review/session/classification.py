"""What a session's views show: curves of probabilities, the answer in words, views that say otherwise."""

from collections.abc import Iterator, Sequence

import rerun as rr

from orbitscan.processing.results.classification import SessionClassification, ViewClassification
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.review import entities
from orbitscan.processing.review.curves import Style, Value
from orbitscan.processing.review.markdown import enumerate_some, enumerate_views, name_view, plural

SHOWN_PROBABILITY = 0.05  # a category that stays below is only in the way
_TRUE_WIDTH, _OTHER_WIDTH = 4.0, 1.5


def probability_values(found: ViewClassification) -> Iterator[Value]:
    """The probability of each category by a view alone."""
    for category, probability in found.probabilities.items():
        yield f"/classification/{category}", probability


def fused_values(found: SessionClassification) -> dict[int, list[Value]]:
    """View -> probabilities and their entropy, fused over the views up to it."""
    return {
        view.view: [
            *((f"/classification/fused/{category}", p) for category, p in probabilities.items()),
            ("/classification/entropy", entropy),
        ]
        for view, probabilities, entropy in zip(found.views, found.fused, found.entropy, strict=True)
    }


def shown_categories(found: SessionClassification, truth: str | None) -> list[str]:
    """The categories whose curves are looked at: true, likeliest, and those that reach SHOWN_PROBABILITY anywhere."""
    rows = [*(view.probabilities for view in found.views), *found.fused]
    wanted = {truth, found.likeliest}
    return [c for c in found.categories if c in wanted or any(row[c] >= SHOWN_PROBABILITY for row in rows)]


def choose_styles(categories: Sequence[str], truth: str | None) -> dict[str, Style]:
    """Curve -> its style: a colour per category, the true one's curves are thick."""
    styles: dict[str, Style] = {"/classification/entropy": (entities.ENTROPY_COLOR, "entropy", 2.0)}
    for number, category in enumerate(categories):
        style = entities.category_color(number), category, _TRUE_WIDTH if category == truth else _OTHER_WIDTH
        styles |= {f"/classification/{category}": style, f"/classification/fused/{category}": style}
    return styles


def describe_classification(result: SessionResult) -> str:
    """The answer and whether it is right, then the views that alone say otherwise, worst first, and the unknown ones.

    As Markdown; empty where nothing was classified.
    """
    found = result.classification
    if found is None:
        return ""
    text = f"**{conclude(found, result.info.category)}**"
    other, unknown = _dissenters(found, result.info.category)
    if other:
        said = enumerate_some([f"{view.view} ({describe_view(view)})" for view in other])
        text += f" Alone, {plural(len(other), 'view')} {said} {'says' if len(other) == 1 else 'say'} otherwise."
    if unknown:
        views = enumerate_views([view.view for view in unknown])
        text += f" Alone, {plural(len(unknown), 'view')} {views} would be unknown."
    return text


def conclude(found: SessionClassification, truth: str | None = None) -> str:
    """One sentence: what it is, how sure that is, and, where the true category is known, whether it is right."""
    count = len(found.views)
    likeliest = found.likeliest.replace("_", " ")
    over = f"fused over {count} views" if count > 1 else "by one view"
    if found.known:
        text = (
            f"It is {'an' if likeliest[:1].lower() in 'aeiou' else 'a'} {likeliest} ({found.probability:.0%}, {over})"
        )
    else:
        text = f"It is unknown: likeliest {likeliest} {found.probability:.0%}, {over}"
    if not truth:
        return text + "."
    if truth not in found.categories:
        verdict = "wrong" if found.known else "right"
        return f"{text}; the recording says {truth}, which the model does not know: {verdict}."
    if found.category is None and found.likeliest == truth:
        return f"{text}; the recording says {truth}: not recognised, but the likeliest."
    return f"{text}; the recording says {truth}: {'right' if found.category == truth else 'wrong'}."


def list_dissent(result: SessionResult) -> Iterator[tuple[int, rr.TextLogLevel, str]]:
    """(view, level, text) of the views that alone say otherwise, or do not know the object though together they do."""
    found = result.classification
    if found is None:
        return
    names = dict(zip(result.views_used, result.view_names, strict=True))
    other, unknown = _dissenters(found, result.info.category)
    expected = _expected(found, result.info.category) or "unknown"
    instead = f"{expected}, as the {'recording says' if result.info.category else 'views together say'}"
    for view in sorted((*other, *unknown), key=lambda view: view.view):
        subject = name_view(view.view, names[view.view])
        level = rr.TextLogLevel.WARN if view.known else rr.TextLogLevel.INFO
        yield view.view, level, f"{subject}, classification: alone it shows {describe_view(view)}, not {instead}"


def describe_view(found: ViewClassification) -> str:
    """`coffee_mug 97%`, or `unknown (bowl 41%)`."""
    likeliest = f"{found.likeliest} {found.probabilities[found.likeliest]:.0%}"
    return likeliest if found.known else f"unknown ({likeliest})"


def _dissenters(
    found: SessionClassification, truth: str | None
) -> tuple[list[ViewClassification], list[ViewClassification]]:
    """Views that name another category, worst first, and those that name none where one is expected."""
    expected = _expected(found, truth)
    other = [view for view in found.views if view.known and view.category != expected]
    if expected is None:
        other.sort(key=lambda view: -view.score)
        return other, []
    other.sort(key=lambda view: (view.probabilities[expected], view.view))
    return other, [view for view in found.views if not view.known]


def _expected(found: SessionClassification, truth: str | None) -> str | None:
    """The right answer: the true category where that is on record, else the fused one; None for unknown."""
    return found.category if not truth else truth if truth in found.categories else None
