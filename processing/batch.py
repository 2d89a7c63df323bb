"""Recordings in, results folders out: each whole or not at all, made again only where something changed."""

import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba

from processing.classification import PACKAGED
from processing.errors import with_errors
from processing.pipeline import process
from processing.results.files import (
    changed,
    input_sha256,
    make_key,
    read_key,
    read_results,
    write_results,
)
from processing.results.records import METHODS, SessionResult
from processing.settings import Settings
from recorder import mcap_file
from recorder.exceptions import InvalidOption, ScanError, UnreadableRecording, UnwritableOutput
from recorder.session import Session

if TYPE_CHECKING:
    from processing.classification.classifier import Classifier


@dataclass(frozen=True)
class Job:
    """What is done to every recording of a batch."""

    results: Path
    views: str = "18"
    methods: tuple[str, ...] = METHODS
    settings: Settings = field(default_factory=Settings)
    seed: int = 0
    overwrite: bool = False
    threads: int = 1
    model: Path | None = PACKAGED  # None: nothing is classified


@dataclass(frozen=True)
class Outcome:
    """What became of one recording."""

    recording: Path
    folder: Path
    message: str  # one line: done, or skipped, or what is wrong
    summaries: dict[str, dict[str, Any]] = field(default_factory=dict)  # by method; empty where there are no results
    error: ScanError | None = None
    damage: str | None = None
    ambiguous_views: int = 0  # of the best method run

    @property
    def failed_views(self) -> int:
        """Of the best method run."""
        best = next((method for method in reversed(METHODS) if method in self.summaries), None)
        return self.summaries[best]["failed_views"] if best else 0


def find_recordings(inputs: Sequence[Path]) -> list[Path]:
    """The recordings that files and folders name, in order. Raises ScanError for none, or two of one name."""
    found: list[Path] = []
    for path in inputs:
        inside = sorted(path.rglob("*.mcap")) if path.is_dir() else [path]
        if not inside:
            raise UnreadableRecording(path, "the folder holds no recording (*.mcap)", "name one that does")
        found += inside
    by_name: dict[str, Path] = {}
    for path in dict.fromkeys(found):
        if (other := by_name.setdefault(path.stem, path)) is not path:
            raise InvalidOption(path, f"has the same name as {other}", "rename one: results are kept by name")
    return list(by_name.values())


def process_all(recordings: Sequence[Path], job: Job, workers: int = 1) -> Iterator[Outcome]:
    """An Outcome for each recording as it is ready; with several workers in the order they finish.

    One that fails does not stop the others.
    """
    if workers == 1 or len(recordings) == 1:
        yield from (process_recording(path, job) for path in recordings)
        return
    # spawn: forked children hang in libraries that had already started threads
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        pending = [pool.submit(process_recording, path, job) for path in recordings]
        yield from (future.result() for future in as_completed(pending))


def threads_per_worker(workers: int) -> int:
    """How many threads each of so many workers gets."""
    return max(1, numba.config.NUMBA_NUM_THREADS // workers)


def process_recording(path: Path, job: Job) -> Outcome:
    """Process one recording into its results folder, unless a folder with the same key is there."""
    numba.set_num_threads(job.threads)
    folder = job.results / path.stem
    part = folder.with_name(folder.name + ".part")
    try:
        session = mcap_file.read(path)
        model = input_sha256(job.model) if job.model else None
        key = make_key(input_sha256(path), model, job.views, job.methods, asdict(job.settings), job.seed)
        known = read_key(folder)
        if known == key and not job.overwrite:
            return _finished(path, folder, "already done")
        if folder.exists() and known is None:
            raise UnwritableOutput(folder, "exists and holds no results", "move it, or choose another place with -o")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        _process_session(session, path, part, key, job)
        shutil.rmtree(folder, ignore_errors=True)
        part.replace(folder)
    except ScanError as error:
        shutil.rmtree(part, ignore_errors=True)
        return Outcome(path, folder, str(error), error=error)
    except OSError as failure:
        shutil.rmtree(part, ignore_errors=True)
        error = UnwritableOutput(folder, f"cannot be written ({failure.strerror})", "choose another place with -o")
        return Outcome(path, folder, str(error), error=error)
    why = changed(known, key)
    return _finished(path, folder, f"done again: changed {why}" if why else "done")


def _process_session(session: Session, path: Path, folder: Path, key: dict[str, Any], job: Job) -> None:
    from processing.review.session import SessionReview  # slow to import

    truth = session.truth()
    classifier = _load_classifier(job.model) if job.model else None
    estimates = process(session.views(job.views), session.info, job.settings, job.methods, job.seed, classifier)
    with SessionReview(folder / "review.rrd", session.info, job.methods, truth) as review:
        for result in with_errors(estimates, truth):
            if isinstance(result, SessionResult):
                review.add_session(result)
                write_results(folder, result, key, path, session.damage, truth)
            else:
                review.add_view(result)


def _load_classifier(model: Path) -> "Classifier":
    import torch

    from processing.classification.classifier import Classifier  # slow to import

    torch.set_num_threads(1)  # a sum in another order might differ in its last bit
    return Classifier(model)


def _finished(path: Path, folder: Path, message: str) -> Outcome:
    results = read_results(folder)
    summaries = {method: content["summary"] for method, content in results["reconstruction"].items()}
    best = next((method for method in reversed(METHODS) if method in summaries), None)
    views = results["reconstruction"][best]["views"] if best else []
    ambiguous = sum(view["status"] == "ambiguous" for view in views)
    return Outcome(path, folder, message, summaries, damage=results["input"]["damage"], ambiguous_views=ambiguous)
