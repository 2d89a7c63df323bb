"""Pliers whose jaws are set to what they hold: slip-joint, tongue-and-groove and locking pliers."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.pliers.lever import (
    BRIGHT,
    MIDDLE,
    crossed,
    finish,
    handle,
    handle_path,
    jaw,
    opening,
    over,
)
from orbitscan.recorder.simulation.objects.solids import cylinder, rounded_rectangle, sweep

POINTS = 30  # along a jaw


def slip_joint(rng: np.random.Generator) -> Mesh:
    """Stout jaws, flat at their tips and hollowed for pipes behind, on slender handles."""
    look = finish(rng)
    length, root, tip, hollow = rng.uniform((0.034, 0.014, 0.007, 0.002), (0.056, 0.020, 0.011, 0.007))
    head = rng.uniform(0.0135, 0.0185)
    s = np.linspace(0, 1, POINTS)
    x = -0.2 * head + (length + 0.6 * head) * s
    inner = 0.0004 + hollow * np.exp(-(((s - 0.5) / 0.14) ** 2)) + 0.0008 * (np.arange(POINTS) % 2) * (s > 0.35)
    outer = np.interp(s, [0, 0.25, 0.6, 0.95, 1], [0.8 * root, root, 0.9 * root + 0.4 * hollow, tip, 0.8 * tip])
    edge = jaw(np.column_stack([x, inner]), np.column_stack([x, outer]), np.interp(s, [0, 1], [0.012, 0.008]))
    path = handle_path(
        rng.uniform(0.100, 0.145), 0.4 * head, rng.uniform(0.012, 0.028), rng.uniform(0, 1), rng.uniform(0, 0.010)
    )
    lever = [edge.painted(look.metal), *handle(path, look, rng.uniform(0.009, 0.012))]
    return crossed(lever, lever, opening(rng, 44), head, look)


def tongue_and_groove(rng: np.random.Generator) -> Mesh:
    """Long handles and a head set at an angle to them, its toothed jaws parallel and some way apart."""
    look = finish(rng)
    size = rng.uniform(0.65, 1.15)
    head_deg = rng.uniform(28, 58)
    gap = size * rng.uniform(0, 0.022) if rng.random() < 0.7 else 0.0
    length, neck, tip = size * rng.uniform((0.046, 0.016, 0.008), (0.062, 0.022, 0.013))
    s = np.linspace(0, 1, POINTS)
    x = -0.010 * size + (length + 0.010 * size) * s
    teeth = 0.0009 * (np.arange(POINTS) % 2) * (s > 0.3)
    hollow = 0.003 * size * np.exp(-(((s - 0.55) / 0.15) ** 2))
    width = np.interp(s, [0, 0.3, 0.7, 1], [neck, 1.1 * neck, 0.9 * neck, tip])
    heights = np.interp(s, [0, 1], [0.0115, 0.0095])
    jaws = []
    for apart, turn in ((gap, head_deg), (0.0, -head_deg)):
        near = 0.0004 + apart * np.clip(s / 0.25, 0, 1) + teeth + hollow
        edge = jaw(np.column_stack([x, near]), np.column_stack([x, near + width - teeth]), heights)
        jaws.append(edge.turned("z", turn).painted(look.metal))
    long, apart = size * rng.uniform((0.125, 0.012), (0.175, 0.026))
    levers = [
        handle(handle_path(share * long, 0.010 * size, apart, straight, 0.0), look, 0.013 * size**0.5, 0.0085)
        for share, straight in ((1.0, rng.uniform(0.4, 1)), (0.97, rng.uniform(0.3, 1)))
    ]
    head = 0.0155 * size
    return crossed([jaws[0], *levers[0]], [jaws[1], *levers[1]], opening(rng, 24), head, look)


def locking(rng: np.random.Generator) -> Mesh:
    """Locking pliers: one jaw of a piece with a channel of sheet steel that ends in a screw, the other on a lever."""
    look = finish(rng)
    size = rng.uniform(0.62, 1.12)
    opening_deg = opening(rng, 32)
    length, root, tip, hollow = size * rng.uniform((0.038, 0.017, 0.008, 0.001), (0.060, 0.024, 0.013, 0.008))
    s = np.linspace(0, 1, POINTS)
    x = -0.012 * size + (length + 0.012 * size) * s
    inner = 0.0004 + hollow * np.exp(-(((s - 0.5) / 0.18) ** 2)) + 0.0008 * (np.arange(POINTS) % 2)
    outer = np.interp(s, [0, 0.3, 0.7, 1], [0.9 * root, root, 0.85 * root + hollow, tip])
    heights = np.interp(s, [0, 0.3, 1], [0.015, 0.014, 0.010])
    edge = jaw(np.column_stack([x, inner]), np.column_stack([x, outer]), heights).painted(look.metal)

    back = size * rng.uniform(0.110, 0.140)
    t = np.linspace(0, 1, 30)
    spine = size * (0.012 + 0.012 * np.sin(np.pi * np.clip(1.3 * t, 0, 1)))
    channel = np.column_stack([-back * t + 0.004, spine, np.full(30, MIDDLE)])
    screw = cylinder(0.0072 * size, 0.016 * size, 0.0012, 24).turned("y", -90).moved(-back, spine[-1], MIDDLE)
    thread = cylinder(0.0038 * size, 0.020 * size, 0.0005, 16).turned("y", -90).moved(-0.93 * back, spine[-1], MIDDLE)
    fixed = [
        edge,
        sweep(rounded_rectangle(0.016 * size, 0.016, 0.0035, 3), channel).painted(look.metal),
        screw.painted(BRIGHT),
        thread.painted(BRIGHT),
    ]
    bow, short = size * rng.uniform((0.016, 0.085), (0.028, 0.110))
    path = handle_path(short, 0.008 * size, bow, rng.uniform(0, 0.7), 0.006 * size)
    release = handle_path(0.55 * short, 0.002, 0.35 * bow, 0.6)[12:] + np.array([-0.42 * short, -0.3 * bow, 0])
    lever = [
        *handle(path, look, 0.013 * size, 0.012),
        sweep(rounded_rectangle(0.005, 0.009, 0.001, 2), release).painted(look.metal),
    ]
    return merge(
        [
            *fixed,
            over(edge).turned("z", -opening_deg),
            cylinder(0.010 * size, 0.014, 0.001, 24).moved(0.004, 0, MIDDLE - 0.007).painted(BRIGHT),
            *(part.turned("z", 0.6 * opening_deg) for part in lever),
        ]
    )
