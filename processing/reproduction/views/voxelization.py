"""Figures 3.5 and 3.6: what a voxel grid keeps of a view, by what its voxels hold and by how many there are."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.colors import LogNorm

from orbitscan.processing.classification.voxels import VoxelSettings, bounding_spheres, pack, voxel_grids, voxel_indices
from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.training.counts import VALUES
from orbitscan.processing.reproduction.views import circles
from orbitscan.processing.reproduction.views.grid_drawing import draw_count_bar, draw_grid
from orbitscan.processing.reproduction.views.view_drawing import draw_view
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.session import View

SHOWN = "coffee_mug"
DIVS = (16, 24, 32)  # figure 3.6
PLACE = 0.2  # of the circle, where the view is taken


@dataclass(frozen=True, eq=False)
class Grid:
    """The voxel grid of a view, and what is lost in it."""

    counts: np.ndarray  # (div, div, div) points in each voxel
    side: float  # of a voxel [m]
    offset: float  # root mean square distance from the points to the centres of their voxels [m]

    @property
    def occupied(self) -> np.ndarray:
        """The numbers of points in the voxels that hold any."""
        return self.counts[self.counts > 0]

    @property
    def shared(self) -> float:
        """The share of the occupied voxels that hold more than one point."""
        return float((self.occupied > 1).mean())


def make_grid(points: np.ndarray, div: int) -> Grid:
    """The grid of counts of finite points (N, 3) in metres."""
    clouds = pack([points])
    counts = voxel_grids(clouds, VoxelSettings(div=div))[0, 0].numpy()
    centroids, radii = bounding_spheres(clouds)
    side = 2 * float(radii[0]) / div
    centres = centroids.numpy() + side * (voxel_indices(clouds, div).numpy() + 0.5 - div / 2)
    return Grid(counts, side, float(np.sqrt(((points - centres) ** 2).sum(axis=1).mean())))


def measure_entropy(values: np.ndarray) -> float:
    """The entropy [bits] of a whole grid, were each of its voxels drawn by itself with the grid's own frequencies."""
    _, numbers = np.unique(values, return_counts=True)
    shares = numbers / numbers.sum()
    return float(-(shares * np.log2(shares)).sum() * values.size)


def show_values(plan: Plan) -> Report:
    """Figure 3.5: a view, its grid of counts, and the same grid as occupancy."""
    views = _choose_views(plan)
    grids = {category: make_grid(finite(view.points)[0], VoxelSettings().div) for category, view in views.items()}
    rows = [_describe_values(category, grid, values) for category, grid in grids.items() for values in VALUES]
    name = _choose_shown(views)
    shown = grids[name]
    gains = [measure_entropy(grid.counts) / measure_entropy(grid.counts > 0) for grid in grids.values()]
    said = [
        f"In the grid of the {name}'s view {100 * shown.shared:.0f} % of the occupied voxels hold more than one "
        f"point, the fullest {shown.occupied.max():.0f}; occupancy takes them all for the same.",
        f"{_span(_share(grids), '.0f', '%')} of the occupied voxels hold more than one point.",
        f"Voxel by voxel the counts hold {min(gains):.2f} to {max(gains):.2f} times the bits of occupancy; whether a "
        "network makes use of them is the question of study-counts.",
    ]
    settings, figures = {"place_on_circle": PLACE, "shown": name}, {"figure-3.5": _draw_values(views[name], shown)}
    return Report("figure-3.5", "A view as counts and as occupancy", rows, said, figures=figures, settings=settings)


def show_resolutions(plan: Plan) -> Report:
    """Figure 3.6: the same view with 16, 24 and 32 voxels along each side."""
    views = _choose_views(plan)
    grids = {
        category: {div: make_grid(finite(view.points)[0], div) for div in DIVS} for category, view in views.items()
    }
    rows = [_describe_resolution(category, grid) for category, of in grids.items() for grid in of.values()]
    coarse, fine = ({category: of[div] for category, of in grids.items()} for div in (DIVS[0], DIVS[-1]))
    growth = [
        np.log(len(fine[category].occupied) / len(grid.occupied)) / np.log(DIVS[-1] / DIVS[0])
        for category, grid in coarse.items()
    ]
    said = [
        f"From div = {DIVS[0]} to {DIVS[-1]} the occupied voxels grow as div to the power of {min(growth):.2f} to "
        f"{max(growth):.2f}: 1 would be a line, 2 a surface, 3 a solid; fewer points than voxels keep it down.",
        f"Points lie {_span(_offset_mm(coarse), '.1f', 'mm')} from the centres of their voxels at div = {DIVS[0]}, "
        f"{_span(_offset_mm(fine), '.1f', 'mm')} at {DIVS[-1]} (root mean square): so much of the shape is lost.",
        f"{_span(_share(coarse), '.0f', '%')} of the occupied voxels hold more than one point at "
        f"div = {DIVS[0]}, {_span(_share(fine), '.0f', '%')} at {DIVS[-1]}: occupancy loses their counts.",
    ]
    name = _choose_shown(views)
    settings, figures = {"place_on_circle": PLACE, "shown": name}, {"figure-3.6": _draw_resolutions(grids[name])}
    return Report("figure-3.6", "Grids of 16, 24 and 32 voxels a side", rows, said, figures=figures, settings=settings)


