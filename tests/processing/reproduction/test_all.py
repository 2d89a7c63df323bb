"""Everything at once by the command, as small as can be, stopped and begun again."""

import json

import pytest

from orbitscan.processing.cli import app
from orbitscan.processing.reproduction import (
    STUDIES,
    gallery,
    models,
    overlap,
    registration,
    registration_errors,
    registration_runs,
)
from orbitscan.recorder import cli as recorder_cli
from orbitscan.recorder import corpus


@pytest.fixture
def tiny(monkeypatch, tmp_path):
    """Two instances of each category at one height, and one object of the five."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(corpus, "INSTANCES", dict.fromkeys(corpus.INSTANCES, 2))
    monkeypatch.setattr(corpus, "ELEVATIONS_DEG", {1: 30.0})
    for module in (registration_runs, registration_errors, registration, models):
        monkeypatch.setattr(module, "OBJECTS", {"robot": 200.0})
    monkeypatch.setattr(registration_runs, "FEW", 6)
    monkeypatch.setattr(registration_runs, "CIRCLE", 60)
    monkeypatch.setattr(overlap, "OBJECTS", ("robot",))
    monkeypatch.setattr(overlap, "AZIMUTHS_DEG", (10, 20))
    monkeypatch.setattr(gallery, "OBJECTS", ("robot",))
    monkeypatch.setattr(gallery, "CATEGORIES", ("bowl",))


@pytest.mark.usefixtures("tiny", "open3d")
def test_all_is_made_once_and_again_with_the_same_numbers(monkeypatch, tmp_path, capsys):
    arguments = ["reproduce", "all", "-o", "out", "--fraction", "0.005", "--runs", "1", "--workers", "1"]
    monkeypatch.setattr("sys.argv", ["orbitscan", *arguments])
    said = []
    for _ in range(2):
        with pytest.raises(SystemExit) as exit_:
            recorder_cli.run(app, arguments)
        said.append(capsys.readouterr().out)
        assert exit_.value.code == 0
    out = tmp_path / "out"
    assert said[0] == said[1]
    for name in STUDIES:
        study = json.loads((out / f"{name}.json").read_text())
        assert study["rows"]
        assert study["said"]
        assert all(
            (out / f"{figure}.{ending}").stat().st_size for figure in study["figures"] for ending in ("png", "svg")
        )
        assert name in said[0]
        assert str(tmp_path) not in json.dumps(study)
    page = (out / "index.html").read_text()
    assert all(f'id="{name}"' in page for name in STUDIES)
