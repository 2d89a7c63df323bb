"""The commands `train` and `classify`: what they write, print and refuse."""

import json
import subprocess
import sys
from dataclasses import asdict, replace

import numpy as np
import pytest
import torch

from orbitscan.processing.classification import checkpoint
from orbitscan.processing.classification.labelled_views import gather, split_views
from orbitscan.processing.classification.training import THESIS, TrainingSettings, train
from orbitscan.processing.settings import read_settings
from orbitscan.recorder import mcap_file
from orbitscan.recorder.formats import ply
from tests.command import run, start
from tests.processing.classification import toys

SMALL = 'structure = "C(4,3,2)-P(2)-FC(3)"\nepochs = 2\nepoch_views = 50\n[voxels]\ndiv = 12\nvalues = "density"\n'


def refuse(folder, *arguments):
    """The one sentence that the command says before it exits with status 2."""
    finished = run(*arguments, cwd=folder)
    (sentence,) = finished.stderr.splitlines()
    assert finished.returncode == 2
    return sentence


@pytest.fixture
def one_thread():
    """torch on one thread, as the commands of these tests: sums of another order round to other last bits."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A folder with recordings of three shapes, and a model trained on them."""
    folder = tmp_path_factory.mktemp("trained")
    for session in toys.sessions(instances=4, views=3):
        mcap_file.write(session, folder / "toys" / f"{session.info.name}.mcap")
    (folder / "small.toml").write_text(SMALL)
    options = ("--settings", "small.toml", "--test", "last", "--device", "cpu")
    return folder, run("train", "toys", "-o", "toys.pt", *options, cwd=folder)


def test_train_writes_a_model_and_its_review_and_says_how_it_went(trained):
    folder, finished = trained
    assert finished.returncode == 0, finished.stderr
    assert {path.name for path in folder.iterdir()} == {"toys", "small.toml", "toys.pt", "toys.rrd"}
    lines = finished.stdout.splitlines()
    assert lines[0] == (
        "3 categories: 6 instances (18 views) train, 3 instances (9 views) validate, 3 instances (9 views) test"
    )
    assert [line.split()[:2] for line in lines[1:3]] == [["epoch", "1"], ["epoch", "2"]]
    assert lines[4].startswith("test: views 9, loss ")
    assert lines[-1] == "next: orbitscan classify SESSION.mcap --model toys.pt, or: orbitscan view toys.rrd"
    model = checkpoint.load(folder / "toys.pt")
    assert model.settings["epochs"] == 2
    assert model.voxels.div == 12


def test_a_stopped_training_goes_on_where_it_was(trained, one_thread):
    folder, _ = trained
    paths = sorted((folder / "toys").glob("*.mcap"))
    settings = read_settings(folder / "small.toml", TrainingSettings)
    views = gather(map(mcap_file.read, paths), trim_share=settings.voxels.trim)
    state = folder / "resumed.pt.state"
    stopped = train(views, split_views(views, "last", "last"), settings, state=state)
    next(stopped)
    stopped.close()
    content = checkpoint.read(state)
    content["records"][0]["views_per_second"] = 123456.0  # as no epoch that is run now would say
    checkpoint.write(content, state)
    options = ("--settings", "small.toml", "--test", "last", "--device", "cpu")
    finished = run("train", "toys", "-o", "resumed.pt", *options, cwd=folder)
    assert finished.returncode == 0, finished.stderr
    first, second = (line for line in finished.stdout.splitlines() if line.startswith("epoch"))
    assert first.endswith("123456 views/s")
    assert second.startswith("epoch   2")
    assert not second.endswith("123456 views/s")
    whole, resumed = (checkpoint.load(folder / name) for name in ("toys.pt", "resumed.pt"))
    assert all(torch.equal(whole.weights[name], resumed.weights[name]) for name in whole.weights)
    assert {path.name for path in folder.glob("resumed*")} == {"resumed.pt", "resumed.rrd"}


def test_the_command_line_wins_over_a_preset(trained):
    folder, _ = trained
    options = ("--settings", "thesis", "--structure", "C(2,5,4)-FC(3)", "--epochs", "1", "--init", "kmeans-pca")
    finished = run("train", "toys", "-o", "thesis.pt", *options, "--every", "2", cwd=folder)
    assert finished.returncode == 0, finished.stderr
    expected = replace(THESIS, structure="C(2,5,4)-FC(3)", epochs=1, init="kmeans-pca")
    assert checkpoint.load(folder / "thesis.pt").settings == asdict(expected)
    assert "9 instances (18 views) train" in finished.stdout


