"""Combination, needle-nose and flat pliers: two levers crossed at a rivet, grips of plastic."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.pliers.lever import BRIGHT, DARK, GRIPS, STEEL
from orbitscan.recorder.simulation.objects.solids import box, cylinder, loft, rounded_rectangle, sweep

JAWS = ((0.045, 0.0160, 0.0095), (0.062, 0.0150, 0.0044), (0.032, 0.0165, 0.0130))  # length, width at root and tip [m]


def combination(rng: np.random.Generator) -> Mesh:
    """Combination, needle-nose or flat pliers; instances differ in length, grips and opening."""
    length, root, tip = rng.uniform(0.90, 1.10, 3) * JAWS[rng.integers(len(JAWS))]
    opening_deg, handle, bow = rng.uniform((2, 0.122, 0.024), (26, 0.136, 0.030))
    color, trim = (GRIPS[i] for i in rng.permutation(len(GRIPS))[:2])
    metal = (STEEL, DARK, BRIGHT)[rng.integers(3)]
    head = rng.uniform(0.0160, 0.0190)
    lower = [_jaw(length, root, tip).painted(metal), *_handle(handle, bow, metal, color, trim)]
    upper = [_jaw(length, root, tip).painted(metal), *_handle(handle * 0.98, bow, metal, color, trim)]
    parts = [
        *(part.turned("z", opening_deg / 2) for part in [*lower, cylinder(head, 0.007, 0.001).painted(metal)]),
        *(
            part.turned("x", 180).moved(z=0.012).turned("z", -opening_deg / 2)
            for part in [*upper, cylinder(0.94 * head, 0.007, 0.001).painted(metal)]
        ),
        cylinder(0.0055, 0.003, 0.001, 20).moved(z=0.0115).painted(BRIGHT),
        box(0.008, 0.0012, 0.001).turned("z", float(rng.uniform(0, 180))).moved(z=0.0142).painted(DARK),
    ]
    return merge(part.moved(z=0.003) for part in parts)


def _jaw(length: float, root: float, tip: float) -> Mesh:
    """The jaw at +y: flat inside, with teeth, its back tapering from the rivet to the tip."""
    share = np.concatenate([np.linspace(-0.12, 0.2, 5), np.linspace(0.24, 1, 39)])
    width = np.interp(
        share, [-0.12, 0.15, 0.5, 0.93, 1], [0.7 * root, root, root + 0.45 * (tip - root), tip, 0.7 * tip]
    )
    height = np.interp(share, [-0.12, 0.6, 1], [0.0115, 0.0095, 0.8 * max(tip, 0.005)])
    tooth = np.where((share > 0.35) & (np.arange(len(share)) % 2 == 0), 0.0010, 0.0)
    notch = 0.0022 * np.exp(-(((share - 0.26) / 0.05) ** 2))  # of the wire cutter
    unit = rounded_rectangle(1, 1, 0.16, 2)
    rings = []
    for s, w, h, cut in zip(share, width, height, tooth + notch, strict=True):
        y = 0.0004 + cut + (unit[:, 0] + 0.5) * (w - cut)
        rings.append(np.column_stack([np.full(len(unit), 0.006 + s * length), y, 0.006 + unit[:, 1] * h]))
    return loft(np.stack(rings))


def _handle(
    length: float, bow: float, metal: tuple[int, int, int], color: tuple[int, int, int], trim: tuple[int, int, int]
) -> list[Mesh]:
    """The handle at -y: a steel tang from the rivet, the grip on it with a guard before and a stripe along it."""
    share = np.linspace(0, 1, 49)
    x = -length * share
    y = -np.interp(share, [0, 0.12], [0.002, 0.006]) - bow * np.sin(np.pi * np.clip(share * 0.92, 0, 1)) ** 0.9
    path = np.column_stack([x, y, np.full(len(x), 0.006)])
    tang = sweep(rounded_rectangle(0.0130, 0.0090, 0.002, 2), path[:40])
    grip = path[13:]
    s = np.linspace(0, 1, len(grip))
    thick = np.interp(s, [0, 0.02, 0.05, 0.09, 0.5, 0.93, 0.98, 1], [0.8, 1.28, 1.28, 1.0, 1.08, 0.98, 0.75, 0.35])
    thick = thick[:, None]
    outline = rounded_rectangle(0.0200, 0.0140, 0.0055, 4)
    stripe = rounded_rectangle(0.0080, 0.0148, 0.0016, 2)
    return [
        tang.painted(metal),
        sweep(outline, grip, scales=thick).painted(color),
        sweep(stripe, grip[4:-3], scales=thick[4:-3]).painted(trim),
    ]
