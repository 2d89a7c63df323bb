"""Notebooks that are shut: hard and soft covers, coils along a side or the top, pads."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.notebook.paper import (
    BLACK,
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
from orbitscan.recorder.simulation.objects.solids import box, loft


def hard_cover(rng: np.random.Generator) -> Mesh:
    """A bound notebook between boards that stand out a little, some with an elastic band or a label."""
    color, trim = cover_colors(rng)
    length, width = page_size(rng)
    thickness, board, overhang = rng.uniform((0.006, 0.0015, 0.0015), (0.030, 0.0030, 0.0040))
    corner = rng.uniform(0.001, 0.010)
    long, wide, top = length + 2 * overhang, width + overhang, board + thickness
    warp = waves(rng, long, wide, rng.uniform(0, 0.003))
    parts = [
        stack(long, level(wide, corner=corner), board, corner).painted(color),
        stack(length, level(width - 0.001, board), thickness, 0.5 * corner).painted(PAPER),
        stack(long, bent(wide, np.array([0, rng.uniform(0, 2.5)]), (0, top)), board, corner, warp).painted(color),
        spine(long, top + board, rng.uniform(0.001, 0.006)).painted(color if rng.random() < 0.7 else trim),
        *_label(rng, long, wide, top + board + 0.001, trim),
    ]
    if rng.random() < 0.4:
        band = box(long + 0.0016, 0.006, top + board + 0.003).moved(0, 0.86 * wide, -0.0008)
        parts.append(band.painted(trim))
    return _put_down(rng, merge(parts))


def soft_cover(rng: np.random.Generator) -> Mesh:
    """A thin stapled or sewn notebook: pinched at its spine, its cover lifted and waved, all of it bent a little."""
    color, trim = cover_colors(rng)
    length, width = page_size(rng)
    thickness, bow, lift = rng.uniform((0.002, -0.010, 0), (0.012, 0.010, 7))
    corner = rng.uniform(0.0005, 0.012)
    profile = level(width, corner=corner)
    pinch = np.interp(profile[:, 0] / width, [0, 0.08, 0.3, 1], [0.35, 0.7, 1, 1])
    wave = waves(rng, length, width, rng.uniform(0, 0.006))

    def rise(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return wave(x, y) + bow * (1 - (2 * x / length) ** 2)

    lid = bent(width, np.array([4, 0, lift * rng.uniform(0, 0.5), lift]), (0, 0.0007 + 0.35 * thickness))
    lid[:, 1] += 0.65 * thickness * np.interp(lid[:, 0] / width, [0, 0.3, 1], [0, 1, 1])
    parts = [
        stack(length, level(width, corner=corner), 0.0007, corner, rise).painted(color),
        stack(length, profile + np.array([0, 0.0007]), thickness * pinch, corner, rise).painted(PAPER),
        stack(length, lid, 0.0008, corner, rise).painted(color),
    ]
    if rng.random() < 0.5:
        strip = level(0.14 * width, 0.0016 + 0.4 * thickness, -0.0006)
        parts.append(stack(1.001 * length, strip, 0.45 * thickness, 0, rise).painted(trim))
    return _put_down(rng, merge(parts))


def coiled(rng: np.random.Generator) -> Mesh:
    """A notebook on a coil along its side or its top; its cover is shut, lifted a little or folded behind."""
    color, trim = cover_colors(rng)
    length, width = page_size(rng)
    above = rng.random() < 0.35
    if above:
        length, width = width, length
    thickness, cover, lift = rng.uniform((0.004, 0.0006, 0), (0.024, 0.0016, 5))
    corner = rng.uniform(0.001, 0.012)
    wave = waves(rng, length, width, rng.uniform(0, 0.004))
    radius = (thickness + 2 * cover) / 2 + rng.uniform(0.0015, 0.0035)
    top = level(width, cover + thickness, corner=corner)
    lid = bent(width, np.array([0, 0, lift]), (0, cover + thickness))
    folded = rng.random() < 0.25
    pages = stack(length * 0.995, level(width - 0.002, cover, 0.001, corner), thickness, corner, wave)
    parts = [
        stack(length, level(width, corner=corner), cover, corner, wave).painted(color if folded else CARD),
        ruled(pages, rng) if folded else pages.painted(PAPER),
        coil(rng, 0.95 * length, radius).moved(0, 0.004 - 0.35 * radius, cover + thickness / 2).painted(_wire(rng)),
    ]
    if not folded:
        parts.append(stack(length, lid if lift > 1.5 else top, cover, corner, wave).painted(color))
        parts += _label(rng, length, width, thickness + 2 * cover + 0.001, trim)
    book = merge(parts)
    return _put_down(rng, book.turned("z", -90) if above else book)


def pad(rng: np.random.Generator) -> Mesh:
    """A pad glued at its top under a band; its upper leaves bend up at a corner or along the lower edge."""
    color, _ = cover_colors(rng)
    width, length = page_size(rng)
    thickness, curl, steep = rng.uniform((0.003, 0, 2), (0.024, 0.022, 5))
    side = rng.choice([-1, 0, 1])

    def corner_up(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        along = np.clip(y / width, 0, 1)
        across = np.ones_like(x) if side == 0 else np.clip(0.5 + side * x / length, 0, 1)
        return curl * (along * across) ** steep

    grown = level(width, 0.001 + thickness)
    grown = np.column_stack([np.linspace(0, width, 24), np.full(24, grown[0, 1])])
    band = rng.uniform(0.008, 0.035)
    leaves = stack(length, grown, 0.0012, 0, corner_up)
    parts = [
        stack(length, level(width), 0.001).painted(CARD),
        stack(length, level(width, 0.001), thickness).painted(PAPER),
        ruled(leaves, rng) if rng.random() < 0.8 else leaves.painted(color),
        stack(1.002 * length, level(band, 0, -0.0006), thickness + 0.003).painted(color),
    ]
    return _put_down(rng, merge(parts).turned("z", -90))


def spine(length: float, height: float, depth: float) -> Mesh:
    """A rounded back, standing out by `depth` towards -y from the z axis [m]."""
    turn = np.linspace(np.pi / 2, 3 * np.pi / 2, 17)
    y, z = depth * np.cos(turn) + 0.001, height * (0.5 + 0.5 * np.sin(turn))
    return loft(np.stack([np.column_stack([np.full(17, x), y, z]) for x in (-length / 2, length / 2)]))


def _label(
    rng: np.random.Generator, length: float, width: float, top: float, color: tuple[int, int, int]
) -> list[Mesh]:
    """A label on the cover, or none."""
    if rng.random() < 0.5:
        return []
    size = rng.uniform(0.15, 0.4, 2) * (length, width)
    x, y = rng.uniform(-0.25, 0.05) * length, 0.5 * width
    return [box(size[0], size[1], 0.0016).moved(x, y, top - 0.0016).painted(color if rng.random() < 0.5 else PAPER)]


def _wire(rng: np.random.Generator) -> tuple[int, int, int]:
    """The colour of a coil."""
    return (*WIRES, BLACK)[rng.integers(len(WIRES) + 1)]


def _put_down(rng: np.random.Generator, book: Mesh) -> Mesh:
    """The notebook as it lies: flat, now and then not quite."""
    tilt = 4.0 if rng.random() < 0.2 else 0.6
    return book.turned("y", rng.uniform(-tilt, tilt)).turned("x", rng.uniform(-tilt, tilt))
