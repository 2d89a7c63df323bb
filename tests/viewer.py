"""A headless Rerun viewer for tests: opens a recording, tells what a view could not draw, takes its picture."""

import os
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import rerun_cli
from rerun.experimental import ViewerClient

RERUN = Path(rerun_cli.__file__).parent / "rerun"  # the native program; the one on the PATH is a wrapper around it
SECONDS_TO_START = 20.0
SECONDS_TO_LOAD = 30.0
SECONDS_TO_SETTLE = 0.6


class NoViewer(RuntimeError):
    """The viewer does not start here: it needs a Vulkan driver (Debian: mesa-vulkan-drivers)."""


@contextmanager
def open_viewer(recording: Path, size: str = "1920x1080") -> Iterator[ViewerClient]:
    """A client of a headless viewer that has loaded `recording`; the viewer ends with the block.

    Raises NoViewer where none starts.
    """
    port = _free_port()
    command = [str(RERUN), "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1", "--port", str(port)]
    with TemporaryDirectory() as scratch:
        process = subprocess.Popen(
            [*command, "--window-size", size],
            env={**os.environ, "RUST_LOG": "error", "TMPDIR": scratch},
            stderr=subprocess.DEVNULL,
        )
        try:
            viewer = _connect(process, port)
            viewer.open(str(recording.resolve()))
            deadline = time.monotonic() + SECONDS_TO_LOAD
            while viewer.get_state().loading:
                assert time.monotonic() < deadline, f"{recording} did not load in {SECONDS_TO_LOAD:.0f} s"
                time.sleep(0.1)
            time.sleep(SECONDS_TO_SETTLE)
            yield viewer
        finally:
            process.terminate()
            process.wait(timeout=10)


def find_reports(viewer: ViewerClient) -> list[str]:
    """What any view warns of or could not draw, hidden tabs included, and the errors the viewer itself logged."""
    reports = []
    for tab in range(_count_tabs(viewer)):
        show_tab(viewer, tab)
        reports += [
            f"{view.name}: {r.severity}: {r.summary}" for view in viewer.get_state().views for r in view.reports
        ]
    reports += [entry.message for entry in viewer.get_logs() if entry.level == "ERROR"]
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


def _count_tabs(viewer: ViewerClient) -> int:
    return max((len(strip["contents"]) for strip in _tab_strips(viewer.get_blueprint().blueprint)), default=1)


def _tab_strips(blueprint: dict[str, Any]) -> list[dict[str, Any]]:
    containers = [parts["ContainerBlueprint"] for parts in blueprint.values() if "ContainerBlueprint" in parts]
    return [c for c in containers if c["container_kind"] == "Tabs" and isinstance(c["contents"], list)]


def _connect(process: subprocess.Popen, port: int) -> ViewerClient:
    deadline = time.monotonic() + SECONDS_TO_START
    while process.poll() is None and time.monotonic() < deadline:
        try:
            viewer = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            viewer.get_state()
            return viewer
        except Exception:
            time.sleep(0.1)
    raise NoViewer(NoViewer.__doc__)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
