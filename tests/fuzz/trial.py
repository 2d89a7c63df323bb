"""One damaged recording through `info`, `check` and `process`."""

import json
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from orbitscan.processing.batch.compilation import ensure_compiled
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnreadableRecording
from tests.fuzz.commands import peak_mb, run_command
from tests.fuzz.mutations import mutate
from tests.fuzz.original import VIEWS, Original, find_whole, make_original
from tests.fuzz.verdict import Usual, judge_commands, judge_end, judge_session

LIMIT_MB = 1000.0  # beyond what this process has taken before; an absurd length would take more


@dataclass(frozen=True)
class Trial:
    """What became of one damaged recording."""

    number: int
    kinds: list[str]
    what: str
    outcome: str  # whole, part or refused
    views: tuple[int, int]  # whole in the file, and come out
    seconds: float  # of the slowest command
    complaints: list[str]
    peak_mb: float  # of memory that this process has taken so far; 0 where it cannot be told


def run_trials(numbers: range) -> list[Trial]:
    """The trials of these numbers."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        original = make_original(folder)
        usual = process_undamaged(original, folder)
        return [run_trial(original, number, folder, usual) for number in numbers]


def run_trial(original: Original, number: int, folder: Path, usual: Usual) -> Trial:
    """Damage the recording by the number, run the commands on it in a folder, and look at all that comes out."""
    damaged, kinds, what = mutate(original.content, number)
    whole = find_whole(original, damaged)
    path, results = folder / "damaged.mcap", folder / "results"
    path.write_bytes(damaged.values.tobytes())
    shutil.rmtree(results, ignore_errors=True)
    before_mb = peak_mb()
    ended = {
        "info": run_command("info", str(path)),
        "check": run_command("check", str(path)),
        "process": run_command("process", str(path), "-o", str(results), *usual.options),
    }
    complaints = [f"{name}: {complaint}" for name, end in ended.items() for complaint in judge_end(end)]
    if peak_mb() - before_mb > LIMIT_MB:
        complaints.append(f"takes {peak_mb() - before_mb:.0f} MB")
    try:
        session = mcap_file.read(path)
    except UnreadableRecording as refusal:
        complaints += [f"{name} ends with {end.status}" for name, end in ended.items() if end.status != 2]
        if whole.views and whole.either_end:
            complaints.append(f"refused, with {sorted(whole.views)} whole: {refusal}")
        seconds = max(end.seconds for end in ended.values())
        return Trial(number, kinds, what, "refused", (len(whole.views), 0), seconds, complaints, peak_mb())
    readable, found = judge_session(session, original, whole)
    complaints += found
    complaints += judge_commands(ended, session, readable, results / "damaged", original, whole, usual)
    seconds = max(end.seconds for end in ended.values())
    outcome = "whole" if len(readable) == VIEWS else "part"
    return Trial(number, kinds, what, outcome, (len(whole.views), len(readable)), seconds, complaints, peak_mb())


def process_undamaged(original: Original, folder: Path, options: Sequence[str] = ()) -> Usual:
    """What `process` finds for the undamaged recording."""
    ensure_compiled()  # the one thing that may take longer than the limit
    path = folder / "undamaged.mcap"
    path.write_bytes(original.content)
    end = run_command("process", str(path), "-o", str(folder / "usual"), *options)
    assert end.status == 0, end
    return Usual(tuple(options), json.loads((folder / "usual" / "undamaged" / "results.json").read_text()))