def _choose_views(plan: Plan) -> dict[str, View]:
    """A view of the first instance of each category."""
    firsts = {category: sessions[0] for category, sessions in circles.open_instances(plan).items()}
    return {category: circles.take_view(first, PLACE) for category, first in firsts.items()}


def _choose_shown(views: dict[str, View]) -> str:
    return SHOWN if SHOWN in views else next(iter(views))


def _describe_values(category: str, grid: Grid, values: Literal["counts", "occupancy"]) -> Row:
    held = grid.counts if values == "counts" else grid.counts > 0
    return {
        "category": category,
        "voxels hold": values,
        "div": len(grid.counts),
        "points": int(grid.counts.sum()),
        "occupied_voxels": len(grid.occupied),
        "largest_value": int(held.max()),
        "different_values": len(np.unique(held)),
        "shared_percent": 100 * grid.shared,
        "entropy_bits": measure_entropy(held),
    }


def _describe_resolution(category: str, grid: Grid) -> Row:
    return {
        "category": category,
        "div": len(grid.counts),
        "voxel_mm": 1000 * grid.side,
        "points": int(grid.counts.sum()),
        "occupied_voxels": len(grid.occupied),
        "occupied_percent": 100 * len(grid.occupied) / grid.counts.size,
        "most_points": int(grid.occupied.max()),
        "mean_points": float(grid.occupied.mean()),
        "shared_percent": 100 * grid.shared,
        "offset_mm": 1000 * grid.offset,
    }


def _share(grids: Mapping[str, Grid]) -> dict[str, float]:
    """The percentage of each grid's occupied voxels that hold more than one point."""
    return {category: 100 * grid.shared for category, grid in grids.items()}


def _offset_mm(grids: Mapping[str, Grid]) -> dict[str, float]:
    """Each grid's root mean square distance from the points to the centres of their voxels [mm]."""
    return {category: 1000 * grid.offset for category, grid in grids.items()}


def _span(values: Mapping[str, float], spec: str, unit: str) -> str:
    """The least and the largest of the categories' values in words, with their categories."""
    low, high = min(values, key=values.__getitem__), max(values, key=values.__getitem__)
    return f"{values[low]:{spec}} {unit} ({low}) to {values[high]:{spec}} {unit} ({high})"


def _draw_values(view: View, grid: Grid) -> charts.Figure:
    figure, ((seen, counts, occupancy, spread),) = charts.new_figure(1, 4, width=11, height=3)
    draw_view(seen, view, inches=2)
    seen.set_title(f"view, {grid.counts.sum():.0f} points")
    faces = draw_grid(counts, grid.counts, LogNorm(1, max(2, grid.counts.max())))
    counts.set_title("points in each voxel")
    draw_count_bar(figure, counts, faces)
    draw_grid(occupancy, grid.counts)
    occupancy.set_title("occupied or not")
    numbers = np.bincount(grid.occupied.astype(int))[1:]
    spread.bar(np.arange(len(numbers)) + 1, numbers, width=0.8, color=charts.COLORS[0])
    spread.set(xlabel="points in a voxel", ylabel="voxels")
    spread.set_title("voxels by their count")
    return figure


def _draw_resolutions(grids: dict[int, Grid]) -> charts.Figure:
    figure, (row,) = charts.new_figure(1, len(grids), width=9, height=3.2)
    norm = LogNorm(1, max(2, *(grid.counts.max() for grid in grids.values())))
    for axes, (div, grid) in zip(row, grids.items(), strict=True):
        faces = draw_grid(axes, grid.counts, norm)
        axes.set_title(f"div = {div}, voxels of {1000 * grid.side:.1f} mm\n{len(grid.occupied)} occupied")
    draw_count_bar(figure, row[-1], faces)
    return figure
