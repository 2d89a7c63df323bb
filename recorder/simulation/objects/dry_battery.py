"""Dry batteries in the sizes of IEC 60086: round cells, packs of them in film, 9 V, 4.5 V and lantern blocks."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import (
    circle,
    cylinder,
    loft,
    prism,
    revolve,
    rounded_rectangle,
    sweep,
)

SEGMENTS = 48
CELLS = {  # least and largest of diameter, length, nub's diameter, nub's height [m]
    "AAA": ((0.0098, 0.0435, 0.0034, 0.0008), (0.0105, 0.0445, 0.0038, 0.0013)),
    "AA": ((0.0137, 0.0495, 0.0048, 0.0010), (0.0145, 0.0505, 0.0055, 0.0017)),
    "C": ((0.0252, 0.0488, 0.0062, 0.0015), (0.0262, 0.0500, 0.0075, 0.0024)),
    "D": ((0.0325, 0.0597, 0.0078, 0.0015), (0.0342, 0.0615, 0.0095, 0.0028)),
}
STEEL, BRASS, BLACK, WHITE = (184, 186, 190), (188, 160, 96), (42, 42, 46), (230, 230, 226)
COPPER, GOLD, GREEN, RED, BLUE, SILVER = (
    (186, 108, 62),
    (206, 168, 78),
    (38, 128, 72),
    (186, 38, 40),
    (36, 78, 156),
    (170, 174, 180),
)
LABELS = (
    (COPPER, BLACK),
    (BLACK, GOLD),
    (GREEN, GOLD),
    (RED, WHITE),
    (BLUE, SILVER),
    (BLACK, RED),
    (WHITE, BLUE),
    (SILVER, GREEN),
)


def build(rng: np.random.Generator) -> Mesh:
    """A battery, standing (plus up) or lying along x (plus towards +x); instances differ in kind, size and label."""
    kind = ("AAA", "AA", "C", "D", "pack", "nine_volt", "flat", "lantern")[
        rng.choice(8, p=(0.08, 0.18, 0.13, 0.18, 0.13, 0.14, 0.06, 0.10))
    ]
    label = LABELS[rng.integers(len(LABELS))]
    if kind in CELLS:
        battery = _cell(rng, kind, label).turned("z", rng.uniform(0, 360))
        standing = rng.random() < (0.5 if kind in ("C", "D") else 0.25)
    else:
        make = {"pack": _pack, "nine_volt": _nine_volt, "flat": _flat, "lantern": _lantern}[kind]
        battery = make(rng, label)
        standing = rng.random() < {"lantern": 0.8, "pack": 0.3}.get(kind, 0.5)
        battery = battery.turned("z", 180 * int(rng.integers(2)) + (0 if standing or rng.random() < 0.75 else 90))
    return battery if standing else battery.turned("y", 90)


def _cell(rng: np.random.Generator, size: str, label: tuple, segments: int = SEGMENTS) -> Mesh:
    """A round cell standing on its minus pole: crimped rims, a band of the label's second colour, the nub on top."""
    diameter, length, nub, nub_height = rng.uniform(*CELLS[size])
    r, s, top = diameter / 2, nub / 2, length - nub_height
    rim = rng.uniform(0.03, 0.09) * r
    band, width = rng.uniform(0.05, 0.85), rng.uniform(0.1, 0.4)
    body = np.linspace(2 * rim, top - 2 * rim, 16)
    profile = [
        (0, 0),
        (0.72 * r, 0),
        (0.76 * r, 0.6 * rim),
        (0.86 * r, 0.6 * rim),
        (0.9 * r, 0),
        (r - rim, 0),
        (r, rim),
    ]
    profile += [(r, z) for z in body]
    profile += [
        (r, top - rim),
        (r - rim, top),
        (0.86 * r, top),
        (0.8 * r, top - 0.8 * rim),
        (s + 0.1 * r, top - 0.8 * rim),
    ]
    profile += [(s, top), (s, length - 0.0003), (s - 0.0003, length), (0, length)]
    mesh = revolve(np.array(profile), segments)
    share = (mesh.vertices[:, 2] - body[0]) / np.ptp(body)
    banded = ((share > band) & (share < band + width))[:, None]
    colors = np.where(banded, np.array(label[1]), np.array(label[0]))
    colors[(np.hypot(*mesh.vertices.T[:2]) < 0.93 * r)] = STEEL
    return Mesh(mesh.vertices, mesh.triangles, colors.astype(np.uint8))


