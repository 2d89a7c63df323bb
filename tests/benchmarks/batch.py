"""A batch of many small sessions: two workers against one, memory of a worker, seconds a session from first to last.

python -m tests.benchmarks.batch --sessions 100
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

from tests.faults import record

WANTED_RATIO, LIMIT_GB = 1.7, 1.0
_THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


@dataclass(frozen=True)
class Run:
    """What a batch took."""

    seconds: float
    sessions: np.ndarray  # (S,) seconds of each, in the order in which they were done
    memory_gb: dict[int, list[float]]  # of each process, over time


def main() -> None:
    """Run both batches, alternating, and print their ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sessions", type=int, default=100)
    parser.add_argument("--views", type=int, default=3, help="of a session, of some 3,000 points each")
    parser.add_argument("--repeat", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recordings = Path(folder) / "recordings"
        record(recordings, options.sessions, options.views)
        process(recordings, Path(folder) / "warm", 2)  # compiles, and fills the file cache
        runs = {workers: [] for workers in (1, 2)}
        for number in range(options.repeat):
            for workers, of_workers in runs.items():
                of_workers.append(process(recordings, Path(folder) / f"out_{workers}_{number}", workers))
    for workers, of_workers in runs.items():
        median = np.median([run.seconds for run in of_workers])
        peak = max(max(of_process) for run in of_workers for of_process in run.memory_gb.values())
        third = options.sessions // 3
        early, late = (
            np.median([run.sessions[part] for run in of_workers]) for part in (slice(third), slice(-third, None))
        )
        print(
            f"{workers} worker{'s' * (workers > 1)}, a thread each: {median:.1f} s for {options.sessions} sessions; "
            f"{early:.2f} s a session in the first third, {late:.2f} in the last; "
            f"at most {peak:.2f} GB a process (at most {LIMIT_GB})"
        )
    ratios = [one.seconds / two.seconds for one, two in zip(runs[1], runs[2], strict=True)]
    print(f"two workers are {np.median(ratios):.2f} times as fast as one (at least {WANTED_RATIO})")


def process(recordings: Path, results: Path, workers: int) -> Run:
    """Run the command with a thread for each worker, and watch it."""
    orbitscan = [sys.executable, "-c", "from orbitscan.processing.cli import main; main()"]
    command = [*orbitscan, "process", recordings, "-o", results, "--workers", str(workers)]
    memory: dict[int, list[float]] = {}
    started = time.perf_counter()
    threads = dict.fromkeys(_THREADS, str(workers))  # which the command divides among its workers
    with subprocess.Popen(command, env=os.environ | threads, stdout=subprocess.DEVNULL) as batch:
        while batch.poll() is None:
            for pid, gigabytes in _memory(batch.pid).items():
                memory.setdefault(pid, []).append(gigabytes)
            time.sleep(0.1)
    assert batch.returncode == 0, f"exit status {batch.returncode}"
    seconds = time.perf_counter() - started
    done = sorted(results.glob("*/timings.json"), key=lambda path: path.stat().st_mtime_ns)
    sessions = [json.loads(path.read_text())["total"] for path in done]
    return Run(seconds, np.array(sessions), memory)


def _memory(pid: int) -> dict[int, float]:
    """Resident memory [GB] of a process and its children."""
    found = {}
    try:
        parent = psutil.Process(pid)
        for process in (parent, *parent.children(recursive=True)):
            found[process.pid] = process.memory_info().rss / 1e9
    except psutil.NoSuchProcess:
        pass
    return found


if __name__ == "__main__":
    main()
