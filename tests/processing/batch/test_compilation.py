"""The kernels of the page are compiled once, said so, and all anew where one is missing."""

from orbitscan.processing.batch import compilation
from orbitscan.processing.batch.compilation import ensure_compiled
from orbitscan.recorder.kernels import is_kept, kernels_of


def test_every_kernel_of_the_page_is_kept_and_then_nothing_is_said():
    ensure_compiled(lambda _: None)
    used = kernels_of(*compilation.USED)
    names = {found.__name__ for found in used}
    assert {"_fill_normals", "_describe", "_align_each", "_screen", "rows_around", "symmetric_eigen"} < names
    assert all(map(is_kept, used))
    said = []
    ensure_compiled(said.append)
    assert said == []


def test_where_one_kernel_is_not_kept_compilation_is_announced(monkeypatch):
    said = []
    monkeypatch.setattr(compilation, "is_kept", lambda found, since: found.__name__ != "solve")
    monkeypatch.setattr(compilation, "compile_kernels", lambda: said.append("compiled"))
    ensure_compiled(said.append)
    assert said == ["Compiling the kernels: once on this machine, about 10 s ...", "compiled"]
