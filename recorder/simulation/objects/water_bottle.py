"""Water bottles, upright, 15 to 33 cm high: of thin plastic, steel or glass, for sports and for children, open or
capped; but for the last styles they are surfaces of revolution."""

from typing import Any

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.bottle import Form, body
from orbitscan.recorder.simulation.objects.closure import carrying_loop, cup_lid, screw_cap, sports_cap, tether
from orbitscan.recorder.simulation.objects.solids import revolve
from orbitscan.recorder.simulation.objects.vessel import SEGMENTS, superellipse

STEEL, BLACK, WHITE = (188, 192, 196), (58, 60, 66), (234, 234, 230)
RED, BLUE, AQUA, GREEN = (188, 58, 52), (44, 88, 160), (104, 186, 204), (86, 148, 92)
ORANGE, PINK, NAVY = (226, 128, 52), (214, 128, 150), (52, 62, 96)
BODIES = (STEEL, BLACK, WHITE, RED, BLUE, AQUA, GREEN, ORANGE, PINK, NAVY)
CAPS = (BLACK, WHITE, STEEL, RED, BLUE, ORANGE)


def everyday(rng: np.random.Generator) -> Mesh:
    """A bottle; instances differ in proportions, waist, rings, shoulder, in the closure (or none) and in colours."""
    radius, height, neck = rng.uniform((0.031, 0.165, 0.34), (0.041, 0.225, 0.66))
    neck *= radius
    shoulder = rng.uniform(0.5, 1.3) * radius
    wall = _wall(rng, radius, height - shoulder)
    angles = np.linspace(0, np.pi / 2, 9)[1:]
    roundness = rng.uniform(0.75, 1.25)
    slope = np.column_stack(
        [
            neck + (radius - neck) * np.cos(angles) ** roundness,
            height - shoulder + shoulder * np.sin(angles) ** roundness,
        ]
    )
    foot = [(0, 0.004), (0.70 * radius, 0.003), (0.80 * radius, 0), (0.93 * radius, 0)]
    top = height + 0.014
    collar = [(neck, height + 0.003), (neck + 0.003, height + 0.004), (neck + 0.003, height + 0.007)]
    mouth = [*collar, (neck - 0.001, height + 0.008), (neck - 0.001, top)]
    bore = neck - 0.004
    hollow = [(bore, top), (bore, height), (0.6 * radius + 0.4 * bore, height - shoulder), (0, height - 1.3 * shoulder)]
    body = revolve(np.array([*foot, *wall, *slope, *mouth, *hollow]), SEGMENTS)
    color, base, lid = BODIES[rng.integers(len(BODIES))], BODIES[rng.integers(3)], CAPS[rng.integers(len(CAPS))]
    z = body.vertices[:, 2]
    dipped = rng.integers(2) * rng.uniform(0.1, 0.3) * height  # the part of the foot in another colour
    colors = np.where((z < dipped)[:, None], np.array(base), np.array(color))
    colors[z > height] = BLACK if color == STEEL else STEEL
    painted = Mesh(body.vertices, body.triangles, colors.astype(np.uint8))
    return merge([painted, *(part.moved(z=height + 0.0075).painted(lid) for part in _closure(rng, neck))])


def _wall(rng: np.random.Generator, radius: float, top: float) -> np.ndarray:
    """The wall (P, 2) from the foot to the shoulder, with or without a waist where the hand grips, grooves about it."""
    waist, middle, width = rng.uniform((0.06, 0.45, 0.10), (0.20, 0.65, 0.18)) * (rng.integers(2), 1, 1)
    count, gap, depth = int(rng.integers(4)), rng.uniform(0.010, 0.018), rng.uniform(0.0015, 0.0030)
    levels = np.linspace(0.006, top, 8)
    grooves = middle * top + gap * (np.arange(count) - (count - 1) / 2)
    offsets = np.array([-0.0032, -0.0016, 0.0016, 0.0032])
    cut = (grooves[:, None] + offsets).ravel()
    near = np.abs(levels[:, None] - grooves).min(axis=1, initial=1.0)
    z = np.concatenate([levels[near > 0.005], cut])
    sunk = np.concatenate([np.zeros((near > 0.005).sum()), np.tile([0, depth, depth, 0], count)])
    order = np.argsort(z)
    z, sunk = z[order], sunk[order]
    radii = radius * (1 - waist * np.exp(-(((z / top - middle) / width) ** 2))) - sunk
    return np.column_stack([radii, z])


