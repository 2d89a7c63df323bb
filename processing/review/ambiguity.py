"""What a method leaves open: free motions, symmetries, views apart; and what colours or the user's step settled."""

from collections.abc import Iterator

from orbitscan.processing.results.estimates import Freedom, MethodResult, PairEstimate, Symmetry
from orbitscan.processing.results.status import Status
from orbitscan.processing.review.markdown import enumerate_views

SETTLED_BY = {"color": "colours", "step": "the user's step"}  # the starts of pairs that shape left open


def find_freedoms(found: MethodResult) -> tuple[tuple[Freedom, ...], bool]:
    """The motions that nothing determines, and whether they are in frame {0}.

    A method without a graph knows those of its pairs alone: they are the first ambiguous view's, in its target's frame.
    """
    if found.freedoms:
        return found.freedoms, True
    return next((pair.freedoms for pair in _ambiguous_pairs(found) if pair.freedoms), ()), False


def find_symmetries(found: MethodResult) -> tuple[tuple[Symmetry, ...], bool]:
    """The turns that change nothing, and whether they are in frame {0}; as `find_freedoms`."""
    if found.symmetries:
        return found.symmetries, True
    return next((pair.symmetries for pair in _ambiguous_pairs(found) if pair.symmetries), ()), False


def tell_apart(found: MethodResult) -> Iterator[str]:
    """Which views hold together though nothing holds them to view {0}: a clause for each such group."""
    for component, views in found.components.items():
        model = " (model_component_1.ply)" if component == 1 else ""
        yield f"views {enumerate_views([*views])} hold together, but nothing holds them to the others{model}"


def list_ambiguous(found: MethodResult) -> list[int]:
    """The views that are ambiguous."""
    return [view.view for view in found.views if view.status == Status.AMBIGUOUS]


def leaves_open(pair: PairEstimate) -> bool:
    """Whether other poses explain a pair's views as well."""
    return bool(pair.freedoms or pair.symmetries or pair.alternatives)


def is_open(found: MethodResult) -> bool:
    """Whether other poses explain any of the views as well."""
    repeats = any(not symmetry.told_by_color for symmetry in found.symmetries)
    return bool(found.freedoms) or repeats or any(map(leaves_open, _ambiguous_pairs(found)))


def list_settled(found: MethodResult) -> dict[str, list[int]]:
    """The views whose pairs shape left open, by what settled them, in words."""
    views = {
        words: [view for view, pair in found.speaking.items() if pair.start == start and pair.status == Status.OK]
        for start, words in SETTLED_BY.items()
    }
    return {words: settled for words, settled in views.items() if settled}


def _ambiguous_pairs(found: MethodResult) -> list[PairEstimate]:
    return [found.speaking[view] for view in list_ambiguous(found) if view in found.speaking]
