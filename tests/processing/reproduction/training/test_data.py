"""The views of a study: table 3.1's split, gathered once, of the virtual corpus or a folder like Washington's."""

import numpy as np
import pytest

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.training import data
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.simulation import corpus

SMALL = {"bowl": 2, "cell_phone": 3}


@pytest.fixture
def small(monkeypatch):
    """A corpus of two categories at one height."""
    monkeypatch.setattr(corpus, "INSTANCES", SMALL)
    monkeypatch.setattr(corpus, "ELEVATIONS_DEG", {1: 30.0})


def write_frames(folder, categories, frames=3):
    """Frames of the Washington dataset: CATEGORY_INSTANCE_VIDEO_FRAME.pcd, ASCII."""
    rng = np.random.default_rng(0)
    header = (
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 20\nHEIGHT 1\nPOINTS 20\nDATA ascii\n"
    )
    for category in categories:
        for instance in (1, 2):
            place = folder / category / f"{category}_{instance}"
            place.mkdir(parents=True)
            for frame in range(1, frames + 1):
                lines = [
                    " ".join(map(str, row)) for row in (rng.normal(0, 0.1, (20, 3)) + np.array([0, 1, 0])).round(4)
                ]
                (place / f"{category}_{instance}_1_{frame}.pcd").write_text(header + "\n".join(lines) + "\n")


@pytest.mark.usefixtures("small")
def test_the_virtual_corpus_is_recorded_and_gathered_once(tmp_path):
    plan = Plan(tmp_path, fraction=0.01)  # 2 of 200 views
    first = data.provide(plan)
    views = data.load(first)
    assert len(views) == 2 * sum(SMALL.values())
    assert views.names == tuple(SMALL)
    assert views.fingerprint == first.fingerprint
    assert not np.isnan(views.turns).any()
    for path in (tmp_path / "corpus-every-100").iterdir():
        path.unlink()
    assert data.provide(plan) == first  # from the gathered views alone


@pytest.mark.usefixtures("small")
def test_the_last_instance_of_each_category_is_tested(tmp_path):
    views = data.load(data.provide(Plan(tmp_path, fraction=0.01)))
    rows = data.split(views)
    assert set(views.units[rows.validation]) == {"bowl/2", "cell_phone/3"}
    assert set(views.units[rows.train]) == {"bowl/1", "cell_phone/1", "cell_phone/2"}
    assert not len(rows.test)


def test_a_dataset_is_thinned_and_only_the_categories_count(tmp_path, monkeypatch):
    monkeypatch.setattr(corpus, "INSTANCES", SMALL)
    write_frames(tmp_path / "rgbd", ["bowl", "cell_phone", "keyboard"], frames=4)
    views = data.load(data.provide(Plan(tmp_path / "out", fraction=0.5, dataset=tmp_path / "rgbd")))
    assert len(views) == 2 * 2 * 2
    assert set(np.unique(views.categories)) == {0, 1}


def test_another_dataset_in_the_same_folder_is_read_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(corpus, "INSTANCES", SMALL)
    found = []
    for name, frames in (("a", 2), ("b", 3)):
        write_frames(tmp_path / name, SMALL, frames)
        found.append(data.load(data.provide(Plan(tmp_path / "out", dataset=tmp_path / name))))
    assert [len(views) for views in found] == [8, 12]


def test_a_dataset_without_a_category_is_refused(tmp_path):
    write_frames(tmp_path, ["bowl"])
    with pytest.raises(InvalidOption, match="holds no apple"):
        data.provide(Plan(tmp_path / "out", dataset=tmp_path))


def test_a_damaged_file_of_views_is_made_again(tmp_path, monkeypatch):
    monkeypatch.setattr(corpus, "INSTANCES", SMALL)
    write_frames(tmp_path / "rgbd", SMALL)
    plan = Plan(tmp_path / "out", dataset=tmp_path / "rgbd")
    first = data.provide(plan)
    first.path.write_bytes(first.path.read_bytes()[:500])
    assert data.provide(plan) == first