def _pack(rng: np.random.Generator, label: tuple) -> Mesh:
    """Two cells (seldom three or four) side by side along y, all one way or in turns, held by film or a strip."""
    size = tuple(CELLS)[rng.choice(4, p=(0.2, 0.4, 0.2, 0.2))]
    count = int(rng.choice((2, 3, 4), p=(0.7, 0.1, 0.2)))
    state = rng.integers(2**32)
    cells = [_cell(np.random.default_rng(state), size, label, 2 * SEGMENTS // count) for _ in range(count)]
    (width, _, length), turns = np.ptp(cells[0].vertices, axis=0), rng.random() < 0.4
    if turns:
        cells = [cell.turned("x", 180).moved(z=length) if i % 2 else cell for i, cell in enumerate(cells)]
    square = count == 4 and rng.random() < 0.6
    grid = [(i % 2, i // 2) if square else (0, i) for i in range(count)]
    centers = width * (np.array(grid) - np.mean(grid, axis=0))
    deep, across = np.ptp(centers, axis=0) + width + 0.0006
    share = rng.uniform(0.35, 0.98)
    film = prism(rounded_rectangle(deep, across, 0.499 * width, 12), share * length, 0.0005)
    film = film.moved(z=rng.uniform(0.2, 0.8) * (1 - share) * length).painted(label[rng.integers(2)])
    return merge([film, *(cell.moved(x, y) for cell, (x, y) in zip(cells, centers, strict=True))])


def _nine_volt(rng: np.random.Generator, label: tuple) -> Mesh:
    """A 9 V block, its wide side to the front: rims at both ends, the round plus snap and the flared minus snap."""
    depth, width, height = rng.uniform((0.0158, 0.0250, 0.0450), (0.0172, 0.0264, 0.0464))
    block = _block(rng, (depth, width, height), rng.uniform(0.0018, 0.0035), label, end=STEEL)
    r, h = rng.uniform((0.0027, 0.0020), (0.0031, 0.0028))
    stud = revolve(
        np.array([(0, -0.001), (1.1 * r, -0.001), (r, 0.0004), (r, h - 0.0004), (r - 0.0004, h), (0, h)]), 32
    )
    crown = [
        (0, -0.001),
        (1.25 * r, -0.001),
        (1.2 * r, 0.3 * h),
        (1.5 * r, h),
        (1.25 * r, h),
        (r, 0.4 * h),
        (0, 0.4 * h),
    ]
    side = rng.choice((-1, 1)) * 0.00635  # snaps are 12.7 mm apart
    snaps = [stud.moved(y=side, z=height), revolve(np.array(crown), 24).moved(y=-side, z=height)]
    return merge([block, *(snap.painted(STEEL) for snap in snaps)])


def _flat(rng: np.random.Generator, label: tuple) -> Mesh:
    """A flat 4.5 V block, its wide side to the front: on top a short brass strip and a long one, bent over."""
    depth, width, height = rng.uniform((0.0200, 0.0600, 0.0610), (0.0220, 0.0620, 0.0650))
    block = _block(rng, (depth, width, height), rng.uniform(0.004, 0.0105), label, end=BLACK)
    parts = [block]
    outline = rounded_rectangle(0.006, 0.0005, 0.0002, 2)
    for place, reach in ((0.38, rng.uniform(0.012, 0.018)), (-0.38, rng.uniform(0.026, 0.040))):
        rise, back = rng.uniform(0.002, 0.006), -np.sign(place)
        path = [
            (0, 0, -0.002),
            (0, 0, 0.6 * rise),
            (0, 0.3 * back * rise, rise),
            (0, back * reach, rise + rng.uniform(0, 0.004)),
        ]
        parts.append(sweep(outline, np.array(path), up=(1, 0, 0)).moved(y=place * width, z=height).painted(BRASS))
    return merge(parts)


def _lantern(rng: np.random.Generator, label: tuple) -> Mesh:
    """A 6 V lantern block: square, rounded edges, a lid, on top two conical springs or two screw knobs."""
    side, height = rng.uniform((0.0650, 0.095), (0.0670, 0.102))
    block = _block(rng, (side, side * rng.uniform(0.985, 1.0), height), rng.uniform(0.005, 0.013), label, end=BLACK)
    springs, rise = rng.random() < 0.7, rng.uniform(0.006, 0.014)
    diagonal = rng.uniform(0.13, 0.20) * side * np.array([1, 1])  # one pole in the middle, the other in a corner
    parts = [block]
    for x, y in (0.3 * diagonal, -1.5 * diagonal):
        part = _spring(rng, rise).painted(STEEL) if springs else cylinder(0.0055, 0.6 * rise, 0.001, 24).painted(BLACK)
        parts.append(part.moved(x, y, height - 0.001))
    return merge(parts)


def _spring(rng: np.random.Generator, height: float) -> Mesh:
    """A conical spring of three turns, standing."""
    along = np.linspace(0, 1, 60)
    radius, angles = rng.uniform(0.008, 0.011) * (1 - 0.65 * along), 6 * np.pi * along
    path = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), height * along])
    return sweep(circle(0.0006, 6), path)


def _block(rng: np.random.Generator, sides: tuple, radius: float, label: tuple, end: tuple) -> Mesh:
    """A box with rounded upright edges, standing: the rims at both ends project a little, a band about the label."""
    depth, width, height = sides
    outline = rounded_rectangle(depth, width, radius)
    inset, rim, bevel = rng.uniform(0.0001, 0.0006), rng.uniform(0.001, 0.05 * height), rng.uniform(0.0004, 0.0012)
    levels = [
        (bevel, 0),
        (0, bevel),
        (0, rim),
        *((inset, z) for z in np.linspace(rim + 0.0003, height - rim - 0.0003, 12)),
    ]
    levels += [(0, height - rim), (0, height - bevel), (bevel, height)]
    rings = [
        np.column_stack([outline * (1 - 2 * cut / np.array([depth, width])), np.full(len(outline), z)])
        for cut, z in levels
    ]
    mesh = loft(np.array(rings))
    z = mesh.vertices[:, 2]
    low, wide = rng.uniform(0.1, 0.6) * height, rng.uniform(0.15, 0.4) * height
    colors = np.where(((z > low) & (z < low + wide))[:, None], np.array(label[1]), np.array(label[0]))
    colors[(z <= rim) | (z >= height - rim)] = end
    return Mesh(mesh.vertices, mesh.triangles, colors.astype(np.uint8))
