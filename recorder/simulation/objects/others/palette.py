"""Colours of household things."""

import numpy as np

Color = tuple[int, int, int]

WHITE, CREAM, GREY, BLACK = (236, 234, 228), (226, 212, 182), (140, 144, 150), (60, 60, 64)
RED, ORANGE, YELLOW, GREEN = (192, 52, 46), (226, 128, 46), (232, 194, 62), (70, 136, 82)
BLUE, SKY, PURPLE, PINK = (46, 90, 162), (112, 164, 206), (122, 82, 140), (218, 138, 150)
STEEL, BRASS, WOOD, CRUST = (176, 180, 186), (190, 160, 90), (178, 132, 84), (164, 106, 58)
_BRIGHT = (WHITE, CREAM, GREY, BLACK, RED, ORANGE, YELLOW, GREEN, BLUE, SKY, PURPLE, PINK)


def colors(rng: np.random.Generator, count: int) -> tuple[Color, ...]:
    """So many different colours, in which packages and plastics come."""
    return tuple(_BRIGHT[i] for i in rng.permutation(len(_BRIGHT))[:count])
