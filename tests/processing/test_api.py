"""`import orbitscan`: what it offers, from a clone and from a wheel in a folder with names of its own."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
import pytest

import orbitscan
from orbitscan.processing.classification.classifier import Classifier
from tests.geometry import scan

ROOT = Path(__file__).parents[2]
FILES = ("__init__.py", "py.typed")


def test_every_name_is_there_and_no_other():
    values = [
        "open",
        "process",
        "with_errors",
        "classify",
        "simulate",
        "read_results",
        "Session",
        "Settings",
        "ScanError",
        "__version__",
    ]
    assert set(orbitscan.__all__) == set(values) <= set(dir(orbitscan))
    assert all(getattr(orbitscan, name) for name in values)
    with pytest.raises(AttributeError, match="has no attribute 'proces'"):
        orbitscan.proces  # noqa: B018


def test_the_import_alone_loads_nothing():
    code = "import sys, orbitscan; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(found.stdout.split())
    assert "orbitscan" in loaded
    assert not {name for name in loaded if name.startswith("orbitscan.")} | ({"numpy", "torch"} & loaded)


def test_classify_takes_a_session_its_views_and_points():
    session = scan(n_views=2)
    points = next(iter(session.views("1"))).points
    together = orbitscan.classify(session)
    assert [view.view for view in together.views] == [0, 1]
    assert orbitscan.classify(session.views()) == together
    assert orbitscan.classify(points).views[0].probabilities == Classifier().classify_view(0, points).probabilities
    assert orbitscan.classify(np.empty((0, 3), np.float32)) is None


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The Python of a new environment with the wheel; the libraries are this environment's, our clone is not."""
    folder = tmp_path_factory.mktemp("wheel")
    build = "import setuptools.build_meta as b, sys; print(b.build_wheel(sys.argv[1]))"
    source = folder / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for name in ("recorder", "processing"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run([sys.executable, "-c", build, folder], cwd=source, capture_output=True, check=True)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "env"], check=True)
    scheme = sysconfig.get_preferred_scheme("prefix")
    paths = {"base": str(folder / "env"), "platbase": str(folder / "env")}
    site = Path(sysconfig.get_path("purelib", scheme, paths))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    # A line in a .pth file adds the folder, and does not read the .pth files in it: not the clone's.
    (site / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")
    for top in (
        "recorder",
        "processing",
    ):  # what is compiled for the clone is compiled for the same sources of the same time
        for path in (ROOT / top).rglob("*"):
            copy = site / "orbitscan" / path.relative_to(ROOT)
            if path.suffix in (".nbi", ".nbc"):
                copy.parent.mkdir(exist_ok=True)
                shutil.copy2(path, copy)
            elif path.is_file() and copy.is_file():
                shutil.copystat(path, copy)
    return Path(sysconfig.get_path("scripts", scheme, paths)) / "python", site


@pytest.fixture
def their_folder(tmp_path):
    """A user's folder, with a package and a module called as the folders of our clone are, and the sample."""
    (tmp_path / "processing").mkdir()
    (tmp_path / "processing" / "__init__.py").write_text("MINE = True\n")
    (tmp_path / "recorder.py").write_text("raise RuntimeError('this is the user\\'s own')\n")
    (tmp_path / "recordings").symlink_to(ROOT / "recordings")
    return tmp_path


def test_the_wheel_holds_every_module_and_data_file(installed):
    _, site = installed
    ours = {path.relative_to(site / "orbitscan") for path in (site / "orbitscan").rglob("*") if path.is_file()}
    expected = {Path(name) for name in FILES}
    for top in ("recorder", "processing"):
        for path in (ROOT / top).rglob("*"):
            if path.suffix in (".py", ".pt", ".html") and "api" not in path.parts:
                expected.add(path.relative_to(ROOT))
    assert {path for path in ours if "__pycache__" not in path.parts} == expected


COMMANDS = """
import sys
from orbitscan.processing.cli import main

for line in (
    "simulate bowl -o bowl.mcap --views 2",
    "classify bowl.mcap",
    "process bowl.mcap -o results --methods icp --model none",
    "reproduce table-5.2 -o reproduction",
):
    sys.argv = ["orbitscan", *line.split()]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, line

import orbitscan.recorder
import processing

assert processing.MINE
print(orbitscan.recorder.__file__)
"""


def test_the_wheel_works_beside_names_of_the_users_own(installed, their_folder):
    """The README's lines, then the command, in a script beside them."""
    python, site = installed
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    (their_folder / "script.py").write_text(block + COMMANDS)
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    finished = subprocess.run([python, "script.py"], cwd=their_folder, env=clean, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    statuses, chordal, *_, where = finished.stdout.splitlines()
    assert statuses == "['ok', 'ok', 'ok']"
    assert float(chordal) < 0.01
    assert Path(where).is_relative_to(site)
    assert (their_folder / "results" / "bowl" / "results.json").is_file()
