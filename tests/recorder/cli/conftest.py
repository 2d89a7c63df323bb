"""The recorder's commands in a folder of their own, scans to convert, a recording."""

import json

import numpy as np
import pytest
import typer

from orbitscan.recorder import cli, mcap_file, poses
from tests.geometry import scan

SESSION = scan(n_views=5, step_deg=30, points=6000)


@pytest.fixture
def orbitscan(capsys, tmp_path, monkeypatch):
    """Runs a command line in a folder of its own; gives its exit status, standard output and error output."""
    monkeypatch.chdir(tmp_path)
    app = typer.Typer(pretty_exceptions_enable=False, no_args_is_help=True)
    for command in cli.COMMANDS:
        app.command()(command)

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            cli.run(app, [str(argument) for argument in arguments])
        printed = capsys.readouterr()
        assert "Traceback" not in printed.err
        return ended.value.code, printed.out, printed.err

    return run


@pytest.fixture
def scans(tmp_path):
    """A folder of five clouds with inverted poses, as a world-to-camera file has them."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for view in SESSION.views():
        np.save(folder / f"scan{view.index}.npy", view.points)
    (folder / "poses.json").write_text(json.dumps([poses.invert(T).tolist() for T in SESSION.truth().values()]))
    return folder


@pytest.fixture
def recording(tmp_path):
    mcap_file.write(SESSION, tmp_path / "blob.mcap")
    return tmp_path / "blob.mcap"
