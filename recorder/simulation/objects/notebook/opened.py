"""Notebooks that are open: flat with curved pages on both sides of the gutter, on a coil, or their cover ajar."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.notebook.paper import (
    CARD,
    PAPER,
    WIRES,
    bent,
    coil,
    cover_colors,
    level,
    page_size,
    ruled,
    stack,
    waves,
)
from orbitscan.recorder.simulation.objects.notebook.shut import spine
from orbitscan.recorder.simulation.objects.solids import box

LARGEST = 0.255  # of a page [m]; two halves of a larger one would be no thing for a table scanner


def open_flat(rng: np.random.Generator) -> Mesh:
    """A bound notebook lying open: the pages of either half rise from the gutter, arch and fall to their edge."""
    color, _ = cover_colors(rng)
    length, width = _portrait(rng)
    thickness, board, overhang = rng.uniform((0.004, 0.0006, 0), (0.028, 0.0030, 0.0040))
    corner, share = rng.uniform((0.001, 0.1), (0.010, 0.9))
    stiff = rng.uniform(0, 9) if rng.random() < 0.4 else 0.0  # degrees that either half rises from the gutter
    parts = []
    for side, part in ((1, share), (-1, 1 - share)):
        wave = waves(rng, length, width, rng.uniform(0, 0.004))
        cover = stack(length + 2 * overhang, level(side * (width + overhang), corner=corner), board, corner)
        profile = _dense(side * width, board)
        s = np.abs(profile[:, 0]) / width
        arch, reach = rng.uniform((0, 0.04), (0.009, 0.14))
        height = part * thickness * (1 - 0.25 * s) + arch * np.exp(-(((s - 2.2 * reach) / (2.5 * reach)) ** 2))
        height = 0.0012 + height * (1 - np.exp(-s / (0.6 * reach)))
        pages = ruled(stack(length, profile, height, 0.5 * corner, wave), rng)
        parts += [part.turned("x", side * stiff) for part in (cover.painted(color), pages)]
    if rng.random() < 0.35:
        parts.append(_leaf(rng, length, width, board + 0.0012))
    return merge(parts)


def open_coiled(rng: np.random.Generator) -> Mesh:
    """A notebook open on its coil, beside or above it: two stacks of leaves with the wire between."""
    color, _ = cover_colors(rng)
    above = rng.random() < 0.3
    length, width = _portrait(rng)
    if above:
        length, width = sorted(min(1, 0.16 / length) * np.array([length, width]))
    thickness, share = rng.uniform((0.004, 0.08), (0.020, 0.92))
    corner = rng.uniform(0.001, 0.010)
    radius = thickness / 2 + rng.uniform(0.002, 0.004)
    parts = [coil(rng, 0.95 * length, radius).moved(0, 0, 0.8 * radius).painted(WIRES[rng.integers(len(WIRES))])]
    for side, part, back in ((1, share, CARD), (-1, 1 - share, color)):
        wave = waves(rng, length, width, rng.uniform(0, 0.005))
        start, lift = 0.55 * side * radius, rng.uniform(0, 4)
        cover = stack(length, level(side * width, 0, start, corner), 0.001, corner, wave)
        leaves = stack(
            0.99 * length, level(side * (width - 0.002), 0.001, start, corner), part * thickness, corner, wave
        )
        parts += [piece.turned("x", side * lift) for piece in (cover.painted(back), ruled(leaves, rng))]
    book = merge(parts)
    return book.turned("z", -90) if above else book


def ajar(rng: np.random.Generator) -> Mesh:
    """A notebook whose cover stands open, straight or bent, with some leaves on their way after it."""
    color, trim = cover_colors(rng)
    length, width = page_size(rng, LARGEST)
    thickness, board, corner = rng.uniform((0.004, 0.0007, 0.001), (0.026, 0.0028, 0.010))
    opening = rng.uniform(8, 35) if rng.random() < 0.7 else rng.uniform(35, 75)
    curl = rng.uniform(-0.6, 0.4) * opening if board < 0.0016 else 0.0
    wave = waves(rng, length, width, rng.uniform(0, 0.004))
    pages = stack(length, level(width - 0.002, board, corner=corner), thickness, corner)
    lid = bent(width, np.array([opening - curl, opening + curl]), (0, board + thickness))
    parts = [
        stack(length, level(width, corner=corner), board, corner).painted(color),
        ruled(pages, rng),
        stack(length, lid, board, corner, wave).painted(color),
        spine(length, 2 * board + thickness, rng.uniform(0.001, 0.004)).painted(color),
    ]
    for slope in rng.uniform(0.1, 0.85, rng.integers(0, 4)) * opening:
        drop = rng.uniform(0, 1.2) * slope
        leaf = bent(width - 0.003, np.array([slope + 0.4 * drop, slope - drop]), (0.001, board + thickness))
        parts.append(stack(length, leaf, 0.0005, corner).painted(PAPER))
    if rng.random() < 0.4:
        parts.append(
            box(0.3 * length, 0.3 * width, 0.001).moved(0.2 * length, 0.6 * width, board + thickness).painted(trim)
        )
    return merge(parts)


def _portrait(rng: np.random.Generator) -> tuple[float, float]:
    """The height and width of a page no larger than fits on a table twice [m]."""
    width, height = sorted(page_size(rng, LARGEST))
    return height, width


def _dense(width: float, z: float) -> np.ndarray:
    """A flat profile with most of its points near the gutter."""
    y = width * np.linspace(0, 1, 20) ** 1.7
    return np.column_stack([y, np.full(20, z)])


def _leaf(rng: np.random.Generator, length: float, width: float, z: float) -> Mesh:
    """A leaf that does not lie down, on either side of the gutter."""
    start, end = rng.uniform((35, -40), (80, 10))
    leaf = stack(length, bent(width, np.array([start, 0.5 * (start + end), end]), (0, z)), 0.0005)
    return (leaf if rng.random() < 0.5 else leaf.turned("z", 180)).painted(PAPER)