def test_other_things_and_sides_are_learnt(trained):
    """In a process of its own, which finds what it needs without the imports of other tests."""
    folder, _ = trained
    known = [f"toys/{name}_{i}.mcap" for name in ("ball", "plank") for i in (1, 2)]
    options = ("--settings", "small.toml", "--structure", "C(4,3,2)-FC(2)", "--orientation")
    finished = start("train", *known, "--unknown", "toys/stick_1.mcap", "-o", "open.pt", *options, cwd=folder)
    assert finished.returncode == 0, finished.stderr
    model = checkpoint.load(folder / "open.pt")
    assert (model.categories, model.orientations) == (("ball", "plank"), (1, 1))
    assert model.settings["augmentation"]["turn_deg"] == 0  # a turned view shows another side
    assert finished.stdout.startswith("2 categories: 3 instances (9 views) train, 2 instances (6 views) validate")


def test_what_of_a_recording_is_lost_is_said(trained):
    folder, _ = trained
    whole = (folder / "toys" / "ball_1.mcap").read_bytes()
    (folder / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    finished = run("classify", "cut.mcap", "--model", "toys.pt", "--json", cwd=folder)
    assert finished.returncode == 1
    assert finished.stderr == "cut.mcap: the file is cut or damaged at its end; views 1-2 unreadable\n"
    assert [view["view"] for view in json.loads(finished.stdout)["views"]] == [0]


def test_classify_answers_for_a_recording_and_for_a_cloud(trained):
    folder, _ = trained
    finished = run("classify", "toys/ball_1.mcap", "--model", "toys.pt", cwd=folder)
    assert finished.returncode == 0, finished.stderr
    lines = finished.stdout.splitlines()
    assert [line.split()[:2] for line in lines[:3]] == [["view", "0"], ["view", "1"], ["view", "2"]]
    assert "fused over 3 views" in lines[3]
    points = next(iter(mcap_file.read(folder / "toys" / "ball_1.mcap").views())).points
    ply.write(folder / "ball.ply", points)
    (folder / "ball.csv").write_text("a,px,py,pz\n" + "".join(f"0,{x},{y},{z}\n" for x, y, z in points * 1000))
    fields = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 200\nHEIGHT 1\nPOINTS 200\nDATA ascii\n"
    )
    (folder / "ball.pcd").write_text(fields + "".join(f"{x} {y} {z}\n" for x, y, z in points))
    answers = [
        json.loads(run("classify", *arguments, "--model", "toys.pt", "--json", cwd=folder).stdout)["views"][0]
        for arguments in (
            ("toys/ball_1.mcap", "--views", "0,"),
            ("ball.ply",),
            ("ball.pcd",),
            ("ball.csv", "--units", "mm", "--columns", "px,py,pz"),
        )
    ]
    assert list(answers[0]["probabilities"]) == ["ball", "plank", "stick"]
    for answer in answers[1:]:
        assert answer["probabilities"] == pytest.approx(answers[0]["probabilities"], abs=0.02)


def test_millimetres_taken_for_metres_are_noticed(trained):
    folder, _ = trained
    points = next(iter(mcap_file.read(folder / "toys" / "ball_1.mcap").views())).points
    ply.write(folder / "mm.ply", points * 1000)
    finished = run("classify", "mm.ply", "--model", "toys.pt", cwd=folder)
    assert "mm.ply: unknown" in finished.stdout
    assert "is not the size of any category: are --units and --scale right?" in finished.stdout


def test_the_packaged_model_answers_without_open3d(trained):
    folder, _ = trained
    code = (
        "import sys; from orbitscan.processing.cli import app; "
        "app(['classify', 'toys/ball_1.mcap'], standalone_mode=False); "
        "assert 'open3d' not in sys.modules and 'rerun' not in sys.modules and 'numba' not in sys.modules"
    )
    finished = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr


