"""Views coloured by error, or by confidence where no truth is known, and the scale that tells what colours mean."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from orbitscan.processing.results.estimates import Evidence, MethodResult, PairEstimate, ViewErrors, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.review import entities
from orbitscan.processing.review.session.shading import shade_views
from tests.processing.review.recordings import contrast


def views_off_by(*errors_m):
    """Views with these errors of the object's centre; None where it is unknown."""
    return tuple(
        ViewEstimate(i, Status.OK, np.eye(4), errors=ViewErrors(center_error_m=error))
        for i, error in enumerate(errors_m)
    )


def warmth(color):
    return color[0] - color[2]


def test_colours_tell_errors_in_millimetres_the_same_in_every_session():
    shading = shade_views(MethodResult(views_off_by(0.0, 1e-5, 1e-3, 0.1, 7.0, None), ()))
    assert shading.quantity == "error"
    of_scale = {words: color for color, words in shading.scale}
    assert list(of_scale) == ["0.01 mm", "0.1 mm", "1 mm", "10 mm", "100 mm", "unknown"]
    expected = ("0.01 mm", "0.01 mm", "1 mm", "100 mm", "100 mm", "unknown")
    assert [shading.colors[view] for view in range(6)] == [of_scale[words] for words in expected]
    assert shade_views(MethodResult(views_off_by(1e-3), ())).colors[0] == shading.colors[2]


def test_the_larger_the_error_the_warmer():
    errors = np.geomspace(1e-5, 0.1, 30)
    colors = shade_views(MethodResult(views_off_by(*errors), ())).colors
    warm = [warmth(colors[view]) for view in range(30)]
    assert all(a < b for a, b in pairwise(warm[:22]))  # then from orange to red
    assert all(contrast(color, entities.BACKGROUND) > 1.3 for color in colors.values())


def test_without_truth_colours_tell_confidence_and_say_so():
    pairs = tuple(PairEstimate(i, 0, np.eye(4), Status.OK, c, Evidence()) for i, c in ((1, 1.0), (2, 0.5), (3, 0.0)))
    shading = shade_views(MethodResult.of(views_off_by(*[None] * 4), pairs, None))
    assert (shading.quantity, shading.meaning) == ("confidence", "confidence (no ground truth)")
    of_scale = {words: color for color, words in shading.scale}
    assert list(of_scale) == ["1", "0.75", "0.5", "0.25", "0", "unknown"]
    assert [shading.colors[view] for view in range(4)] == [of_scale[words] for words in ("unknown", "1", "0.5", "0")]
    doubted = (*pairs[1:], replace(pairs[0], confidence=0.2))
    assert warmth(shade_views(MethodResult.of(views_off_by(*[None] * 4), doubted, None)).colors[1]) > warmth(
        of_scale["0.5"]
    )


@pytest.mark.parametrize("views", [(), views_off_by(None)])
def test_where_nothing_is_known_nothing_is_coloured(views):
    assert shade_views(MethodResult(views, ())) is None
