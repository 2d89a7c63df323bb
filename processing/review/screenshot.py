"""A recording as it opens, without a display: a headless Rerun viewer that loads it, complains, and is photographed."""

import os
import socket
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO, cast

import rerun_cli
from rerun.experimental import ViewerClient

from orbitscan.processing.review.entities import VIEW_TIMELINE
from orbitscan.recorder.atomic import whole_file
from orbitscan.recorder.exceptions import InvalidOption, MissingLibrary, UnreadableRecording, UnwritableOutput, setting

SIZE = "1920x1080"
SECONDS_TO_START = 60.0  # a slow machine, with other work
SECONDS_TO_LOAD = 60.0
SECONDS_TO_SETTLE = 0.6  # legends and ranges of plots come a few frames after the data
SECONDS_OF_NOTICES = 2.0  # the viewer tells for so long, in a corner, that it loaded something
_NO_DRIVER = ("render context", "No graphics adapter")  # the last words of a viewer that finds no driver
_MAKE_AGAIN = "make it again: it is cut, damaged, or no recording at all"


class NoViewer(MissingLibrary):
    """The viewer does not start here."""


def find_viewer() -> Path:
    """The native viewer that comes with Rerun: what is on the PATH is a wrapper, which hides its exit status.

    `RERUN_CLI_PATH` names another one, as it does for the wrapper.
    """
    folder = Path(rerun_cli.__file__).parent
    bundled = folder / "Rerun.app" / "Contents" / "MacOS" / "Rerun"
    plain = folder / ("rerun.exe" if sys.platform == "win32" else "rerun")
    viewer = Path(os.environ.get("RERUN_CLI_PATH") or (bundled if bundled.is_file() else plain))
    if not viewer.is_file():
        raise NoViewer(viewer, "the Rerun viewer is not there", "install rerun-sdk again")
    return viewer


def take_picture(recording: Path, picture: Path, size: str = SIZE, view: int | None = None) -> list[str]:
    """Save what the viewer shows of a recording as a PNG, whole or not at all; the answer is what it complains of.

    The cursor is where the recording opens, or at the recorded `view`. Raises NoViewer, UnwritableOutput and
    InvalidOption.
    """
    if picture.suffix.lower() != ".png":
        raise UnwritableOutput(picture, "a picture is a PNG", "let its name end with .png")
    if not picture.parent.is_dir():
        raise UnwritableOutput(picture, "its folder does not exist", "make the folder, or name another")
    _check(recording, view)
    with whole_file(picture, keep_suffix=True, failures=OSError) as part, open_viewer(recording, size) as viewer:
        if view is not None:
            viewer.set_time(VIEW_TIMELINE, sequence=view, play_state="paused")
        time.sleep(SECONDS_OF_NOTICES)
        viewer.save_screenshot(str(part.resolve()))
        reports = find_reports(viewer)
    return reports


@contextmanager
def open_viewer(recording: Path, size: str = SIZE) -> Iterator[ViewerClient]:
    """A client of a headless viewer that has loaded `recording`; the viewer ends with the block.

    Raises NoViewer where none starts, or it ends, and UnreadableRecording where it does not load.
    """
    with start_viewer(size) as viewer:
        load(viewer, recording)
        yield viewer


@contextmanager
def start_viewer(size: str = SIZE) -> Iterator[ViewerClient]:
    """A client of a headless viewer, which ends with the block. Raises NoViewer where none starts, or it ends."""
    port = _free_port()
    command = [str(find_viewer()), "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1", "--port", str(port)]
    with TemporaryDirectory() as scratch, (Path(scratch) / "stderr").open("w+b") as stderr:
        process = subprocess.Popen(
            [*command, "--window-size", size],
            env={**os.environ, "RUST_LOG": "error", "TMPDIR": scratch},
            stdout=subprocess.DEVNULL,
            stderr=stderr,
        )
        try:
            yield cast(ViewerClient, _PatientViewer(_connect(process, port)))
        except ConnectionError as error:
            raise _explain(error, process, stderr) from None
        finally:
            process.terminate()
            process.wait(timeout=10)


def load(viewer: ViewerClient, recording: Path) -> None:
    """Raises UnreadableRecording where the viewer does not load a recording."""
    deadline = time.monotonic() + SECONDS_TO_LOAD
    viewer.open(str(recording.resolve()))
    while viewer.get_state().loading:
        if time.monotonic() > deadline:
            problem = f"the viewer does not load it in {SECONDS_TO_LOAD:.0f} s"
            raise UnreadableRecording(recording, problem, "open it with 'orbitscan view' and see why")
        time.sleep(0.1)
    if not viewer.get_state().recordings:
        raise UnreadableRecording(recording, "the viewer finds no recording in it", _MAKE_AGAIN)
    time.sleep(SECONDS_TO_SETTLE)


