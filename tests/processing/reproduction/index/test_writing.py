"""The index holds every study of a folder, needs nothing outside it, and says what holds before all else."""

import json
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from urllib.parse import unquote

import numpy as np
import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.reproduction import STUDIES, charts
from orbitscan.processing.reproduction.claims import Claim, Verdict
from orbitscan.processing.reproduction.index.page import number, shorten_command, state_facts
from orbitscan.processing.reproduction.index.writing import read_studies, write_index
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import read_frames, read_models
from orbitscan.processing.reproduction.report import Report, write
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.formats import ply

VOID = {"meta", "img", "br", "hr", "link", "input"}
CLAIMS = [
    Claim("PCA is more accurate than Glorot", Verdict.HOLDS, 1, (0.5, 2), 10, "points"),
    Claim("DCAE beats <b>ZCA</b> & Glorot: ever", Verdict.FAILS, -1, (-2, -0.5), 10, "points"),
    Claim("ZCA is more accurate than Glorot", Verdict.OPEN, 3, None, 1, "points"),
]


class Page(HTMLParser):
    """A page taken apart; what is not closed, or closed unopened, fails."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict]] = []
        self.cells: list[list[str]] = []  # of every row of a table of numbers
        self.text = ""
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.open += [] if tag in VOID else [tag]
        if tag == "tr":
            self.cells.append([])
        if tag == "td":
            self.cells[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data
        if "td" in self.open:
            self.cells[-1][-1] += data

    def all(self, tag, attribute):
        return [attributes[attribute] for name, attributes in self.tags if name == tag and attribute in attributes]


def draw():
    figure, ((axes,),) = charts.new_figure()
    charts.draw_bars(axes, ["a"], {"loss": [1.0]}, "loss [nats]")
    return figure


@pytest.fixture(scope="module")
def indexed(tmp_path_factory):
    """A folder with three studies: one with claims, one with curves of training, one of registration with a model.

    And its index. Tests that change something take `plan`, a copy.
    """
    home = tmp_path_factory.mktemp("reproduction")
    plan = Plan(home / "rep", runs=2)
    rows = [{"init": n, "loss": 2.0383, "thesis_loss": 0.2866, "seconds": 8} for n in ("<i>PCA</i>", "ZCA")]
    write(
        Report("table-5.4", "Four", rows, ["Best: PCA."], CLAIMS, {"table-5.4": draw()}, {"epochs": [1, 2]}),
        plan,
        f"orbitscan reproduce table-5.4 -o {home / 'rep'}",
    )
    steps = [{"init": init, "step": step, "loss": 10.0 - step} for init in "ab" for step in range(1, 10)]
    write(
        Report("figure-5.2", "Curves", steps, ["Best: a."], figures={"figure-5.2": draw()}),
        plan,
        "orbitscan reproduce all",
    )
    models = [{"object": "bin", "method": "icp", "points": 9}]
    other = Plan(plan.folder, runs=2, fraction=0.5)
    write(Report("figure-5.9", "Models", models, figures={"figure-5.9": draw()}), other, "orbitscan reproduce all")
    for circle in ("bin-sparse-18-seed-0", "bin-dense-250-seed-0", "bin-sparse-18-seed-1"):
        leave_results(plan.folder / "registration" / "icp" / circle, ["icp"])
        leave_results(plan.folder / "registration" / "ours" / circle, ["pairwise", "refined"])
    write_index(plan)
    return plan


@pytest.fixture
def plan(indexed, tmp_path):
    shutil.copytree(indexed.folder, tmp_path / "rep")
    return replace(indexed, folder=tmp_path / "rep")


def leave_results(folder, methods):
    """What registration leaves of a circle; the second view has no estimate."""
    folder.mkdir(parents=True)
    ply.write(folder / "model.ply", np.array([[0.0, -np.cos(np.pi / 6), -0.5]], np.float32))
    lines = ["view,name,method,status,translation_error_m,rotation_error_chordal,rotation_error_deg,center_error_m"]
    for method in methods:
        lines += [f"0,a,{method},ok,0,0,0,0", f"14,b,{method},no_consensus,,,,", f"28,c,{method},ok,0.5,0.25,9,0.125"]
    (folder / "errors.csv").write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def page(indexed):
    return Page((indexed.folder / "index.html").read_text(encoding="utf-8"))


def test_the_page_needs_nothing_outside_its_folder(indexed, page):
    assert not {"script", "link", "iframe"} & {tag for tag, _ in page.tags}
    assert len(page.all("img", "src")) == 3
    assert all(source.startswith("data:image/png;base64,") for source in page.all("img", "src"))
    assert all(page.all("img", "alt"))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    for link in page.all("a", "href"):
        assert link[1:] in ids if link.startswith("#") else (indexed.folder / unquote(link)).is_file(), link


def test_the_claims_come_first_with_their_verdicts(page):
    assert "Of 3 claims tested, 1 holds, 1 does not hold, and 1 cannot be told." in page.text
    rows = [[cell.strip() for cell in row] for row in page.cells if len(row) == 3]
    assert rows[:3] == [
        ["✓ holds", "PCA is more accurate than Glorot", CLAIMS[0].evidence],
        ["✗ does not hold", "DCAE beats <b>ZCA</b> & Glorot: ever", CLAIMS[1].evidence],
        ["? cannot be told", "ZCA is more accurate than Glorot", CLAIMS[2].evidence],
    ]
    assert page.text.index("Of 3 claims") < page.text.index("Best: PCA.")


def test_the_thesis_stands_beside_ours(page):
    assert ["<i>PCA</i>", "2.0383", "0.2866", "8"] in page.cells
    assert not page.all("i", "class")
    assert not [tag for tag, _ in page.tags if tag in ("b", "i")]


def test_of_a_long_table_all_rows_are_folded_away(page):
    rows = [row for row in page.cells if len(row) == 3 and row[0] in ("a", "b")]
    assert len(rows) == 6 + 18
    assert rows[:6] == rows[6:12]
    assert "All 18 rows" in page.text


def test_studies_are_in_the_thesis_s_order_and_missing_ones_told(page):
    sections = [attributes["id"] for tag, attributes in page.tags if tag == "section"]
    assert sections == ["claims", "run", "table-5.4", "figure-5.2", "figure-5.9", "missing"]
    missing = page.text[page.text.rindex("Not run") :]
    assert [name for name in STUDIES if f"reproduce {name} " in missing] == [
        name for name in STUDIES if name not in sections
    ]


def test_what_was_run_is_told_once_and_where_it_differs(indexed, page):
    facts = state_facts(read_studies(indexed.folder))
    assert facts["Share of the thesis's views"] == [("1", ""), ("0.5", "Figure 5.9")]
    assert facts["Seeds"] == [("0, 1", "")]
    assert "0.5 in Figure 5.9" in page.text
    assert "epochs" in page.text


def test_no_output_tells_where_the_folder_is(indexed):
    home = str(indexed.folder.parent)
    assert home not in (indexed.folder / "index.html").read_text(encoding="utf-8")
    for chunk in RrdReader(indexed.folder / "reproduction.rrd").stream():
        assert home not in str(chunk.to_record_batch().to_pydict())


def test_a_command_is_told_without_the_folders_of_its_paths():
    told = "orbitscan reproduce all -o rep"
    assert [shorten_command(f"orbitscan reproduce all -o {path}") for path in ("rep", "/a/rep", "'/a b/rep'")] == [
        told
    ] * 3
    assert "/home" not in shorten_command("orbitscan reproduce all -o /home/o'neill/rep")


def test_the_recording_holds_figures_curves_and_models(indexed):
    columns = {}
    for chunk in RrdReader(indexed.folder / "reproduction.rrd").stream():
        columns.setdefault(chunk.entity_path, set()).update(chunk.to_record_batch().schema.names)
    held = [name for names in columns.values() for name in names]
    assert held.count("EncodedImage:blob") == 3
    assert held.count("Scalars:scalars") == 2
    models = [path for path, names in columns.items() if "Points3D:positions" in names and "/models/" in path]
    assert [path.partition("/models/")[2] for path in sorted(models)] == ["bin-sparse-18/icp", "bin-sparse-18/ours"]


def test_frames_of_the_first_run_are_read_by_circle_and_method(indexed):
    rows = read_frames(indexed.folder)
    assert {(row["circle"], row["method"]) for row in rows} == {
        (circle, method) for circle in ("bin-sparse-18", "bin-dense-250") for method in ("icp", "pairwise", "refined")
    }
    last = rows[-1]
    assert (last["view"], last["translation_error_m"], last["center_error_m"]) == (28, 0.5, 0.125)
    assert [row["rotation_error_chordal"] for row in rows if row["view"] == 14] == [None] * 6


def test_models_stand_upright(indexed):
    """What is straight up from a camera that looks down by 30 degrees is along z."""
    (models,) = read_models(indexed.folder).values()
    assert list(models) == ["icp", "ours"]
    np.testing.assert_allclose(models["ours"][0], [[0, 0, 1]], atol=1e-6)


def test_without_a_registration_there_are_no_frames_and_no_models(tmp_path):
    assert read_frames(tmp_path) == []
    assert read_models(tmp_path) == {}


def test_the_same_studies_make_the_same_page(plan, indexed):
    page, _ = write_index(plan)
    assert page.read_bytes() == (indexed.folder / "index.html").read_bytes()
    assert not list(plan.folder.glob("*.part"))


def test_several_figures_of_a_study_have_their_numbers(plan):
    rows = [{"figure": "figure-3.4", "points": 7}]
    write(
        Report("gallery", "All", rows, figures={name: draw() for name in ("figure-3.4", "figure-3.7")}),
        plan,
        "orbitscan",
    )
    page = Page(write_index(plan)[0].read_text(encoding="utf-8"))
    assert [tag for tag, _ in page.tags].count("figcaption") == 2
    assert "Figure 3.7" in page.text


def test_figures_that_are_gone_are_left_out(plan):
    (plan.folder / "table-5.4.png").unlink()
    page = Page(write_index(plan)[0].read_text(encoding="utf-8"))
    assert len(page.all("img", "src")) == 2
    assert "table-5.4.png" not in page.all("a", "href")


def test_a_folder_without_studies_is_told(tmp_path):
    with pytest.raises(InvalidOption, match="holds no table or figure yet"):
        write_index(Plan(tmp_path))


@pytest.mark.parametrize("content", ["", "[]", "{}", json.dumps({"format_version": 99, "name": "table-5.1"})])
def test_a_report_that_is_none_is_named(plan, content):
    (plan.folder / "table-5.1.json").write_text(content)
    with pytest.raises(InvalidOption, match=r"table-5\.1\.json: is no report of this version"):
        write_index(plan)


def test_numbers_of_studies():
    assert [number(name) for name in ("table-5.1", "figure-5.10", "study-overlap", "gallery")] == [
        "Table 5.1",
        "Figure 5.10",
        "Study of overlap",
        "Gallery",
    ]
