"""A recording in, its results folder out: whole or not at all, made again only where something changed."""

import traceback
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numba

from orbitscan.processing.classification import PACKAGED
from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.results.folder import Results, read_results, write_results
from orbitscan.processing.results.key import changed, input_sha256, make_key, read_key
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.registered import FILE_NAME, place, registered
from orbitscan.processing.results.status import METHODS, Method, Status
from orbitscan.processing.review.foxglove import LAYOUT_NAME, write_foxglove_layout
from orbitscan.processing.settings import Settings
from orbitscan.recorder import mcap_file
from orbitscan.recorder.atomic import remove_leftovers, whole_folder
from orbitscan.recorder.exceptions import ProcessingFailed, ScanError, UnreadableRecording, UnwritableOutput, Wording
from orbitscan.recorder.session import Session

if TYPE_CHECKING:
    from orbitscan.processing.classification.classifier import Classifier


@dataclass(frozen=True)
class Job:
    """What is done to every recording of a batch."""

    results: Path
    views: str = "18"
    methods: tuple[Method, ...] = METHODS
    settings: Settings = field(default_factory=Settings)
    seed: int = 0
    overwrite: bool = False
    threads: int = 1
    model: Path | None = PACKAGED  # None: nothing is classified
    skip_unfinished: bool = False  # recordings that somebody is still writing
    figures: bool = False  # the error curves as PNG and SVG too
    viewer: str | None = None  # where a Rerun viewer listens, which shows the reviews as they grow


@dataclass(frozen=True)
class Outcome:
    """What became of one recording."""

    recording: Path
    folder: Path
    message: str  # one line: done, or skipped, or what is wrong
    status: Literal["done", "failed", "unfinished"] = "done"  # unfinished: somebody is still writing the recording
    error: ScanError | None = None
    damage: str | None = None
    failed_views: int = 0  # of the best method run, ambiguous ones among them
    ambiguous_views: int = 0

    @classmethod
    def failed(cls, path: Path, job: Job, error: ScanError) -> Self:
        """That of a recording without results."""
        return cls(path, job.results / path.stem, str(error), "failed", error=error)


def process_recording(path: Path, job: Job) -> Outcome:
    """Process one recording into its results folder, unless a folder with the same key is there.

    Nothing is raised: whatever goes wrong with a recording is its Outcome.
    """
    numba.set_num_threads(job.threads)
    error: ScanError
    try:
        return _process(path, job)
    except ScanError as told:
        error = told
    except OSError as failure:
        problem = f"cannot be written ({failure.strerror or failure})"
        remedy = Wording("make room, or choose another {place}")
        error = UnwritableOutput(job.results / path.stem, problem, remedy)
    except MemoryError:
        error = ProcessingFailed(path, "there is not enough memory", Wording("use fewer {workers}"))
    except Exception as failure:  # of one recording out of hundreds: the others go on
        kept = _keep_traceback(_traceback_file(path, job))
        problem = f"a fault of orbitscan stopped it ({type(failure).__name__}: {failure})".replace("\n", " ")
        error = ProcessingFailed(path, problem, f"please report it{kept}")
    return Outcome.failed(path, job, error)


def _process(path: Path, job: Job) -> Outcome:
    folder = job.results / path.stem
    if job.skip_unfinished and mcap_file.still_being_written(path):
        return Outcome(path, folder, "skipped: it is still being written; process it when it is done", "unfinished")
    before = _stamp(path)
    session = mcap_file.read(path)
    model = input_sha256(job.model) if job.model else None
    key = make_key(input_sha256(path), model, job.views, job.methods, asdict(job.settings), job.seed)
    known = read_key(folder)
    if known == key and not job.overwrite:
        remove_leftovers(folder)
        if job.figures:
            _draw_figures(folder)
        return _finished(path, folder, "already done")
    if folder.exists() and known is None:
        raise UnwritableOutput(folder, "exists and holds no results", Wording("move it, or choose another {place}"))
    with whole_folder(folder) as part:
        _process_session(session, path, part, key, job)
        if _stamp(path) != before:
            raise UnreadableRecording(path, "it changed while it was read", "process it again when nobody writes it")
    _traceback_file(path, job).unlink(missing_ok=True)
    why = changed(known, key)
    return _finished(path, folder, "done" if known is None else f"done again: changed {why}" if why else "done again")


def _stamp(path: Path) -> tuple[int, int] | None:
    """A file's size and when it was last written; None where there is none."""
    if not path.is_file():
        return None
    about = path.stat()
    return about.st_size, about.st_mtime_ns


def _traceback_file(path: Path, job: Job) -> Path:
    return job.results / f"{path.stem}.traceback.txt"


def _keep_traceback(path: Path) -> str:
    """Where the traceback in hand was written, as an end of a sentence; nothing where it cannot be."""
    try:
        path.write_text(traceback.format_exc(), encoding="utf-8")
    except OSError:
        return ""
    return f" with {path}"


def _process_session(session: Session, path: Path, folder: Path, key: dict[str, Any], job: Job) -> None:
    from orbitscan.processing.review.session.recording import SessionReview  # slow to import

    truth = session.truth()
    classifier = _load_classifier(job.model) if job.model else None
    estimates = process(session.views(job.views), session.info, job.settings, job.methods, job.seed, classifier)
    shown = {"identity": key["input_sha256"][:8], "viewer": job.viewer}
    with SessionReview(folder / "review.rrd", session.info, job.methods, truth, **shown) as review:
        for result in with_errors(estimates, truth):
            if isinstance(result, SessionResult):
                review.add_session(result)
                write_results(folder, result, Results.of(result, key, path.name, session.damage), truth)
                if placement := place(result):
                    mcap_file.write(registered(session, placement), folder / FILE_NAME)
                    write_foxglove_layout(folder / LAYOUT_NAME, placement, session.info)
            else:
                review.add_view(result)
    if job.figures:
        _draw_figures(folder)


def _draw_figures(folder: Path) -> None:
    from orbitscan.processing.review.figures.session import write_figures  # slow to import

    write_figures(folder)


def _load_classifier(model: Path) -> "Classifier":
    import torch

    from orbitscan.processing.classification.classifier import Classifier  # slow to import

    torch.set_num_threads(1)  # a sum in another order might differ in its last bit
    return Classifier(model)


def _finished(path: Path, folder: Path, message: str) -> Outcome:
    results = read_results(folder).results
    views = results.best.views if results.best else ()
    failed = sum(view.status != Status.OK for view in views)
    ambiguous = sum(view.status == Status.AMBIGUOUS for view in views)
    damage = results.input.damage
    return Outcome(path, folder, message, damage=damage, failed_views=failed, ambiguous_views=ambiguous)
