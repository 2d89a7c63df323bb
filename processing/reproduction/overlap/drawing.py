"""Pictures of the overlap study: success against the overlap, against the start, and against both."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.overlap.run import METHODS
from orbitscan.processing.reproduction.overlap.trials import OVERLAPS, Trial, choose, interval, mean, within


def draw_success(
    trials: Sequence[Trial],
    near: Sequence[Trial],
    thesis: Sequence[Trial],
    azimuths: Sequence[int],
    starts: Sequence[int],
) -> charts.Figure:
    """Success against the overlap, against the start of near views, and the thesis's method against both."""
    figure, (row,) = charts.new_figure(1, 3, width=12, height=3.8)
    places = [(low + high) / 2 for low, high in OVERLAPS]
    _draw_lines(row[0], places, lambda method, i: within(choose(trials, method=method), *OVERLAPS[i]))
    row[0].set_xlabel("overlap of the views [%], all starts")
    row[0].set_xticks([0, *(high for _, high in OVERLAPS)])
    _draw_lines(row[1], starts, lambda method, i: choose(near, method=method, start_deg=starts[i]))
    row[1].set_xlabel(f"turn of the start [degrees], views up to {max(trial['azimuth_deg'] for trial in near)} apart")
    row[1].set_xticks(starts)
    _draw_map(row[2], thesis, azimuths, starts)
    charts.legend_below(figure, row[0])
    return figure


def _draw_lines(axes: charts.Axes, x: Sequence[float], find: Callable[[str, int], list[Trial]]) -> None:
    """A line for each method with Wilson's intervals, side by side; no point where there is no trial."""
    aside = 0.012 * (max(x) - min(x))
    for i, method in enumerate(METHODS):
        known = [(place, found) for j, place in enumerate(x) if (found := find(method, j))]
        shares = np.array([100 * mean(found, "success") for _, found in known])
        ends = np.array([interval(found) for _, found in known])
        places = [place + (i - (len(METHODS) - 1) / 2) * aside for place, _ in known]
        line: dict[str, Any] = {"color": charts.COLORS[i], "linestyle": charts.LINES[i], "marker": charts.MARKERS[i]}
        whiskers = np.abs(ends.T - shares)
        axes.errorbar(places, shares, whiskers, label=method, markersize=4, elinewidth=0.8, capsize=2, **line)
    axes.set_ylabel("success [%]")
    axes.set_ylim(-3, 103)


def _draw_map(axes: charts.Axes, trials: Sequence[Trial], azimuths: Sequence[int], starts: Sequence[int]) -> None:
    shares = np.array(
        [[100 * mean(choose(trials, azimuth_deg=a, start_deg=s), "success") for a in azimuths] for s in starts]
    )
    charts.draw_shares(axes, shares, np.isfinite(shares), fontsize=8, aspect="auto")
    axes.set_xticks(range(len(azimuths)), list(map(str, azimuths)))
    axes.set_yticks(range(len(starts)), list(map(str, starts)))
    axes.set(xlabel="views apart [degrees]", ylabel="turn of the start [degrees]")
    axes.set_title(f"{trials[0]['method']}: success [%]", fontsize=9)
