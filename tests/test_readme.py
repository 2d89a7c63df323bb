"""Every command of the README runs, in its order, in a folder as the README assumes it."""

import os
import re
import shlex
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from orbitscan.processing.classification import training
from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.formats import ply
from tests.command import run
from tests.geometry import scan
from tests.viewer import RERUN

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """`scans/` and `things/` with clouds, poses.tum, a recording in `recordings/`; no display is asked for."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "scans").mkdir()
    session = scan(n_views=3, points=6000)
    for view in session.views():
        ply.write(folder / "scans" / f"{view.name}.ply", view.points)
    truth = session.truth()
    lines = [poses.to_tum_line((i + 1) * 10**9, truth[i]) for i in sorted(truth)]
    (folder / "poses.tum").write_text("\n".join(lines))
    mcap_file.write(scan(n_views=2, points=6000), folder / "recordings" / "blob.mcap")
    for category, stretch in (("ball", (1, 1, 1)), ("plank", (1, 1, 0.2))):
        (folder / "things" / category).mkdir(parents=True)
        for i, view in enumerate(session.views()):
            ply.write(folder / "things" / category / f"{i}.ply", view.points[::10] * np.float32(stretch))
    stub = folder / "bin" / "rerun"
    stub.parent.mkdir()
    stub.write_text(f'#!/bin/sh\ncase "$*" in *--headless*) exec {RERUN} "$@" ;; esac\n')  # no display is needed there
    stub.chmod(0o755)
    return folder


def environment(folder):
    path = os.pathsep.join([str(folder / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]])
    return {"PATH": path, "HOME": str(folder), "RERUN_CLI_PATH": str(folder / "bin" / "rerun")}


def test_every_command_runs(folder, request, monkeypatch):
    monkeypatch.setattr(training, "TrainingSettings", partial(training.TrainingSettings, epoch_views=50))
    commands = [line.split("#")[0].strip() for block in blocks("bash") for line in block.splitlines()]
    ours = [shlex.split(command) for command in commands if command and not command.startswith("make ")]
    assert len(ours) >= 9
    no_picture = None
    for words in ours:
        if "--screenshot" in words:
            try:
                request.getfixturevalue("renderer")
            except pytest.skip.Exception as reason:
                no_picture = reason
                continue
        if words[0] == "orbitscan":
            finished = run(*words[1:], cwd=folder, env=environment(folder))
        else:
            everything = os.environ | environment(folder)
            finished = subprocess.run(words, cwd=folder, env=everything, capture_output=True, text=True)
        assert finished.returncode == 0, f"{shlex.join(words)}\n{finished.stdout}{finished.stderr}"
    if no_picture:
        pytest.skip(f"all but the picture: {no_picture}")


def test_the_make_targets_it_names_exist():
    makefile = (Path(__file__).parents[1] / "Makefile").read_text(encoding="utf-8")
    named = set(re.findall(r"`?make ([a-z-]+)", README))
    assert named <= set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))


def test_the_files_it_links_exist():
    linked = re.findall(r"\]\((?!https?:)([^)#]+)\)", README)
    assert linked
    for path in linked:
        assert (Path(__file__).parents[1] / path).exists(), path
