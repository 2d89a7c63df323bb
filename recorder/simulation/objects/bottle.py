"""Bodies of bottles: a foot, a wall with or without waist and ribs, a shoulder and a neck; round, square or oval."""

from dataclasses import dataclass

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.vessel import Color, lathe


@dataclass(frozen=True)
class Form:
    """The measures of a bottle's body; lengths in metres."""

    height: float  # from the table to where the neck begins
    radius: float
    neck: float  # radius
    shoulder: float  # height of the part between wall and neck
    roundness: float = 1.0  # of the shoulder: 1 an ellipse, 2 a cone
    taper: float = 1.0  # radius at the foot, as a share of that at the shoulder
    waist: float = 0.0  # its depth, as a share of the radius
    middle: float = 0.5  # its height, as a share of the wall's
    width: float = 0.15  # likewise
    ribs: int = 0  # grooves about the wall
    depth: float = 0.0  # of a groove
    grooved: tuple[float, float] = (0.2, 0.7)  # between these shares of the wall's height
    stem: float = 0.014  # length of the neck, 0.012 or more
    open: bool = False

    @property
    def wall(self) -> np.ndarray:
        """The wall (P, 2) of radius and height between foot and shoulder."""
        top = self.height - self.shoulder
        low, high = self.grooved
        even = np.linspace(0.006 / top, 1, 9)
        cut = np.linspace(low, high, 4 * self.ribs + 1) if self.ribs else np.empty(0)
        share = np.union1d(even[(even < low - 0.02) | (even > high + 0.02)] if self.ribs else even, cut)
        within = np.clip((share - low) / (high - low), 0, 1)
        radii = self.radius * (self.taper + (1 - self.taper) * share)
        radii *= 1 - self.waist * np.exp(-(((share - self.middle) / self.width) ** 2))
        return np.column_stack([radii - self.depth * (1 - np.cos(2 * np.pi * self.ribs * within)) / 2, share * top])


def body(form: Form, colors: tuple[Color, Color], outline: np.ndarray | None = None) -> Mesh:
    """The bottle without its closure: one colour, another for the neck; the section is round from the neck on."""
    wall = form.wall
    foot, shoulder = wall[0, 0], wall[-1, 0]
    angles = np.linspace(0, np.pi / 2, 9)[1:]
    rise = np.column_stack([np.cos(angles), np.sin(angles)]) ** form.roundness
    slope = (form.neck, form.height - form.shoulder) + rise * (shoulder - form.neck, form.shoulder)
    top, ring = form.height + form.stem, min(0.0025, 0.1 * form.neck)
    collar = [(form.neck, top - 0.010), (form.neck + ring, top - 0.0095), (form.neck + ring, top - 0.007)]
    neck = [*collar, (form.neck - 0.0005, top - 0.0065), (form.neck - 0.0005, top)]
    bore, inside = 0.85 * form.neck, wall[:, 0].min() - 0.003
    well = [(bore, top), (bore, form.height), (max(bore, inside), wall[-1, 1]), (max(bore, inside), 0.008), (0, 0.008)]
    base = [(0, 0.004), (0.70 * foot, 0.003), (0.80 * foot, 0), (0.93 * foot, 0)]
    profile = np.array([*base, *wall, *slope, *neck, *(well if form.open else [(0, top)])])
    share = np.clip((form.height - profile[:, 1]) / form.shoulder, 0, 1)
    mesh = lathe(profile, outline, share**2 * (3 - 2 * share))
    above = mesh.vertices[:, 2] > form.height + 1e-6
    return Mesh(mesh.vertices, mesh.triangles, np.array(colors, np.uint8)[above.astype(int)])
