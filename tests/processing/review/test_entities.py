"""Colours are legible on light and dark."""

import pytest

from orbitscan.processing.review import entities
from tests.processing.review.recordings import contrast


@pytest.mark.parametrize("color", [entities.FREE_COLOR, entities.TURNTABLE_COLOR])
def test_marks_are_legible_beside_the_object(color):
    assert contrast(color, entities.BACKGROUND) >= 4.5  # WCAG 2.1, 1.4.3: they are words too


@pytest.mark.parametrize("color", entities.METHOD_COLORS.values())
@pytest.mark.parametrize("background", [(255, 255, 255), (13, 13, 13), entities.BACKGROUND])
def test_methods_are_legible_on_light_and_dark(color, background):
    assert contrast(color, background) >= 3  # WCAG 2.1, 1.4.11
