"""Everything at once by the command, as small as can be, stopped and begun again."""

import json
from dataclasses import replace
from functools import partial

import pytest

from orbitscan.processing.cli import app
from orbitscan.processing.reproduction import STUDIES
from orbitscan.processing.reproduction.overlap import run as overlap_run
from orbitscan.processing.reproduction.overlap import study as overlap
from orbitscan.processing.reproduction.registration import errors, models, run, seconds
from orbitscan.processing.reproduction.views import gallery
from orbitscan.processing.review.figures import style
from orbitscan.recorder import cli as recorder_cli
from orbitscan.recorder.simulation import corpus


@pytest.fixture
def tiny(monkeypatch, tmp_path):
    """Two instances of each category at one height, one object of the five, and cameras of few pixels."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(corpus, "INSTANCES", dict.fromkeys(corpus.INSTANCES, 2))
    monkeypatch.setattr(corpus, "ELEVATIONS_DEG", {1: 30.0})
    monkeypatch.setattr(corpus, "CAMERA", replace(corpus.CAMERA, focal=150.0))
    for module in (run, errors, seconds, models):
        monkeypatch.setattr(module, "OBJECTS", {"robot": 120.0})
    monkeypatch.setattr(run, "FEW", 5)
    monkeypatch.setattr(run, "CIRCLE", 60)
    monkeypatch.setattr(overlap, "OBJECTS", ("robot",))
    monkeypatch.setattr(overlap, "AZIMUTHS_DEG", (10, 20))
    monkeypatch.setattr(overlap_run, "simulate", partial(overlap_run.simulate, focal=120.0))
    monkeypatch.setattr(gallery, "OBJECTS", ("robot",))
    monkeypatch.setattr(gallery, "CATEGORIES", ("bowl",))
    monkeypatch.setattr(gallery, "COLUMNS", 2)
    monkeypatch.setattr(gallery, "simulate", partial(gallery.simulate, focal=120.0))
    monkeypatch.setattr(style, "ENDINGS", ("png",))  # test_figures.py draws both


@pytest.mark.usefixtures("tiny", "open3d")
def test_all_is_made_once_and_again_with_the_same_numbers(monkeypatch, tmp_path, capsys):
    arguments = ["reproduce", "all", "-o", "out", "--fraction", "0.005", "--runs", "1", "--workers", "1"]
    monkeypatch.setattr("sys.argv", ["orbitscan", *arguments])

    def reproduce():
        with pytest.raises(SystemExit) as exit_:
            recorder_cli.run(app, arguments)
        assert exit_.value.code == 0
        return capsys.readouterr().out

    said = reproduce()
    out = tmp_path / "out"
    for name in STUDIES:
        study = json.loads((out / f"{name}.json").read_text())
        assert study["rows"]
        assert study["said"] + study["claims"]
        assert all((out / f"{figure}.png").stat().st_size for figure in study["figures"])
        assert name in said
        assert str(tmp_path) not in json.dumps(study)
    page = (out / "index.html").read_text()
    assert all(f'id="{name}"' in page for name in STUDIES)

    def leave_the_picture(figure, path):
        return [path.with_name(f"{path.name}.{ending}") for ending in style.ENDINGS]

    monkeypatch.setattr(style, "save", leave_the_picture)  # takes most of the time, and no number comes of it
    assert reproduce() == said
