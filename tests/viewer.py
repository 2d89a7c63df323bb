"""A headless Rerun viewer for tests, one for many recordings: what it could not draw, and pictures."""

import atexit
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import rerun as rr
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from orbitscan.processing.review import screenshot
from orbitscan.processing.review.screenshot import NoViewer, find_viewer, load, show_tab, start_viewer

__all__ = ["RERUN", "find_reports", "open_viewer", "probe", "show_tab"]

SIZE = "640x400"  # a software renderer's time goes into pixels
screenshot.SECONDS_TO_SETTLE = 0.3  # a view tells what it cannot draw in its first frame; no legend is looked at here
RERUN = find_viewer()  # the native program; the one on the PATH is a wrapper around it


@contextmanager
def open_viewer(recording: Path) -> Iterator[ViewerClient]:
    """A client of a viewer in which nothing but `recording` is open.

    The process's viewer, until a recording of the same application comes: a viewer keeps the layout of each, and would
    show a later one in an earlier one's.
    """
    application = _application_of(recording)
    if _running.client is None or application in _running.shown:
        _running.start()
    viewer = _running.client
    _running.shown.add(application)
    load(viewer, recording)
    try:
        yield viewer
    finally:
        viewer.close("all")
        _running.told = [entry.sequence for entry in viewer.get_logs()[-1:]]


class _Running:
    """The viewer of this process, and what it has shown."""

    def __init__(self) -> None:
        self.client: ViewerClient | None = None
        self.shown: set[str] = set()
        self.told: list[int] = []  # the number of the last log entry of the recordings before
        self._ends = ExitStack()
        atexit.register(self._ends.close)

    def start(self) -> None:
        self._ends.close()
        self.client = self._ends.enter_context(start_viewer(SIZE))
        self.shown, self.told = set(), []


_running = _Running()


def _application_of(recording: Path) -> str:
    if recording.suffix != ".rrd":
        return recording.suffix
    return RrdReader(recording).recordings()[0].application_id


def find_reports(viewer: ViewerClient) -> list[str]:
    """What any view of the open recording warns of or could not draw, and errors logged since it was opened."""
    return screenshot.find_reports(viewer, *_running.told)


def probe() -> str | None:
    """Why no frame can be rendered on this machine; None where one was."""
    with TemporaryDirectory() as folder, rr.RecordingStream("probe") as stream:
        recording, shot = Path(folder) / "probe.rrd", Path(folder) / "probe.png"
        stream.save(recording)
        stream.log("point", rr.Points3D([[0, 0, 0]]))
        stream.disconnect()
        try:
            with start_viewer("64x64") as viewer:
                load(viewer, recording)
                viewer.save_screenshot(str(shot))
        except NoViewer as reason:
            return str(reason)
        return None if shot.is_file() else "the viewer takes no picture"


if __name__ == "__main__":
    sys.exit(probe())