def _closure(rng: np.random.Generator, neck: float) -> list[Mesh]:
    """A screw cap, a sports cap with its spout, or nothing: an open bottle."""
    kind = rng.integers(3)
    if kind == 2:
        return []
    r, h = neck + 0.004, rng.uniform(0.014, 0.026)
    profile = [(0, 0), (r - 0.001, 0), (r, 0.001), (r, 0.7 * h), (0.94 * r, 0.93 * h), (0.85 * r, h)]
    if kind == 1:
        s = min(0.010, 0.5 * neck)
        spout = [(s, h + 0.003), (s, h + 0.012), (s + 0.002, h + 0.013), (s + 0.002, h + 0.018), (s, h + 0.021)]
        profile += [*spout, (0, h + 0.021)]
    else:
        profile += [(0, h)]
    return [revolve(np.array(profile), SEGMENTS)]


def half_litre(rng: np.random.Generator) -> Mesh:
    """A single-use bottle of thin plastic: ribs, a long shoulder, a small cap or none."""
    height, radius, shoulder, roundness = rng.uniform((0.175, 0.0295, 0.040, 0.9), (0.212, 0.0345, 0.080, 1.6))
    form = Form(height, radius, 0.0125, shoulder, roundness, **_ribbed(rng), stem=0.018, open=rng.random() < 0.25)
    return _bottle(rng, form, screw_cap(0.0150, rng.uniform(0.011, 0.017)))


def large(rng: np.random.Generator) -> Mesh:
    """A single-use bottle of thin plastic for a litre and a half."""
    height, radius, shoulder, roundness = rng.uniform((0.265, 0.0405, 0.055, 0.9), (0.305, 0.0465, 0.110, 1.5))
    form = Form(height, radius, 0.0135, shoulder, roundness, **_ribbed(rng), stem=0.018, open=rng.random() < 0.2)
    return _bottle(rng, form, screw_cap(0.0160, rng.uniform(0.012, 0.018)))


def sports(rng: np.random.Generator) -> Mesh:
    """A soft bottle gripped at its waist, a big cap with a spout to pull."""
    height, radius, shoulder, lid = rng.uniform((0.125, 0.033, 0.008, 0.80), (0.185, 0.040, 0.030, 1.0))
    waist, middle, width = rng.uniform((0.06, 0.50, 0.07), (0.20, 0.78, 0.16))
    form = Form(height, radius, 0.72 * radius, shoulder, 0.8, waist=waist, middle=middle, width=width)
    return _bottle(rng, form, _spout(rng, lid * radius))


def flask(rng: np.random.Generator) -> Mesh:
    """A metal cylinder with a dome for a shoulder."""
    height, radius, neck, shoulder = rng.uniform((0.160, 0.031, 0.50, 0.018), (0.245, 0.038, 0.72, 0.042))
    form = Form(height, radius, neck * radius, shoulder, stem=0.012, open=rng.random() < 0.2)
    return _bottle(rng, form, screw_cap(form.neck + 0.003, rng.uniform(0.018, 0.045), rng.uniform(0, 0.006)))


def wide_mouth(rng: np.random.Generator) -> Mesh:
    """A litre for the trail: almost as wide at the lid as at the foot."""
    height, radius, neck, shoulder = rng.uniform((0.130, 0.039, 0.66, 0.012), (0.185, 0.046, 0.82, 0.030))
    form = Form(height, radius, neck * radius, shoulder, 0.9, stem=0.016, open=rng.random() < 0.25)
    return _bottle(rng, form, screw_cap(form.neck + 0.004, rng.uniform(0.017, 0.026)))


def thermos(rng: np.random.Generator) -> Mesh:
    """A vacuum flask under its cup, which is as wide as the body or a little less."""
    height, radius, lid, taper = rng.uniform((0.140, 0.031, 0.88, 0.80), (0.245, 0.042, 1.02, 1.0))
    form = Form(height, radius, 0.80 * radius, rng.uniform(0.004, 0.014), 0.9)
    return _bottle(rng, form, cup_lid(lid * radius, rng.uniform(0.040, 0.075), taper))


def glass(rng: np.random.Generator) -> Mesh:
    """A long neck on a shoulder from round to sloping."""
    height, radius, shoulder, stem = rng.uniform((0.140, 0.032, 0.025, 0.025), (0.205, 0.043, 0.075, 0.085))
    neck, roundness = rng.uniform((0.0125, 0.9), (0.0175, 1.9))
    form = Form(height, radius, neck, shoulder, roundness, stem=stem, open=rng.random() < 0.4)
    return _bottle(rng, form, screw_cap(neck + 0.002, rng.uniform(0.012, 0.022)))


