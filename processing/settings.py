"""Every step's settings, assembled; TOML in."""

import tomllib
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from orbitscan.processing.features.keypoints import KeypointSettings
from orbitscan.processing.features.shot import ShotSettings
from orbitscan.processing.reconstruction.coverage import CoverageSettings
from orbitscan.processing.reconstruction.model import ModelSettings
from orbitscan.processing.reconstruction.pose_graph import GraphSettings
from orbitscan.processing.reconstruction.turntable import TurntableSettings
from orbitscan.processing.registration.matching import MatchSettings
from orbitscan.processing.registration.pair import PairSettings
from orbitscan.processing.registration.ransac import RansacSettings
from orbitscan.processing.surface.preparation import SurfaceSettings
from orbitscan.recorder.exceptions import InvalidOption

Kind = TypeVar("Kind")
THESIS_METHODS = ("icp", "ransac_icp")  # all else the thesis gives is the default already


@dataclass(frozen=True)
class Settings:
    """All that steers the processing, a class for each step; the class names what the thesis gives."""

    surface: SurfaceSettings = field(default_factory=SurfaceSettings)
    keypoints: KeypointSettings = field(default_factory=KeypointSettings)
    shot: ShotSettings = field(default_factory=ShotSettings)
    matching: MatchSettings = field(default_factory=MatchSettings)
    ransac: RansacSettings = field(default_factory=RansacSettings)
    pair: PairSettings = field(default_factory=PairSettings)
    graph: GraphSettings = field(default_factory=GraphSettings)
    turntable: TurntableSettings = field(default_factory=TurntableSettings)
    coverage: CoverageSettings = field(default_factory=CoverageSettings)
    model: ModelSettings = field(default_factory=ModelSettings)


def read_settings(path: Path, kind: type[Kind]) -> Kind:
    """The settings of a TOML file, a table for each step (`[ransac]`, `[pair.refinement]`); what is absent is default.

    Raises InvalidOption for a file that cannot be read, an unknown key or a value of the wrong type.
    """
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidOption(path, f"cannot be read ({error.strerror})", "name a TOML file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        remedy = "write lines such as '[ransac]' and 'tolerance = 3.0'"
        raise InvalidOption(path, f"is no TOML ({error})", remedy) from None
    if unknown := _unknown_keys(table, kind(), ""):
        key, known = unknown
        raise InvalidOption(path, f"there is no setting '{key}'", f"the settings there are {', '.join(known)}")
    try:
        return TypeAdapter(kind).validate_python(table)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"]))
        raise InvalidOption(path, f"{key}: {first['msg'].lower()}", "give such a value") from None


def _unknown_keys(table: dict[str, Any], settings: Any, prefix: str) -> tuple[str, list[str]] | None:
    """The first key that is no setting, and those there are in its place."""
    known = {f.name: getattr(settings, f.name) for f in fields(settings)}
    for key, value in table.items():
        if key not in known:
            return prefix + key, sorted(prefix + name for name in known)
        inner = known[key]
        if (
            is_dataclass(inner)
            and isinstance(value, dict)
            and (found := _unknown_keys(value, inner, f"{prefix}{key}."))
        ):
            return found
    return None
