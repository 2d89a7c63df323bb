"""The README and the pages of docs/: what they tell to type runs, in a folder as they assume it; links, options hold.

Pages run in the order in which the README links them, each command once. A block after `<!-- not run: REASON -->` needs
what is not here: of it the options are checked. A TOML block that begins with `# NAME.toml` is such a file.
"""

import contextlib
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import typer

from orbitscan.processing.classification import training
from orbitscan.processing.cli import app
from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.formats import ply
from tests.command import run
from tests.geometry import scan
from tests.viewer import RERUN

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
BLOCK = re.compile(
    r"(?:^ *<!-- not run: (?P<reason>[^>]+) -->\n)?^ *```(?P<language>\w*)\n(?P<text>.*?)^ *```$",
    re.DOTALL | re.MULTILINE,
)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
LINK = re.compile(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)")
HEADING = re.compile(r"^#+ +(.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A block of code on a page."""

    page: Path
    language: str
    text: str
    reason: str | None  # why it is not run; None where it is

    @property
    def commands(self):
        """Its lines as words, without those for make."""
        lines = [line.split("#")[0].strip() for line in self.text.splitlines()]
        return [shlex.split(line) for line in lines if line and not line.startswith("make ")]


def text_of(page):
    return page.read_text(encoding="utf-8")


def prose_of(page):
    """A page without its blocks and comments."""
    return COMMENT.sub("", BLOCK.sub("", text_of(page)))


def links_of(page):
    """(file, anchor) of every relative link of a page; an anchor alone is in the page itself."""
    return [(page.parent / path if path else page, anchor) for path, anchor in LINK.findall(prose_of(page))]


def find_pages():
    """The pages that links lead to, from the README on."""
    found = [README]
    for page in found:
        for path, _ in links_of(page):
            path = Path(os.path.normpath(path))
            if path.suffix == ".md" and path.exists() and path not in found:
                found.append(path)
    return found


PAGES = find_pages()
BLOCKS = [
    Block(page, match["language"], match["text"], match["reason"])
    for page in PAGES
    for match in BLOCK.finditer(text_of(page))
]
COMMANDS = {"orbitscan": typer.main.get_command(app)}
COMMANDS |= COMMANDS["orbitscan"].commands


def options_of(command):
    return {option for parameter in command.params for option in parameter.opts if option.startswith("-")}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """`scans/` and `things/` with clouds, poses.tum, a recording in `recordings/`; no display is asked for."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "scans").mkdir()
    session = scan(n_views=3, points=6000)
    for view in session.views():
        ply.write(folder / "scans" / f"{view.name}.ply", view.points)
    truth = session.truth()
    lines = [poses.to_tum_line((i + 1) * 10**9, truth[i]) for i in sorted(truth)]
    (folder / "poses.tum").write_text("\n".join(lines))
    mcap_file.write(scan(n_views=3, points=6000), folder / "recordings" / "robot.mcap")  # in place of the sample
    for category, stretch in (("ball", (1, 1, 1)), ("plank", (1, 1, 0.2))):
        (folder / "things" / category).mkdir(parents=True)
        for i, view in enumerate(session.views()):
            ply.write(folder / "things" / category / f"{i}.ply", view.points[::10] * np.float32(stretch))
    stub = folder / "bin" / "rerun"
    stub.parent.mkdir()
    stub.write_text(f'#!/bin/sh\ncase "$*" in *--headless*) exec {RERUN} "$@" ;; esac\n')  # no display is needed there
    stub.chmod(0o755)
    return folder


def environment(folder):
    path = os.pathsep.join([str(folder / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]])
    return {"PATH": path, "HOME": str(folder), "RERUN_CLI_PATH": str(folder / "bin" / "rerun")}


def run_command(words, folder):
    if words[0] == "orbitscan":
        return run(*words[1:], cwd=folder, env=environment(folder))
    everything = os.environ | environment(folder)
    return subprocess.run(words, cwd=folder, env=everything, capture_output=True, text=True)


def test_what_the_pages_tell_to_type_runs(folder, request, monkeypatch):
    monkeypatch.setattr(training, "TrainingSettings", partial(training.TrainingSettings, epoch_views=50))
    printed, names, no_picture = {}, {page: {} for page in PAGES}, None
    for block in BLOCKS:
        if block.reason:
            continue
        if block.language == "python":
            with contextlib.chdir(folder):
                exec(compile(block.text, block.page.name, "exec"), names[block.page])
        elif block.language == "toml":
            (folder / block.text.splitlines()[0].removeprefix("# ")).write_text(block.text)
        for words in block.commands if block.language == "bash" else ():
            if (command := shlex.join(words)) in printed:
                continue
            if "--screenshot" in words:
                try:
                    request.getfixturevalue("renderer")
                except pytest.skip.Exception as reason:
                    no_picture = reason
                    continue
            finished = run_command(words, folder)
            assert finished.returncode == 0, f"{block.page.name}: {command}\n{finished.stdout}{finished.stderr}"
            printed[command] = finished.stdout
    assert len(printed) >= 20
    check_the_table_of_errors(printed["orbitscan process mug.mcap -o results"])
    check_the_table_of_files(folder / "results" / "mug")
    if no_picture:
        pytest.skip(f"all but the picture: {no_picture}")


def check_the_table_of_errors(printed):
    """The README shows the table of the sample: headings and methods are as they are printed here."""
    (shown,) = (block.text for block in BLOCKS if block.page == README and "Errors against" in block.text)
    *headings, first, second, third, fourth, remark = (line.split() for line in shown.splitlines() if line.strip())
    there = [line.split() for line in printed.splitlines()]
    assert all(heading in there for heading in (*headings, remark))
    methods = [first[1], second[0], third[0], fourth[0]]
    assert methods == [word for line in there for word in line[:2] if word in methods]


def check_the_table_of_files(results):
    """docs/results.md names every file of a results folder, and no other; some views and options add theirs."""
    section = text_of(ROOT / "docs" / "results.md").split("## The files of a recording")[1].split("\n## ")[0]
    named = set()
    for row in re.findall(r"^\| (`.+)", section, re.MULTILINE):
        files, content = row.split(" | ", 1)
        if "with `--" not in content and "where there are any" not in content:
            named |= set(re.findall(r"`([^`]+)`", files))
    methods = {f"poses_{method}.tum" for method in ("icp", "ransac_icp", "pairwise", "refined")}
    assert {path.name for path in results.iterdir()} == named - {"poses_<method>.tum"} | methods


def test_the_make_targets_they_name_exist():
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for page in PAGES:
        assert set(re.findall(r"(?:`|^)make ([a-z-]+)", text_of(page), re.MULTILINE)) <= set(targets), page


def test_every_target_is_named():
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    named = re.findall(r"^\| `make ([a-z-]+)`", text_of(ROOT / "docs" / "development.md"), re.MULTILINE)
    assert sorted(named) == sorted(targets)


def test_every_page_is_reached_from_the_readme():
    assert {*(ROOT / "docs").rglob("*.md"), ROOT / "REPRODUCTION.md"} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    for path, anchor in links_of(page):
        assert path.exists(), path
        if anchor:
            assert anchor in anchors_of(path), f"{path}#{anchor}"


def anchors_of(page):
    """The anchors that GitHub gives a page's headings."""
    headings = HEADING.findall(BLOCK.sub("", text_of(page)))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_a_command_has_a_row_and_no_other(name):
    rows = [row for page in PAGES for row in rows_of(page, name)]
    named = [option for row in rows for option in re.findall(r"`(--?[a-z-]+)`", row.split(" | ")[0])]
    assert sorted(named) == sorted(options_of(COMMANDS[name]) - {"--help"})


def rows_of(page, name):
    """The rows of the table of a command's options, where the page has it."""
    _, _, table = text_of(page).partition(f"| option of `{name}` |")
    return table.split("\n\n")[0].splitlines()[2:]


def test_no_option_is_named_that_there_is_not():
    known = {"--help"}.union(*map(options_of, COMMANDS.values()))
    for page in PAGES:
        assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", COMMENT.sub("", text_of(page)))) <= known, page


def test_what_is_not_run_has_options_that_there_are():
    blocks = [block for block in BLOCKS if block.reason]
    assert blocks
    for block in blocks:
        for words in block.commands:
            assert words[0] == "orbitscan"
            given = {word for word in words if word.startswith("-")}
            assert given <= options_of(COMMANDS[words[1]]), shlex.join(words)
