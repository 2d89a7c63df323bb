"""The command `view`: what it hands to the viewer."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ORBITSCAN = Path(sys.executable).with_name("orbitscan")


def run(*arguments, cwd, env=None):
    return subprocess.run(
        [ORBITSCAN, *map(str, arguments)], cwd=cwd, env=os.environ | (env or {}), capture_output=True, text=True
    )


@pytest.fixture
def folder(tmp_path):
    """Files of the names that `process` writes."""
    (tmp_path / "out" / "blob").mkdir(parents=True)
    (tmp_path / "out" / "blob" / "review.rrd").write_bytes(b"")
    (tmp_path / "blob.mcap").write_bytes(b"")
    return tmp_path


def test_view_hands_the_review_to_the_viewer(folder, tmp_path):
    viewer = tmp_path / "rerun"
    viewer.write_text('#!/bin/sh\necho "$@"\n')
    viewer.chmod(0o755)
    path = {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    assert "out/blob/review.rrd" in run("view", "out/blob", cwd=folder, env=path).stdout
    assert "out/blob/review.rrd" in run("view", "out", cwd=folder, env=path).stdout
    assert "blob.mcap" in run("view", "blob.mcap", cwd=folder, env=path).stdout
    assert run("view", "nowhere", cwd=folder, env=path).returncode == 2
