"""Each view in one colour: by its error where the truth is known, else by its confidence; and the scale of colours."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.results.estimates import MethodResult
from orbitscan.processing.review import entities
from orbitscan.processing.review.markdown import number

# From little to much, after ColorBrewer's RdYlBu: the colour-blind tell them apart
_RAMP = np.array([(80, 130, 235), (150, 205, 225), (255, 240, 150), (252, 150, 85), (225, 45, 40)], float)
ERROR_STEPS_MM = (0.01, 0.1, 1.0, 10.0, 100.0)  # the same in every session, so that colours compare
CONFIDENCE_STEPS = (1.0, 0.75, 0.5, 0.25, 0.0)


@dataclass(frozen=True)
class Shading:
    """Views' colours, and the scale that tells what they mean, from little to much."""

    quantity: str  # `error` or `confidence`
    meaning: str
    colors: Mapping[int, entities.Color]
    scale: tuple[tuple[entities.Color, str], ...]


def shade_views(found: MethodResult) -> Shading | None:
    """The shading of a method's views; None where neither an error nor a confidence of any is known."""
    errors = {v.view: v.errors.center_error_m for v in found.views if v.errors.center_error_m is not None}
    if errors:
        places = {view: np.log10(max(1e3 * error, 1e-12)) for view, error in errors.items()}
        stops, words = np.log10(ERROR_STEPS_MM), [f"{number(step)} mm" for step in ERROR_STEPS_MM]
        quantity, meaning = "error", "error of the object's centre"
    else:
        places = {view: -pair.confidence for view, pair in found.speaking.items()}
        stops, words = -np.array(CONFIDENCE_STEPS), [number(step) for step in CONFIDENCE_STEPS]
        quantity, meaning = "confidence", "confidence (no ground truth)"
    if not places:
        return None
    colors = {view.view: entities.PLAIN_COLOR for view in found.views}
    colors |= {view: _blend(place, stops) for view, place in places.items()}
    scale = tuple((_blend(stop, stops), word) for stop, word in zip(stops, words, strict=True))
    if colors.keys() - places.keys():
        scale = (*scale, (entities.PLAIN_COLOR, "unknown"))
    return Shading(quantity, meaning, colors, scale)


def _blend(place: float, stops: np.ndarray) -> entities.Color:
    r, g, b = (round(float(np.interp(place, stops, channel))) for channel in _RAMP.T)
    return r, g, b