def hourglass(rng: np.random.Generator) -> Mesh:
    """Slightly drawn in over its whole height, or a cone that opens upwards."""
    height, radius, neck, shoulder = rng.uniform((0.145, 0.032, 0.55, 0.008), (0.225, 0.040, 0.85, 0.030))
    waist, middle, taper = (rng.uniform(0.07, 0.18), rng.uniform(0.4, 0.6), 1.0)
    if rng.random() < 0.4:
        waist, taper = 0.0, rng.uniform(0.74, 0.88)
    form = Form(height, radius, neck * radius, shoulder, 0.9, taper, waist, middle, 0.32, open=rng.random() < 0.2)
    lids = screw_cap(form.neck + 0.004, rng.uniform(0.018, 0.040), 0.004), _spout(rng, form.neck + 0.004)
    return _bottle(rng, form, lids[rng.integers(2)])


def carried(rng: np.random.Generator) -> Mesh:
    """A lid with a loop to carry it by or tied to the neck; half of them short, for children."""
    height, radius, neck, shoulder = rng.uniform((0.150, 0.034, 0.62, 0.010), (0.205, 0.045, 0.85, 0.035))
    height = height if rng.random() < 0.5 else rng.uniform(0.125, 0.145)
    form = Form(height, radius, neck * radius, shoulder, waist=rng.uniform(0, 0.10) * rng.integers(2), stem=0.016)
    lid, rise, width = form.neck + 0.004, rng.uniform(0.012, 0.022), rng.uniform(0.008, 0.018)
    if rng.random() < 0.5:
        straps = [carrying_loop(rng.uniform(0.7, 0.98) * lid, rng.uniform(0.018, 0.036), width).moved(z=rise)]
        return _bottle(rng, form, screw_cap(lid, rise), straps)
    strap = tether((0.80 * lid, rise + 0.001), (form.neck, -0.004), rng.uniform(0.014, 0.030), width)
    return _bottle(rng, form, (screw_cap(lid, rise), _spout(rng, lid))[rng.integers(2)], [strap])


def square(rng: np.random.Generator) -> Mesh:
    """A soft square below, round from the neck on; of thin plastic, or a flask."""
    height, radius, shoulder, neck = rng.uniform((0.165, 0.028, 0.018, 0.0125), (0.225, 0.036, 0.060, 0.022))
    ribs = _ribbed(rng) if rng.random() < 0.4 else {}
    form = Form(height, radius, neck, shoulder, rng.uniform(0.8, 1.3), **ribs, open=rng.random() < 0.2)
    cap = screw_cap(neck + 0.0025, rng.uniform(0.012, 0.030))
    return _bottle(rng, form, cap, outline=superellipse(rng.uniform(2.8, 6.0)))


def oval(rng: np.random.Generator) -> Mesh:
    """Wider than deep, to slip into a bag; some with a spout."""
    height, radius, shoulder, aspect = rng.uniform((0.130, 0.024, 0.015, 1.25), (0.205, 0.031, 0.050, 1.65))
    form = Form(height, radius, rng.uniform(0.014, 0.021), shoulder, rng.uniform(0.8, 1.3))
    lids = screw_cap(form.neck + 0.003, rng.uniform(0.014, 0.028)), _spout(rng, form.neck + 0.004)
    return _bottle(rng, form, lids[rng.integers(2)], outline=superellipse(rng.uniform(2.0, 3.5), aspect))


ROUND = (everyday, half_litre, sports, flask, large, wide_mouth, thermos, glass, hourglass)  # surfaces of revolution
STYLES = (*ROUND, carried, square, oval)


def _ribbed(rng: np.random.Generator) -> dict[str, Any]:
    """Ribs of thin plastic, and a waist for some: settings of a form."""
    depth, low, high = rng.uniform((0.0008, 0.10, 0.50), (0.0028, 0.40, 0.90))
    waist, middle = rng.uniform((0.04, 0.40), (0.14, 0.65))
    ribs: dict[str, Any] = {"ribs": int(rng.integers(2, 6)), "depth": depth, "grooved": (low, high)}
    return ribs | {"waist": waist * rng.integers(2), "middle": middle, "width": 0.12}


def _spout(rng: np.random.Generator, radius: float) -> Mesh:
    """A cap of a radius with a spout to drink from [m]."""
    height, spout, length, waist = rng.uniform((0.018, 0.006, 0.014, 0.65), (0.034, 0.011, 0.032, 1.0))
    return sports_cap(radius, height, min(spout, 0.5 * radius), length, waist)


def _bottle(
    rng: np.random.Generator, form: Form, lid: Mesh, straps: list[Mesh] | None = None, outline: np.ndarray | None = None
) -> Mesh:
    """The body in a colour with its lid, unless it is open, in another; straps are placed from the lid's foot."""
    color, cap = BODIES[rng.integers(len(BODIES))], CAPS[rng.integers(len(CAPS))]
    neck = BLACK if color == STEEL else STEEL
    foot = form.height + max(form.stem - 0.009, 0.001)
    parts = [] if form.open else [part.moved(z=foot).painted(cap) for part in (lid, *(straps or []))]
    return merge([body(form, (color, neck), outline), *parts])
