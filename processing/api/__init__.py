"""orbitscan: scans of objects, recorded as MCAP, registered into the whole object, reviewed in Rerun.

    session = orbitscan.open("mug.mcap")
    *views, result = orbitscan.process(session.views(), session.info)

Each name is loaded when it is first asked for: `import orbitscan` itself loads nothing (PEP 562).
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orbitscan.processing.classification.classifier import classify
    from orbitscan.processing.pipeline import process
    from orbitscan.processing.pose_errors import with_errors
    from orbitscan.processing.results.folder import read_results
    from orbitscan.processing.settings import Settings
    from orbitscan.recorder.exceptions import ScanError
    from orbitscan.recorder.mcap_file import read as open
    from orbitscan.recorder.session import Session
    from orbitscan.recorder.simulation.camera import simulate

    __version__: str

__all__ = [
    "ScanError",
    "Session",
    "Settings",
    "__version__",
    "classify",
    "open",
    "process",
    "read_results",
    "simulate",
    "with_errors",
]

_HOMES = {  # name -> its module, and what it is called there
    "ScanError": ("recorder.exceptions", "ScanError"),
    "Session": ("recorder.session", "Session"),
    "Settings": ("processing.settings", "Settings"),
    "classify": ("processing.classification.classifier", "classify"),
    "open": ("recorder.mcap_file", "read"),
    "process": ("processing.pipeline", "process"),
    "read_results": ("processing.results.folder", "read_results"),
    "simulate": ("recorder.simulation.camera", "simulate"),
    "with_errors": ("processing.pose_errors", "with_errors"),
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        value = version(__name__)
    elif name in _HOMES:
        module, attribute = _HOMES[name]
        value = getattr(import_module(f"{__name__}.{module}"), attribute)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