def test_views_of_one_instance_may_be_split_and_it_says_so(trained):
    folder, _ = trained
    chosen = ("toys/ball_1.mcap", "toys/plank_1.mcap", "toys/stick_1.mcap", "--settings", "small.toml")
    refused = run("train", *chosen, "-o", "views.pt", cwd=folder)
    assert refused.returncode == 2
    assert "ball: of its 1 instance none is left to train on; " in refused.stderr
    finished = run("train", *chosen, "-o", "views.pt", "--split", "views", cwd=folder)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.startswith("split by views: training and test show the same things")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("toys", "--structure", "C(4,3)-FC(7)"), "has 7 outputs for 3 categories; end it with FC(3)"),
        (("toys", "--structure", "C(4"), "is no layer; write layers as in"),
        (("toys", "--device", "abacus"), "--device abacus: not a device; give auto, cpu or cuda"),
        (("toys", "--validate", "some"), "--validate some: chooses nothing"),
        (("toys", "--test", "100"), "of its 4 instances none is left to train on"),
        (("toys", "--settings", "wrong.toml"), "there is no setting 'epoch'"),
        (("toys/ball_1.mcap", "toys/ball_2.mcap"), "ball: is the only category; give recordings of another one"),
        (("unlabelled.mcap",), "ball_1: does not say what it shows; convert it with 'orbitscan convert --category'"),
        (("empty",), "the folder holds no recording"),
        (("toys", "--unknown", "nowhere"), "nowhere: no such file"),
        (("toys", "--device", "meta"), "--device meta: not a device; give auto, cpu or cuda"),
        (("toys", "--device", "cuda:99"), "--device cuda:99: "),
        (("toys", "--init", "dcae", "--structure", "FC(3)"), "has no convolution to pretrain"),
        (("toys", "--validate", "0"), "leaves nothing to validate"),
        (("toys", "-o", "toys"), "toys: is a folder; name a file, such as model.pt"),
        (("toys", "-o", "wrong.rrd"), "wrong.rrd: is the name of a recording or a review; let the model's end with"),
        (("toys", "-o", "wrong.mcap"), "wrong.mcap: is the name of a recording or a review"),
    ],
)
def test_wrong_input_of_train_is_one_sentence(trained, arguments, problem):
    folder, _ = trained
    mcap_file.write(toys.session("ball", 1, category=False), folder / "unlabelled.mcap")
    (folder / "wrong.toml").write_text("epoch = 3\n")
    (folder / "empty").mkdir(exist_ok=True)
    assert problem in refuse(folder, "train", "-o", "wrong.pt", *arguments)
    assert {path.name for path in folder.glob("wrong*")} == {"wrong.toml"}
    assert not list(folder.glob("*.part*")) + list(folder.glob("*.state"))


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("nothing.ply",), "nothing.ply: no such file"),
        (("toys",), "toys: is a folder; name one cloud"),
        (("empty.ply",), "empty.ply: too few finite points to tell anything"),
        (("nan.ply",), "nan.ply: too few finite points to tell anything"),
        (("cloud.ply", "--model", "cut.pt"), "cut.pt: is damaged or no model"),
        (("cloud.ply", "--model", "other.pt"), "its weights do not fit the structure it names"),
        (("cloud.ply", "--model", "nothing.pt"), "nothing.pt: no such file"),
        (("cloud.ply", "--model", "toys"), "toys: no such file; name a model made by 'orbitscan train'"),
        (("cloud.ply", "--axes", "XYZ"), "XYZ"),
        (("cloud.ply", "--scale", "0"), "--scale 0: not a positive number"),
        (("cloud.ply", "--columns", "x,y"), "--columns x,y: not three names; write those of x, y and z"),
        (("cloud.ply", "--columns", "x,y,z"), "cloud.ply is no text file; leave it out"),
        (("toys/ball_1.mcap", "--units", "mm"), "--units mm: a recording says it itself; leave it out"),
        (("toys/ball_1.mcap", "--views", "7:"), "--views 7:: selects no view"),
    ],
)
def test_wrong_input_of_classify_is_one_sentence(trained, arguments, problem):
    folder, _ = trained
    points = toys.cloud("ball", np.random.default_rng(0))
    ply.write(folder / "cloud.ply", points)
    ply.write(folder / "empty.ply", points[:0])
    ply.write(folder / "nan.ply", points * np.float32(np.nan))
    whole = (folder / "toys.pt").read_bytes()
    (folder / "cut.pt").write_bytes(whole[: len(whole) // 2])
    torch.save(torch.load(folder / "toys.pt", weights_only=True) | {"structure": "C(9,3)-FC(3)"}, folder / "other.pt")
    assert problem in refuse(folder, "classify", *arguments)
