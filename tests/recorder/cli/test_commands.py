"""All commands of the recorder: their help, their exit status."""

import logging
import subprocess
import sys

import pytest
import typer

from orbitscan.recorder import cli, mcap_file


@pytest.mark.parametrize("arguments", ["convert", "convert scans", "info", "nonsense", "convert s -o x --units inch"])
def test_wrong_usage_is_status_2(orbitscan, arguments):
    status, out, err = orbitscan(*arguments.split())
    assert (status, out) == (2, "")
    assert "Usage: orbitscan" in err


def test_an_interrupt_ends_quietly(orbitscan, monkeypatch, recording):
    def interrupted(path):
        raise KeyboardInterrupt

    monkeypatch.setattr(mcap_file, "read", interrupted)
    status, out, _ = orbitscan("info", recording)
    assert (status, out) == (130, "")


@pytest.mark.parametrize("command", ["convert", "simulate", "info", "check"])
def test_help_shows_examples(orbitscan, command):
    status, out, _ = orbitscan(command, "--help")
    assert status == 0
    assert f"orbitscan {command} " in out.split("Example")[1]


def test_help_needs_nothing_heavy():
    """With numpy, scipy or open3d among its imports the command would answer in seconds, not in half a one."""
    code = """if True:
        import sys, typer
        from orbitscan.recorder import cli
        app = typer.Typer()
        for command in cli.COMMANDS:
            app.command()(command)
        typer.main.get_command(app)
        print([name for name in ("numpy", "scipy", "open3d", "mcap", "natsort") if name in sys.modules])
    """
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "[]\n"


def test_a_reader_that_goes_away_is_no_error(recording):
    code = "from orbitscan.processing.cli import main; main()"
    command = f"{sys.executable} -c '{code}' info {recording} | true"
    found = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert found.stderr == ""


def test_what_the_library_logs_is_a_line_on_stderr(capsys):
    app = typer.Typer()

    @app.command()
    def speak() -> None:
        logging.getLogger("orbitscan.recorder.kernels").warning("kept in %s", "a folder")

    for _ in range(2):  # once each time
        with pytest.raises(SystemExit):
            cli.run(app, [])
        assert capsys.readouterr() == ("", "kept in a folder\n")
