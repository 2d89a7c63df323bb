"""A changed result comes with a changed version: the version is part of the key by which `process` skips what is done.

Where numbers are meant to change: raise the version in pyproject.toml, install, and run `python -m tests.test_version`.
"""

import json
from importlib.metadata import version
from pathlib import Path

import numpy as np

from orbitscan.processing.pipeline import process
from orbitscan.processing.results.status import METHODS
from orbitscan.recorder import mcap_file

SAMPLE = Path(__file__).parents[1] / "recordings" / "robot.mcap"
REFERENCE = Path(__file__).parent / "reference" / "robot_results.json"
VIEWS = "0:4"
TOLERANCE = 1e-6  # metres, and of a rotation's entries: another processor sums in another order


def measure():
    """The version, and what each method makes of a few views of the sample."""
    session = mcap_file.read(SAMPLE)
    *_, result = process(session.views(VIEWS), session.info, methods=METHODS)
    views = {
        method: [
            {"status": view.status, "T_0_i": None if view.T_0_i is None else view.T_0_i.round(9).tolist()}
            for view in found.views
        ]
        for method, found in result.reconstruction.items()
    }
    return {"version": version("orbitscan"), "views": views}


def test_the_results_are_those_of_this_version():
    reference, found = json.loads(REFERENCE.read_text(encoding="utf-8")), measure()
    assert found["version"] == reference["version"], f"new results of this version are wanted: {__doc__}"
    assert list(found["views"]) == list(reference["views"])
    for method, views in found["views"].items():
        for view, before in zip(views, reference["views"][method], strict=True):
            same = np.allclose(view["T_0_i"], before["T_0_i"], atol=TOLERANCE)
            assert (view["status"], same) == (before["status"], True), f"{method}: {__doc__}"


if __name__ == "__main__":
    REFERENCE.write_text(json.dumps(measure(), indent=1) + "\n", encoding="utf-8")
