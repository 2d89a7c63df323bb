"""The kernels of the page are compiled once, said so, and anew where one is missing."""

import os
from pathlib import Path

from orbitscan.processing.batch import compilation
from orbitscan.processing.batch.compilation import compile_kernels, ensure_compiled
from orbitscan.recorder.kernels import is_kept, kernels_of


def test_every_kernel_of_the_page_is_kept_and_then_nothing_is_said(caplog):
    ensure_compiled()
    used = kernels_of(*compilation.USED)
    names = {found.__name__ for found in used}
    assert {"_fill_normals", "_describe", "_align_each", "_screen", "rows_around", "symmetric_eigen"} < names
    assert all(map(is_kept, used))
    caplog.clear()
    ensure_compiled()
    assert caplog.messages == []


def test_where_one_kernel_is_not_kept_compilation_is_announced(monkeypatch, caplog):
    compiled = []
    monkeypatch.setattr(compilation, "is_kept", lambda found, since: found.__name__ != "solve")
    monkeypatch.setattr(compilation, "compile_kernels", lambda: compiled.append(True))
    ensure_compiled()
    assert caplog.messages == ["Compiling the kernels: once on this machine, about 10 s ..."]
    assert compiled == [True]


def test_what_another_process_has_just_compiled_is_left_alone():
    """Two that start at once on a new machine would else take each other's machine code, and compile for ever."""
    ensure_compiled()
    folder = Path(kernels_of(*compilation.USED)[0].stats.cache_path)
    fresh, stale = folder / "fresh.test.nbc", folder / "stale.test.nbc"
    fresh.touch()
    stale.touch()
    os.utime(stale, (0, 0))
    compile_kernels()
    assert (fresh.exists(), stale.exists()) == (True, False)
    fresh.unlink()
