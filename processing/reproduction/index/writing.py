"""The index of a reproduction: all its studies on one page, and in one Rerun recording."""

from pathlib import Path

from orbitscan.processing.reproduction import STUDIES
from orbitscan.processing.reproduction.index.page import render_page, state_facts
from orbitscan.processing.reproduction.index.rerun_recording import write_reproduction
from orbitscan.processing.reproduction.index.study import StudyReview
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import read_frames, read_models
from orbitscan.processing.reproduction.report import SavedReport, read
from orbitscan.recorder.atomic import write_whole
from orbitscan.recorder.exceptions import InvalidOption

GROUPS = {"registration": "Registration", "overlap": "Overlap"}  # by room; the others classify
FRAMES, MODELS = "figure-5.8", "figure-5.9"


def write_index(plan: Plan) -> list[Path]:
    """Write `index.html` and `reproduction.rrd` of the studies in the plan's folder; their paths.

    Raises InvalidOption where there is no study or one cannot be read, UnwritableOutput.
    """
    studies = read_studies(plan.folder)
    page, recording = plan.folder / "index.html", plan.folder / "reproduction.rrd"
    missing = [name for name in STUDIES if name not in {study.name for study in studies}]
    write_reproduction(recording, _group(studies, plan.folder), _describe_run(studies))
    write_whole(page, render_page(studies, missing, plan.folder))
    return [page, recording]


def read_studies(folder: Path) -> list[SavedReport]:
    """The reports in a folder, in the thesis's order. Raises InvalidOption for none, or one that is none."""
    paths = [folder / f"{name}.json" for name in STUDIES]
    studies = [read(path) for path in paths if path.exists()]
    if not studies:
        raise InvalidOption(folder, "holds no table or figure yet", "make one: orbitscan reproduce table-5.2 -o DIR")
    return studies


def _group(studies: list[SavedReport], folder: Path) -> dict[str, list[StudyReview]]:
    """The studies with what their recording shows of them, by group."""
    groups: dict[str, list[StudyReview]] = {}
    for study in studies:
        module = STUDIES[study.name].split(".")[0]
        pictures = {name: folder / f"{name}.png" for name in study.figures}
        review = StudyReview(
            study,
            figures={name: path.read_bytes() for name, path in pictures.items() if path.exists()},
            frames=read_frames(folder) if study.name == FRAMES else (),
            models=read_models(folder) if study.name == MODELS else {},
        )
        groups.setdefault(GROUPS.get(module, "Classification"), []).append(review)
    return groups


def _describe_run(studies: list[SavedReport]) -> str:
    """What was run, as Markdown."""
    return "\n".join(
        f"- {name}: {'; '.join(f'{fact} in {where}' if where else fact for fact, where in stated)}"
        for name, stated in state_facts(studies).items()
    )
