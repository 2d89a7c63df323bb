"""The memory of a long session: a thousand views recorded, processed by the command, and its peak printed.

python -m tests.benchmarks.memory --views 1000
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.progress import track

from orbitscan.recorder import mcap_file
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation.camera import simulate

LIMIT_GB = 1.5


def main() -> None:
    """Print the peak resident memory for the number of views on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--views", type=int, default=1000)
    views = parser.parse_args().views
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "robot.mcap"
        mcap_file.write(_shown(simulate("robot", views=views)), recording)
        orbitscan = [sys.executable, "-c", "from orbitscan.processing.cli import main; main()"]
        command = [*orbitscan, "process", recording, "-o", folder, "--views", "all"]
        started = time.perf_counter()
        status = subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode
        minutes = (time.perf_counter() - started) / 60
        size = sum(path.stat().st_size for path in (Path(folder) / "robot").iterdir()) / 1e9
    peak = peak_of_children()
    shown = "not known on this system" if peak is None else f"{peak:.2f} GB resident at its peak (at most {LIMIT_GB})"
    print(f"{views} views through the command (status {status}): {shown}, {minutes:.1f} min, results of {size:.2f} GB")


def peak_of_children() -> float | None:
    """The most memory [GB] that a finished child process had resident; None on Windows."""
    return _peak("RUSAGE_CHILDREN")


def peak_of_this_process() -> float | None:
    """The most memory [GB] that this process had resident; None on Windows."""
    return _peak("RUSAGE_SELF")


def _peak(who: str) -> float | None:
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024  # bytes on macOS, else KiB
    return resource.getrusage(getattr(resource, who)).ru_maxrss * unit / 1e9


def _shown(session: Session) -> Session:
    """The session, with progress as its views are rendered."""
    views = track(range(len(session.names)), "Rendering", console=Console(file=sys.stderr))
    steps = iter(views)

    def load(index: int) -> object:
        next(steps, None)
        return session.load(index)

    return Session(session.info, session.names, load, session.load_truth)


if __name__ == "__main__":
    main()
