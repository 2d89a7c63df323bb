"""The two levers that pliers are made of, and how they are crossed at their rivet. A lever's jaw is at +y, its handle
at -y, the rivet at the origin, the middle of its height at z = MIDDLE."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import box, cylinder, loft, rounded_rectangle, sweep

MIDDLE = 0.006  # [m]
STEEL, DARK, BRIGHT = (150, 154, 160), (92, 96, 104), (196, 198, 202)
RED, BLUE, YELLOW, GREEN = (192, 46, 44), (44, 92, 168), (234, 192, 48), (66, 138, 84)
ORANGE, BLACK = (228, 122, 40), (60, 62, 68)
GRIPS = (RED, BLUE, YELLOW, GREEN, ORANGE, BLACK)


@dataclass(frozen=True)
class Finish:
    """What the handles are covered with."""

    metal: tuple[int, int, int]
    color: tuple[int, int, int]
    trim: tuple[int, int, int]
    cover: str  # sleeve (thick, two colours, a guard), dip (thin plastic) or bare


def finish(rng: np.random.Generator) -> Finish:
    """A finish drawn from the generator; most handles have a sleeve or are dipped."""
    color, trim = (GRIPS[i] for i in rng.permutation(len(GRIPS))[:2])
    metal = (STEEL, DARK, BRIGHT)[rng.integers(3)]
    return Finish(metal, color, trim, str(rng.choice(["sleeve", "dip", "bare"], p=[0.4, 0.35, 0.25])))


def opening(rng: np.random.Generator, widest: float) -> float:
    """The angle [degrees] between the levers: two in five are shut, one in five is open wide."""
    how = rng.random()
    if how < 0.4:
        return rng.uniform(0, 4)
    return rng.uniform(4, 0.4 * widest) if how < 0.8 else rng.uniform(0.4 * widest, widest)


def jaw(inner: np.ndarray, outer: np.ndarray, heights: np.ndarray, rise: np.ndarray | float = 0.0) -> Mesh:
    """A jaw between its inner and outer edge (N, 2), as high as given (N,), its middle raised by `rise` (N,) [m]."""
    unit = rounded_rectangle(1, 1, 0.16, 2)
    middles = MIDDLE + np.broadcast_to(rise, len(inner))
    rings = []
    for near, far, height, middle in zip(inner, outer, heights, middles, strict=True):
        across = near + (unit[:, :1] + 0.5) * (far - near)
        rings.append(np.column_stack([across, middle + unit[:, 1] * height]))
    return loft(np.stack(rings))


def handle_path(length: float, root: float, bow: float, straightness: float, flare: float = 0.0) -> np.ndarray:
    """The middle of a handle (40, 3) [m]: bowed by `bow`, or as far apart at its end, the straighter the nearer to 1.

    It leaves the rivet `root` off the middle and turns outward by `flare` at its end.
    """
    s = np.linspace(0, 1, 40)
    bowed = np.sin(np.pi * 0.92 * s) ** 0.9
    apart = (1 - straightness) * bowed + straightness * s**0.8
    y = -np.interp(s, [0, 0.10], [0.3 * root, root]) - bow * apart - flare * s**6
    return np.column_stack([-length * s, y, np.full(len(s), MIDDLE)])


def handle(path: np.ndarray, look: Finish, width: float = 0.011, thickness: float = 0.0085) -> list[Mesh]:
    """A handle along a path: the tang, and on it what the finish has [m]."""
    s = np.linspace(0, 1, len(path))
    taper = np.interp(s, [0, 0.15, 0.9, 1], [1.15, 1.0, 0.9, 0.7])[:, None]
    tang = sweep(rounded_rectangle(width, thickness, 0.002, 2), path, scales=taper).painted(look.metal)
    if look.cover == "bare":
        return [tang]
    grip = path[10:]
    g = np.linspace(0, 1, len(grip))
    ends = np.interp(g, [0, 0.03, 0.96, 1], [0.85, 1, 0.9, 0.5])
    if look.cover == "dip":
        outline = rounded_rectangle(width + 0.003, thickness + 0.003, 0.004, 4)
        return [tang, sweep(outline, grip, scales=ends[:, None]).painted(look.color)]
    swell = ends * np.interp(g, [0, 0.05, 0.10, 0.5, 1], [1.30, 1.30, 1.0, 1.10, 1.0])
    outline = rounded_rectangle(width + 0.009, thickness + 0.006, 0.005, 4)
    stripe = rounded_rectangle(0.4 * (width + 0.009), thickness + 0.0068, 0.0016, 2)
    return [
        tang,
        sweep(outline, grip, scales=swell[:, None]).painted(look.color),
        sweep(stripe, grip[3:-3], scales=swell[3:-3, None]).painted(look.trim),
    ]


def crossed(lower: Iterable[Mesh], upper: Iterable[Mesh], opening_deg: float, head: float, look: Finish) -> Mesh:
    """Pliers of two levers, the upper one turned over, opened by an angle, with a round head of a radius [m]."""
    disc = cylinder(head, MIDDLE + 0.001, 0.001).painted(look.metal)
    return merge(
        [
            *(part.turned("z", opening_deg / 2) for part in (*lower, disc)),
            *(over(part).turned("z", -opening_deg / 2) for part in (*upper, disc)),
            cylinder(0.35 * head, 0.003, 0.001, 20).moved(z=2 * MIDDLE - 0.0008).painted(BRIGHT),
            box(0.5 * head, 0.0012, 0.001).moved(z=2 * MIDDLE + 0.0018).painted(DARK),
        ]
    )


def over(part: Mesh) -> Mesh:
    """The part of a lever, turned over about the x axis."""
    return part.turned("x", 180).moved(z=2 * MIDDLE)
