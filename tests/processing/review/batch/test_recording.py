"""summary.rrd: the recordings of a batch, worst first, opens without a complaint and says what the table says."""

import subprocess

import numpy as np
import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.results.batch_table import Row
from orbitscan.processing.results.estimates import MethodResult, ViewErrors, ViewEstimate
from orbitscan.processing.results.status import METHODS, Method, Status
from orbitscan.processing.review.batch.recording import conclude, write_batch
from tests import viewer
from tests.processing.results.made import make_folder


def row(name, center_m=None, failed=0, methods=METHODS, views=4):
    """A recording's results as far as a summary looks at them; `center_m` by method."""
    found = {}
    for i, method in enumerate(methods):
        error = None if center_m is None else center_m / (i + 1)
        estimates = [
            ViewEstimate(
                v,
                Status.AMBIGUOUS if v < failed else Status.OK,
                np.eye(4),
                errors=ViewErrors(error, error, error, error),
            )
            for v in range(views)
        ]
        found[Method(method)] = MethodResult.of(estimates, (), None)
    seconds = {"methods": {method: {"total": 1.5} for method in methods}, "total": 6.0}
    return Row(name, "done", None, make_folder(name, seconds, category="robot", views=views, reconstruction=found))


ROWS = [
    row("fine", 1e-4),
    row("worse", 2e-3),
    row("worst", 1e-4, failed=2),
    Row("bad", "failed", "bad: cut | off; mend it"),
]


def curve(path, entity):
    """Rank -> value."""
    found = {}
    for chunk in RrdReader(path).stream().filter(content=entity):
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names:
            values = [cell[0] for cell in batch.column("Scalars:scalars").to_pylist()]
            found |= dict(zip(batch.column("worst_first").to_pylist(), values, strict=True))
    return found


def test_curves_are_those_of_the_recordings_worst_first(tmp_path):
    path = tmp_path / "summary.rrd"
    write_batch(path, "batch", ROWS, None)
    assert curve(path, "/recordings/failed_views/refined") == {1: 2, 2: 0, 3: 0}
    assert curve(path, "/recordings/center_mm/icp") == pytest.approx({1: -1, 2: np.log10(2), 3: -1})
    assert curve(path, "/distribution/center_mm/icp") == pytest.approx({0: np.log10(2), 1: -1, 2: -1})
    assert curve(path, "/distribution/center_mm/refined") == pytest.approx({0: np.log10(0.5), 1: -1.60206, 2: -1.60206})


def test_the_verdict_counts_what_failed():
    assert conclude(ROWS) == (
        "3 of 4 recordings have results; 10 of their 12 views are placed with confidence; 1 failed."
    )


def test_the_same_batch_gives_the_same_recording(tmp_path):
    for name in ("a.rrd", "b.rrd"):
        write_batch(tmp_path / name, "batch", ROWS[:: 1 if name == "a.rrd" else -1], None)
    compared = subprocess.run([viewer.RERUN, "rrd", "compare", tmp_path / "a.rrd", tmp_path / "b.rrd"])
    assert compared.returncode == 0


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize("rows", [ROWS, [ROWS[3]] * 2])
def test_viewer_draws_everything(rows, tmp_path):
    path = tmp_path / "summary.rrd"
    write_batch(path, "batch", rows, None)
    assert subprocess.run([viewer.RERUN, "rrd", "verify", path], capture_output=True).returncode == 0
    with viewer.open_viewer(path) as client:
        assert client.get_state().views
        assert viewer.find_reports(client) == []
