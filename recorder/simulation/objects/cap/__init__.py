"""Caps as they lie on a table: a crown of six panels with a button, a brim, a strap behind; new, flat, floppy, worn."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.cap.crown import Crown
from orbitscan.recorder.simulation.objects.cap.parts import brim, emblem, eyelets, shell, strap
from orbitscan.recorder.simulation.objects.solids import ellipsoid

NAVY, RED, BLACK, GREEN = (44, 56, 98), (182, 48, 46), (62, 62, 66), (62, 104, 78)
KHAKI, WHITE, GREY, ORANGE, SKY = (188, 168, 128), (234, 232, 224), (136, 140, 146), (226, 132, 50), (104, 152, 200)
CLOTHS = (NAVY, RED, BLACK, GREEN, KHAKI, WHITE, GREY, ORANGE, SKY)


def build(rng: np.random.Generator) -> Mesh:
    """A baseball cap about 27 cm long; instances differ in crown, brim, emblem and cloths."""
    crown = Crown(*rng.uniform((0.092, 0.074, 0.102, 0.55, 0.016), (0.102, 0.084, 0.124, 0.80, 0.036)))
    main, second, accent = (CLOTHS[i] for i in rng.permutation(len(CLOTHS))[:3])
    front = accent if rng.random() < 0.3 else main
    trim = second if rng.random() < 0.7 else main
    return merge(
        [
            shell(crown, main, front),
            brim(crown, rng.uniform(0.064, 0.078)).painted(trim),
            ellipsoid(0.0075, 0.0075, 0.004, 16).moved(z=crown.height + 0.001).painted(second),
            emblem(rng, crown).painted(second if front == WHITE else WHITE),
            strap(crown).painted(trim),
            *(part.painted(second) for part in eyelets(crown)),
        ]
    )


def flat_brim(rng: np.random.Generator) -> Mesh:
    """A cap with a flat, square brim before a high, boxy crown."""
    crown = Crown(
        *rng.uniform((0.090, 0.074, 0.105, 0.48, 0.0, 0.12), (0.104, 0.088, 0.132, 0.70, 0.008, 0.24)),
        arch=rng.choice([0.0, 0.30]),
    )
    crown = crown.dented(rng, rng.integers(0, 3), (0.003, 0.012))
    rise, curl, square = rng.uniform((-0.010, 0, 2.4), (0.012, 0.003, 3.6))
    return _rest(_sewn(rng, crown, brim(crown, rng.uniform(0.062, 0.080), rise, curl, square)))


def trucker(rng: np.random.Generator) -> Mesh:
    """A trucker's cap: foam panels stand high in front, mesh behind sinks in."""
    crown = Crown(
        *rng.uniform((0.092, 0.076, 0.118, 0.50, 0.008, 0.24), (0.106, 0.090, 0.146, 0.74, 0.034, 0.38)), arch=0.28
    )
    crown = crown.dented(rng, rng.integers(1, 4), (0.004, 0.022))
    rise, curl = rng.uniform((-0.016, 0), (0.008, 0.016))
    return _rest(_sewn(rng, crown, brim(crown, rng.uniform(0.062, 0.078), rise, curl), foam=True))


def floppy(rng: np.random.Generator) -> Mesh:
    """A cap without stiffening that has fallen in: low, its crown and sides dented, its brim bent any way."""
    crown = Crown(*rng.uniform((0.088, 0.072, 0.070, 0.60, 0.006, 0.02), (0.108, 0.094, 0.112, 0.95, 0.036, 0.14)))
    crown = crown.dented(rng, 1, (0.020, 0.034)).dented(rng, rng.integers(3, 7), (0.008, 0.026))
    rise, curl = rng.uniform((-0.026, 0), (0.014, 0.026))
    return _rest(_sewn(rng, crown, brim(crown, rng.uniform(0.056, 0.076), rise, curl)))


def worn(rng: np.random.Generator) -> Mesh:
    """A cap worn for years: its brim is bent into half a tube and carries it, its crown has dents."""
    crown = Crown(*rng.uniform((0.090, 0.072, 0.092, 0.55, 0.026, 0.06), (0.104, 0.086, 0.124, 0.85, 0.048, 0.18)))
    crown = crown.dented(rng, rng.integers(1, 5), (0.005, 0.022))
    rise, curl = rng.uniform((-0.030, 0.010), (0.004, 0.036))
    return _rest(_sewn(rng, crown, brim(crown, rng.uniform(0.062, 0.080), rise, curl)))


def short_visor(rng: np.random.Generator) -> Mesh:
    """A cap with a short visor, turned up, level or down, before a low or a round crown."""
    crown = Crown(
        *rng.uniform((0.090, 0.078, 0.078, 0.52, 0.002, 0.02), (0.106, 0.092, 0.120, 0.90, 0.028, 0.16)),
        arch=rng.choice([0.0, 0.26]),
    )
    crown = crown.dented(rng, rng.integers(0, 4), (0.005, 0.020))
    rise, curl, square = rng.uniform((-0.022, 0, 2.0), (0.026, 0.014, 3.2))
    return _rest(_sewn(rng, crown, brim(crown, rng.uniform(0.036, 0.054), rise, curl, square)))


STYLES = (build, flat_brim, trucker, floppy, worn, short_visor)


def _sewn(rng: np.random.Generator, crown: Crown, visor: Mesh, foam: bool = False) -> Mesh:
    """A cap on a crown, in cloths of its own: with a button or without, a strap where the crown leaves an arch."""
    main, second, accent = (CLOTHS[i] for i in rng.permutation(len(CLOTHS))[:3])
    front = accent if rng.random() < (0.9 if foam else 0.25) else main
    trim = second if rng.random() < 0.5 else main
    parts = [shell(crown, main, front), visor.painted(trim)]
    if rng.random() < 0.8:
        button = ellipsoid(0.0075, 0.0075, 0.004, 16).moved(z=0.001)
        parts.append(button.moved(*crown.at(np.array(0.0), np.array(1.0))).painted(second))
    if rng.random() < 0.75:
        parts.append(emblem(rng, crown).painted(second if front == WHITE else WHITE))
    if crown.arch:
        parts.append(strap(crown).painted(trim))
    if not foam:
        parts += [part.painted(second) for part in eyelets(crown)]
    return merge(parts)


def _rest(cap: Mesh) -> Mesh:
    """The cap as it comes to rest: pitched until the lowest point of its front half bears as its back half's does."""
    for _ in range(4):  # a turn may bring other points down
        x, z = cap.vertices[:, 0], cap.vertices[:, 2]
        ahead = x > x.min() + 0.42 * np.ptp(x)
        front, back = (np.flatnonzero(half)[np.argmin(z[half])] for half in (ahead, ~ahead))
        cap = cap.turned("y", np.degrees(np.arctan2(z[front] - z[back], x[front] - x[back])))
    return cap
