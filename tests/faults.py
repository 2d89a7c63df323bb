"""`make faults`: a batch that is killed again and again, and a disk that is full, cost time and nothing else.

Twelve small sessions are processed undisturbed, then into another folder by a batch that is killed (SIGKILL) at ten
random moments: in the second half of the kills with --overwrite, so that finished results are being replaced. After
each kill whatever stands under a session's name must be whole; at the end everything must be as undisturbed.
"""

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from orbitscan.recorder import mcap_file
from tests.command import ORBITSCAN, run
from tests.geometry import bottle, scan
from tests.viewer import RERUN

OPTIONS = ("--workers", "2", "--model", "none")
VOLATILE = ("timings.json", "review.rrd")  # they hold seconds
FAULTS = re.compile(r"Traceback|panicked|core dumped")


class NoSmallDisk(Exception):
    """This user may not mount a small file system."""


def record(folder: Path, sessions: int, views: int = 3) -> list[str]:
    """Small sessions, of two objects; their names."""
    for i in range(sessions):
        surface = {"surface": bottle} if i % 4 == 3 else {}
        mcap_file.write(scan(n_views=views, points=6000, seed=i, **surface), folder / f"session_{i:02d}.mcap")
    return [f"session_{i:02d}" for i in range(sessions)]


def start(recordings: Path, results: Path, *options: str) -> subprocess.Popen:
    """The batch, in a process group of its own."""
    return subprocess.Popen(
        [ORBITSCAN, "process", recordings, "-o", results, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def finish(recordings: Path, results: Path, *options: str) -> None:
    """An undisturbed batch, whose workers alone are processes."""
    batch = run("process", recordings, "-o", results, *options, cwd=recordings.parent)
    printed = batch.stdout + batch.stderr
    assert batch.returncode == 0, printed
    assert not FAULTS.search(printed), printed


def kill(batch: subprocess.Popen, alone: bool) -> None:
    """The command's process alone, whose workers must then end by themselves, or all of them."""
    (os.kill if alone else os.killpg)(batch.pid, signal.SIGKILL)
    batch.communicate(timeout=60)  # its output ends when the last worker has ended


def compare(results: Path, undisturbed: Path, names: Sequence[str], complete: bool) -> None:
    """Raises AssertionError where anything under a session's name is not what an undisturbed batch makes."""
    for name in names:
        folder, expected = results / name, undisturbed / name
        if not folder.exists():
            assert not complete, f"{name} is lost"
            continue
        assert {p.name for p in folder.iterdir()} == {p.name for p in expected.iterdir()}, f"{name} is not whole"
        for path in expected.iterdir():
            if path.name not in VOLATILE:
                assert (folder / path.name).read_bytes() == path.read_bytes(), f"{name}/{path.name} differs"
        verified = subprocess.run([RERUN, "rrd", "verify", folder / "review.rrd"], capture_output=True, text=True)
        assert verified.returncode == 0, f"{name}: {verified.stderr}"
    if complete:
        listed = {path.name for path in undisturbed.iterdir()}
        assert {path.name for path in results.iterdir()} == listed, "something is left over, or missing"


def prepare(work: Path, sessions: int) -> list[str]:
    """Recordings, and the results of an undisturbed batch, unless they are there; the names."""
    if not (work / "undisturbed").exists():
        record(work / "recordings", sessions)
        finish(work / "recordings", work / "undisturbed", *OPTIONS)
    return sorted(path.stem for path in (work / "recordings").iterdir())


def kill_at_random(work: Path, sessions: int, kills: int, seed: int) -> None:
    """Process undisturbed, then with kills, and compare."""
    rng = random.Random(seed)
    names = prepare(work, sessions)
    begun = time.monotonic()
    start(work / "recordings", work / "timed", *OPTIONS).communicate()
    duration = time.monotonic() - begun
    done = 0
    while done < kills:
        again = ("--overwrite",) if done >= kills / 2 else ()
        batch = start(work / "recordings", work / "results", *OPTIONS, *again)
        moment = rng.uniform(0.1, 0.9) * duration if again else rng.uniform(0.2, 0.5) * duration
        try:
            batch.communicate(timeout=moment)
        except subprocess.TimeoutExpired:
            kill(batch, alone=done % 2 == 0)
            done += 1
            compare(work / "results", work / "undisturbed", names, complete=False)
            left = sorted(path.name for path in (work / "results").glob("*.part*"))
            whole = sum((work / "results" / name).exists() for name in names)
            print(f"kill {done} after {moment:.1f} s: {whole} of {sessions} whole, {', '.join(left) or 'nothing'} left")
        else:
            kills_left = f"{kills - done} kills are left: the next ones overwrite"
            print(f"ended before the kill at {moment:.1f} s; {kills_left}")
            done = max(done, (kills + 1) // 2)
    finish(work / "recordings", work / "results", *OPTIONS)
    compare(work / "results", work / "undisturbed", names, complete=True)


def kill_half_way(work: Path, sessions: int) -> None:
    """One kill, at a moment when a session is whole and another one is not, and compare."""
    names, results = prepare(work, sessions), work / "results"
    batch = start(work / "recordings", results, *OPTIONS)
    while not (any((results / name).exists() for name in names) and any(results.glob("*.part*"))):
        assert batch.poll() is None, "it ended before the kill"
        time.sleep(0.01)
    kill(batch, alone=True)
    compare(results, work / "undisturbed", names, complete=False)
    whole = {name: (results / name).stat().st_mtime_ns for name in names if (results / name).exists()}
    assert whole
    finish(work / "recordings", results, *OPTIONS)
    compare(results, work / "undisturbed", names, complete=True)
    assert whole == {name: (results / name).stat().st_mtime_ns for name in whole}, "what was whole is made again"


@contextmanager
def small_disk(folder: Path, kilobytes: int) -> Iterator[Path]:
    """A file system of so many kilobytes. Raises NoSmallDisk."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]
    try:
        subprocess.run(mount, check=True, capture_output=True)
    except (subprocess.CalledProcessError, FileNotFoundError) as reason:
        raise NoSmallDisk(NoSmallDisk.__doc__) from reason
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True, capture_output=True)


def fill_disk(work: Path, kilobytes: Sequence[int]) -> None:
    """A batch of three sessions onto disks of several sizes: whatever fits is whole, the rest is told in a sentence."""
    names = prepare(work, 3)
    for size in kilobytes:
        with small_disk(work / f"disk_{size}", size) as disk:
            batch = run("process", work / "recordings", "-o", disk / "results", "--model", "none", cwd=work)
            printed = batch.stdout + batch.stderr
            assert batch.returncode in (1, 2), f"exit status {batch.returncode}: {printed}"
            assert not FAULTS.search(printed), printed
            assert "cannot be written" in printed, printed
            compare(disk / "results", work / "undisturbed", names, complete=False)
            assert not list(disk.glob("results/*.part*")), "half a folder is left"
            whole = sum((disk / "results" / name).exists() for name in names)
            print(f"a disk of {size} kB: {whole} of 3 sessions whole, exit status {batch.returncode}")


def main(seed: str = "0") -> None:
    """Twelve sessions, ten kills; then full disks."""
    with TemporaryDirectory() as work:
        kill_at_random(Path(work), sessions=12, kills=10, seed=int(seed))
    print("Killed ten times, the same to the byte.")
    with TemporaryDirectory() as work:
        try:
            fill_disk(Path(work), (64, 1100, 1500, 2000, 2600, 3300, 4000))
        except NoSmallDisk as reason:
            print(f"Full disks were not tried: {reason}")


if __name__ == "__main__":
    main(*sys.argv[1:])
