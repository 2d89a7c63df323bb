"""Two packages, one name, one direction, one page: an import against the order fails here."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ORDER = [  # of processing; a module imports only what stands above it
    "results.colors",
    "results.status",
    "results.uncertainty",
    "results.estimates",
    "results.classification",
    "results.records",
    "kernels",
    "surface",
    "features",
    "classification",
    "registration",
    "reconstruction",
    "settings",
    "timing",
    "steps",
    "pose_errors",
    "results.key",
    "results.folder",
    "results.batch_table",
    "results.edges",
    "results.registered",
    "results.confusion",
    "results.comparison",
    "pipeline",
    "review",
    "batch",
    "reproduction",
    "cli",
    "api",
]
MODULES = sorted(
    str(path.relative_to(ROOT).with_suffix("")).replace("/", ".").removesuffix(".__init__")
    for package in ("recorder", "processing")
    for path in (ROOT / package).rglob("*.py")
)


def imports(module):
    path = ROOT / (module.replace(".", "/") + ".py")
    path = path if path.exists() else ROOT / module.replace(".", "/") / "__init__.py"
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name.removeprefix("orbitscan.") for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively"
            home = node.module.removeprefix("orbitscan.")
            for name in node.names:
                full = f"{home}.{name.name}"
                yield full if full in MODULES else home


def rank(module):
    inside = module.removeprefix("processing.")
    ranks = [i for i, name in enumerate(ORDER) if inside == name or inside.startswith(name + ".")]
    assert ranks, f"{module} has no place in the order"
    return ranks[0]


@pytest.mark.parametrize("module", [m for m in MODULES if m.startswith("recorder")])
def test_the_recorder_knows_nothing_of_processing(module):
    assert not [name for name in imports(module) if name.split(".")[0] == "processing"]


@pytest.mark.parametrize("module", [m for m in MODULES if m.startswith("processing.")])
def test_processing_imports_only_upwards(module):
    for name in imports(module):
        if name.startswith("processing."):
            assert rank(name) <= rank(module), f"{module} imports {name}"
        if name.startswith("recorder.cli"):
            assert module.startswith("processing.cli")


BARE_IMPORT = re.compile(
    r"(?<![\w.])(?:from|import) +(?:\w+, *)*(?:recorder|processing)(?:\.\w+)*(?:,| import|;|\"|\n)"
)


def test_what_is_imported_is_orbitscan():
    """In a clone `import processing` works too: it would load everything a second time."""
    texts = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    for folder in ("recorder", "processing", "tests"):
        texts += (ROOT / folder).rglob("*.py")
    texts = [path for path in texts if path.name not in ("test_api.py", "test_architecture.py")]  # they speak of it
    assert not [str(path) for path in texts if BARE_IMPORT.search(path.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("line", ["import processing", "from recorder.x import y", '"import sys, processing.cli; "'])
def test_a_bare_import_is_found_wherever_it_stands(line):
    assert BARE_IMPORT.search(f"{line}\n")
    assert not BARE_IMPORT.search(line.replace("processing", "orbitscan.processing").replace("recorder", "a.recorder"))


def test_every_folder_is_a_package_of_the_wheel():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]["packages"]
    found = {f"orbitscan.{module}" for module in MODULES if (ROOT / module.replace(".", "/")).is_dir()}
    assert declared == sorted(found - {"orbitscan.processing.api"} | {"orbitscan"})


def test_the_page_knows_of_the_recorder_only_the_session():
    assert {n for n in imports("processing.pipeline") if n.startswith("recorder")} == {"recorder.session"}


def test_the_truth_is_asked_for_in_few_places():
    sources = {module: ROOT / (module.replace(".", "/") + ".py") for module in MODULES if "processing." in module}
    readers = {m for m, path in sources.items() if path.exists() and ".truth()" in path.read_text(encoding="utf-8")}
    assert readers == {
        "processing.batch.recording",
        "processing.reproduction.registration.models",  # which shows a model from its front
        "processing.reproduction.overlap.run",  # which turns the start, and judges
    }


def test_the_page_is_a_page():
    assert len((ROOT / "processing" / "pipeline.py").read_text("utf-8").splitlines()) < 140


FLAG = re.compile(r"(?<![\w-])--[a-z][\w-]+|(?<![\w-])-o\b")
COMMAND = re.compile(r"orbitscan [a-z]+[^;'`]*")  # with its name before them, options are a command's, whoever speaks


def texts_of(path):
    """The strings of a module; what is filled into one is a blank word."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.JoinedStr):
            yield "".join(part.value if isinstance(part, ast.Constant) else "..." for part in node.values)
            for part in node.values:
                if isinstance(part, ast.Constant):
                    part.value = ""
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def test_only_commands_speak_of_options():
    """What the library says names settings as Python does; the command writes its own options from that."""
    found = {}
    for package in ("recorder", "processing"):
        for path in (ROOT / package).rglob("*.py"):
            if "cli" in path.relative_to(ROOT).parts or path.name == "screenshot.py":  # which starts the viewer
                continue
            said = [text for text in texts_of(path) if FLAG.search(COMMAND.sub("", text))]
            found |= {str(path.relative_to(ROOT)): said} if said else {}
    assert not found