def find_reports(viewer: ViewerClient, after: int | None = None) -> list[str]:
    """What any view warns of or could not draw, hidden tabs included, and the errors the viewer itself logged.

    `after` is the sequence number of a log entry: those up to it are of recordings that were open before.
    """
    reports = []
    for tab in range(_count_tabs(viewer)):
        show_tab(viewer, tab)
        reports += [
            f"{view.name}: {r.severity}: {r.summary}" for view in viewer.get_state().views for r in view.reports
        ]
    reports += [entry.message for entry in viewer.get_logs(after) if entry.level == "ERROR"]
    return list(dict.fromkeys(reports))


def show_tab(viewer: ViewerClient, tab: int) -> None:
    """Brings the tab of that number (from 0; the last one where there are fewer) to the front in every tab strip."""
    shown = viewer.get_blueprint()
    strips = _tab_strips(shown.blueprint)
    for strip in strips:
        strip["active_tab"] = strip["contents"][min(tab, len(strip["contents"]) - 1)]
    if strips:
        viewer.set_blueprint(shown.blueprint, store_id=shown.store_id)
    time.sleep(SECONDS_TO_SETTLE)


def _check(recording: Path, view: int | None) -> None:
    """Raises UnreadableRecording for a cut .rrd, of which a viewer may show half, InvalidOption for no such view."""
    from rerun.chunk import RrdReader

    views: set[int] = set()
    try:
        with warnings.catch_warnings(action="ignore"):  # what a killed run leaves has no footer
            chunks = RrdReader(recording).stream() if recording.suffix.lower() == ".rrd" else ()
            for chunk in chunks:
                if VIEW_TIMELINE in chunk.timeline_names:
                    views.update(chunk.to_record_batch().column(VIEW_TIMELINE).to_pylist())
    except RuntimeError:
        raise UnreadableRecording(recording, "no whole Rerun recording", _MAKE_AGAIN) from None
    if view is not None and view not in views:
        remedy = f"there are {min(views)} to {max(views)}" if views else "leave it out: the recording has no views"
        raise InvalidOption(setting("at", view), "no such view in the recording", remedy)


def _count_tabs(viewer: ViewerClient) -> int:
    return max((len(strip["contents"]) for strip in _tab_strips(viewer.get_blueprint().blueprint)), default=1)


def _tab_strips(blueprint: dict[str, Any]) -> list[dict[str, Any]]:
    containers = [parts["ContainerBlueprint"] for parts in blueprint.values() if "ContainerBlueprint" in parts]
    return [c for c in containers if c["container_kind"] == "Tabs" and isinstance(c["contents"], list)]


def _connect(process: subprocess.Popen, port: int) -> ViewerClient:
    """A client of a viewer that has just been started. Raises ConnectionError."""
    deadline = time.monotonic() + SECONDS_TO_START
    while True:
        try:
            viewer = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            viewer.get_state()
            return viewer
        except ConnectionError:
            if process.poll() is not None or time.monotonic() > deadline:
                raise
            time.sleep(0.1)


class _PatientViewer:
    """A client whose calls are made again while the viewer is only slow: none of those we make adds up."""

    def __init__(self, viewer: ViewerClient) -> None:
        self._viewer = viewer

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            deadline = time.monotonic() + SECONDS_TO_LOAD
            while True:
                try:
                    return getattr(self._viewer, name)(*arguments, **named)
                except ConnectionError as error:
                    if not _is_slow(error) or time.monotonic() > deadline:
                        raise

        return call


def _is_slow(error: ConnectionError) -> bool:
    return "deadline" in str(error).lower() or "timeout" in str(error).lower()


def _explain(error: ConnectionError, process: subprocess.Popen, stderr: BinaryIO) -> Exception:
    """What an error of the connection means: the viewer ended, or is slow; any other is returned as it is.

    Everything that a viewer tells comes as an error of the connection; that the other end is gone may show at once.
    """
    with suppress(subprocess.TimeoutExpired):
        process.wait(timeout=1.0)
    if process.poll() is None:
        if not _is_slow(error):
            return error
        problem = f"does not answer within {SECONDS_TO_LOAD:.0f} s"
        return NoViewer("the viewer", problem, "try again when less is running")
    stderr.seek(0)
    last = stderr.read().decode("utf-8", "replace")
    if any(words in last for words in _NO_DRIVER):
        problem = "does not start without a display here: it finds no Vulkan driver"
        return NoViewer("the viewer", problem, "on Debian and Ubuntu: apt install mesa-vulkan-drivers libvulkan1")
    said = next((line.strip() for line in last.splitlines() if "panicked" in line), "")
    problem = f"ended with status {process.returncode}{said and f' ({said})'}"
    return NoViewer("the viewer", problem, "see whether 'rerun' starts here")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
