"""Recordings that several tests read."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import rerun as rr

from tests.processing.review.made_results import Results, write_review


@pytest.fixture(autouse=True)
def strict() -> Iterator[None]:
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture(scope="module")
def reviewed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    """A recording with ground truth, and what went into it."""
    path = tmp_path_factory.mktemp("review") / "review.rrd"
    return path, write_review(path)
