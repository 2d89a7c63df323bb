"""A model's file: whole or not at all, and never trusted."""

import pickle
import zipfile
from dataclasses import fields, replace

import pytest
import torch

from orbitscan.processing.classification.checkpoint import Calibration, Checkpoint, UnreadableModel, load, save
from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.recorder.exceptions import UnwritableOutput

STRUCTURE = "C(4,3)-P(2)-FC(3)"


@pytest.fixture(scope="module")
def model():
    torch.manual_seed(0)
    network = Network(STRUCTURE, 3, div=8, orientations=4)
    return Checkpoint(
        weights=network.state_dict(),
        structure=STRUCTURE,
        categories=("ball", "plank", "stick"),
        voxels=VoxelSettings(div=8, values="density", trim=0.01),
        orientations=(1, 4, 2),
        calibration=Calibration(1.5, -2.0, -1.0, (-3.0, -2.0, -1.0), (0.4, 0.5, 0.6)),
        settings={"epochs": 3},
        metrics={"test": {"accuracy": 0.5}},
        fingerprint="abc",
        seed=7,
    )


@pytest.fixture
def path(model, tmp_path):
    save(model, tmp_path / "model.pt")
    return tmp_path / "model.pt"


def test_a_model_comes_back_as_it_was(model, path):
    found = load(path)
    for name, weight in model.weights.items():
        assert torch.equal(found.weights[name], weight)
    assert replace(found, weights={}).__dict__ == replace(model, weights={}).__dict__
    grids = torch.rand(2, 1, 8, 8, 8)
    assert torch.equal(found.network()(grids)[0], model.network()(grids)[0])
    assert [file.name for file in path.parent.iterdir()] == ["model.pt"]


class Malicious:
    def __reduce__(self):
        return print, ("run",)


def change(path, **values):
    torch.save(torch.load(path, weights_only=True) | values, path)


def drop(path, name):
    content = torch.load(path, weights_only=True)
    torch.save({key: value for key, value in content.items() if key != name}, path)


def flip(path):
    """One bit of a weight."""
    content = bytearray(path.read_bytes())
    content[content.index(load(path).weights["categories.weight"].numpy().tobytes())] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (lambda path: path.unlink(), "no such file"),
        (lambda path: path.write_bytes(path.read_bytes()[:-2000]), "is damaged or no model"),
        (lambda path: path.write_text("a text"), "is damaged or no model"),
        (lambda path: path.write_bytes(pickle.dumps(Malicious())), "is damaged or no model"),
        (lambda path: torch.save(Malicious(), path), "is damaged or no model"),
        (lambda path: torch.save({"weights": {}}, path), "is no model of orbitscan"),
        (lambda path: torch.save([1, 2], path), "is no model of orbitscan"),
        (lambda path: change(path, format_version=9), "is of format 9, not 1"),
        (lambda path: change(path, structure="C(5,3)-P(2)-FC(3)"), "its weights do not fit the structure"),
        (lambda path: change(path, structure="nonsense"), "its weights do not fit the structure"),
        (lambda path: change(path, categories=["a", "b"]), "its weights do not fit the structure"),
        (lambda path: change(path, voxels={"div": "many"}), "its weights do not fit the structure"),
        (lambda path: change(path, calibration=3), "its weights do not fit the structure"),
        (lambda path: change(path, weights={}), "its weights do not fit the structure"),
        (lambda path: change(path, weights=3), "its weights do not fit the structure"),
        (lambda path: change(path, orientations=(1, 4)), "its weights do not fit the structure"),
        (lambda path: change(path, calibration={"size_means": (1.0,)}), "its weights do not fit the structure"),
        (lambda path: change(path, calibration={"size_means": (1.0,) * 3}), "its weights do not fit the structure"),
        (lambda path: change(path, calibration={"temperature": 0.0}), "its weights do not fit the structure"),
        (lambda path: change(path, voxels={"div": 2}), "its weights do not fit the structure"),
        (lambda path: change(path, format_version=torch.zeros(2)), "is of format"),
        (lambda path: path.write_bytes(b""), "is damaged or no model"),
        (lambda path: zipfile.ZipFile(path, "w").close(), "is damaged or no model"),
        (lambda path: torch.save(torch.nn.Linear(2, 2), path), "is damaged or no model"),
        (lambda path: torch.save(torch.nn.Linear(2, 2).state_dict(), path), "is no model of orbitscan"),
        (lambda path: flip(path), "is damaged or no model"),
        *((lambda path, name=f.name: drop(path, name), "is no model of orbitscan") for f in fields(Checkpoint)),
    ],
)
def test_what_is_no_model_is_refused_in_a_sentence(path, spoil, problem, capsys):
    spoil(path)
    with pytest.raises(UnreadableModel, match=problem) as caught:
        load(path)
    assert "\n" not in str(caught.value)
    assert capsys.readouterr().out == ""  # no code that came along has run


def test_a_place_that_cannot_be_written(model, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        save(model, tmp_path / "file" / "model.pt")
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


def test_a_write_that_breaks_off_leaves_the_older_model(model, path, monkeypatch):
    def full(content, part):
        part.write_bytes(b"begun")
        raise OSError(28, "No space left on device")

    before = path.read_bytes()
    monkeypatch.setattr(torch, "save", full)
    with pytest.raises(UnwritableOutput, match=r"cannot be written \(No space left on device\); choose another place"):
        save(model, path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["model.pt"]


def test_a_folder_in_the_files_place_is_left_alone(model, tmp_path):
    (tmp_path / "model.pt").mkdir()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        save(model, tmp_path / "model.pt")
    assert [file.name for file in tmp_path.iterdir()] == ["model.pt"]


def test_folders_are_made_and_the_name_is_kept(model, tmp_path):
    save(model, tmp_path / "a" / "b" / "model")
    assert load(tmp_path / "a" / "b" / "model").fingerprint == "abc"


def test_weights_of_half_precision_classify_in_single(model, path):
    save(replace(model, weights={name: weight.half() for name, weight in model.weights.items()}), path)
    network = load(path).network()
    assert {weight.dtype for weight in network.state_dict().values()} == {torch.float32}
    assert not network.training


def test_the_packaged_model_is_small_and_knows_the_ten_categories():
    from orbitscan.processing.classification import PACKAGED
    from orbitscan.recorder.simulation.objects import CATEGORIES

    assert PACKAGED.stat().st_size < 1_000_000
    found = load()
    assert found.categories == CATEGORIES
    assert found.calibration.threshold > -torch.inf
