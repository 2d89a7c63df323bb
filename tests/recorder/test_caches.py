"""Caches where neither the installation nor the home folder can be written."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from orbitscan.recorder import kernels
from orbitscan.recorder.caches import find_place_for_matplotlib, temporary_cache

NOWHERE = "/proc/none" if sys.platform == "linux" else os.devnull + "/none"
on_unix = pytest.mark.skipif(os.name == "nt", reason="Windows has a temporary folder for each user")


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """An empty folder for temporary files."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def homeless(monkeypatch):
    for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, NOWHERE)
    monkeypatch.delenv("MPLCONFIGDIR", raising=False)


def test_it_is_the_same_from_run_to_run_and_for_this_user_alone(scratch):
    folder = temporary_cache("kernels")
    assert folder == temporary_cache("kernels")
    assert folder.parent == scratch
    assert os.name == "nt" or folder.stat().st_mode & 0o777 == 0o700


@on_unix
def test_a_folder_that_somebody_else_could_have_filled_is_not_used(scratch):
    ours = temporary_cache("kernels")
    ours.chmod(0o777)
    assert temporary_cache("kernels") != ours
    ours.rmdir()
    (scratch / "theirs").mkdir(mode=0o700)
    ours.symlink_to(scratch / "theirs")
    assert temporary_cache("kernels").resolve() != scratch / "theirs"
    ours.unlink()
    ours.touch(mode=0o600)
    assert temporary_cache("kernels").is_dir()


def test_matplotlib_is_given_a_place_only_where_it_has_none(scratch, homeless, monkeypatch):
    find_place_for_matplotlib()
    assert Path(os.environ.pop("MPLCONFIGDIR")).parent == scratch
    for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, str(scratch))
    find_place_for_matplotlib()
    assert "MPLCONFIGDIR" not in os.environ


def test_without_a_writable_cache_kernels_go_to_a_temporary_one_and_one_line_says_so(tmp_path):
    """A copy of the module, in a folder whose __pycache__ is no folder: as numba sees a read-only installation."""
    shutil.copy(kernels.__file__, tmp_path / "kernels.py")
    (tmp_path / "__pycache__").write_text("")
    (tmp_path / "scratch").mkdir()
    code = (
        "import os, kernels as k; twice = k.kernel(k.double); "
        "print(k.is_kept(twice), twice(4), k.is_kept(twice), os.environ['NUMBA_CACHE_DIR'])"
    )
    with (tmp_path / "kernels.py").open("a") as source:
        source.write("\n\ndef double(x):\n    return 2 * x\n")
    homeless = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"), NOWHERE) | {
        "TMPDIR": str(tmp_path / "scratch")
    }
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"} | homeless
    for kept_before in (False, True):
        finished = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert finished.returncode == 0, finished.stderr
        before, eight, after, folder = finished.stdout.split()
        assert (before, eight, after) == (str(kept_before), "8", "True")
        assert Path(folder).parent == tmp_path / "scratch"
        (line,) = finished.stderr.splitlines()
        assert line.startswith(f"compiled kernels are kept in {folder}")
