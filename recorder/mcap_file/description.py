"""A session's facts and the names of its views as metadata, and back."""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from recorder.session import SessionInfo

FORMAT_VERSION = "1"


def info_to_metadata(info: SessionInfo, views: int) -> dict[str, str]:
    """What `scan_session` holds of a session of so many views."""
    origin = "unknown" if info.sensor_origin is None else " ".join(f"{c:g}" for c in info.sensor_origin)
    optional = {"elevation_deg": info.elevation_deg, "views_per_turn": info.views_per_turn}
    return {
        "name": info.name,
        "category": info.category or "",
        "instance": info.instance or "",
        "source": info.source,
        "sensor": info.sensor,
        "capture": info.capture,
        "sensor_origin": origin,
        "source_axes": info.source_axes,
        "source_units": info.source_units,
        "source_poses": info.source_poses,
        **{key: "" if value is None else f"{value:.12g}" for key, value in optional.items()},
        "views": str(views),
        "format_version": FORMAT_VERSION,
    }


def describe(
    path: Path, metadata: Mapping[str, Mapping[str, str]], views: Collection[int]
) -> tuple[SessionInfo, tuple[str, ...]]:
    """The session's facts and view names, from the metadata or, where these are lost, from the file itself."""
    raw = metadata.get("scan_session", {})
    named = metadata.get("scan_views", {})
    count = _number(raw.get("views")) or (max(views, default=-1) + 1)
    count = max(int(count), max(views, default=-1) + 1)
    names = tuple(named.get(str(i), f"view_{i:03d}") for i in range(min(count, 10**6)))
    origin = [_number(word) for word in raw.get("sensor_origin", "").split()]
    capture = raw.get("capture", "unknown")
    info = SessionInfo(
        name=raw.get("name") or path.name.removesuffix(".part").removesuffix(".mcap"),
        views=len(names),
        category=raw.get("category") or None,
        instance=raw.get("instance") or None,
        source=raw.get("source", ""),
        sensor=raw.get("sensor", ""),
        capture=capture if capture in ("circle", "unordered") else "unknown",
        sensor_origin=tuple(origin) if len(origin) == 3 and None not in origin else None,
        source_axes=raw.get("source_axes", "RDF"),
        source_units=raw.get("source_units", "m"),
        source_poses=raw.get("source_poses", ""),
        elevation_deg=_number(raw.get("elevation_deg")),
        views_per_turn=_number(raw.get("views_per_turn")),
    )
    return info, names


def _number(text: str | None) -> float | None:
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if np.isfinite(value) else None
