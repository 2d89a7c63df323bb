"""A session's facts and the names of its views as metadata, and back.

MCAP has no CRC for metadata: a flipped bit in the sensor's origin would turn normals unseen. So each of our records
holds one of its own, `crc32`. Recordings of format 1 have none, and are believed as they are.
"""

import zlib
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import cast, get_args

import numpy as np
from mcap.records import Metadata

from orbitscan.recorder.session import Capture, SessionInfo

FORMAT_VERSION = "2"  # 1 has no CRC in the metadata
SESSION, VIEWS = "scan_session", "scan_views"  # names of the records
LOST_AT_MOST = 10_000  # views; a count or a number that says more are missing is wrong itself
_KNOWN = "known"
_CRC, _PLAIN = "crc32", "1"  # key of the CRC; version of the format without


def seal(name: str, entries: Mapping[str, str]) -> dict[str, str]:
    """The entries of a metadata record and the CRC-32 of them, in hexadecimal.

    It is taken of the record's name and then, sorted by key, of each key and value, all UTF-8 and each with a zero byte
    behind it: tools that write an .mcap anew may sort the entries otherwise.
    """
    return {**entries, _CRC: f"{_crc32(name, entries):08x}"}


def believe(records: Iterable[Metadata]) -> dict[str, dict[str, str]]:
    """Name -> entries of the metadata records that are right, the first of a name.

    Ours are right by their CRC, or where all are without and say that they are of the first format, which had none.
    Those of other programs are not ours to judge.
    """
    records = list(records)
    ours = [record.metadata for record in records if record.name in (SESSION, VIEWS)]
    plain = any(entries.get("format_version") == _PLAIN for entries in ours)
    plain = plain and not any(_CRC in entries for entries in ours)
    believed: dict[str, dict[str, str]] = {}
    for record in records:
        entries = dict(record.metadata)
        if record.name in (SESSION, VIEWS):
            crc = entries.pop(_CRC, None)
            if not plain and crc != f"{_crc32(record.name, entries):08x}":
                continue
        believed.setdefault(record.name, entries)
    return believed


def _crc32(name: str, entries: Mapping[str, str]) -> int:
    words = [name, *(word for entry in sorted(entries.items()) for word in entry)]
    return zlib.crc32("".join(f"{word}\0" for word in words).encode())


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
        **({"outline": _KNOWN} if info.outline_known else {}),
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
    raw = metadata.get(SESSION, {})
    named = metadata.get(VIEWS, {})
    seen, told = max(views, default=-1) + 1, int(_number(raw.get("views")) or 0)
    count = max(seen, told) if told <= len(views) + LOST_AT_MOST else seen
    names = tuple(named.get(str(i), f"view_{i:03d}") for i in range(count))
    words = raw.get("sensor_origin", "").split()
    origin = [number for word in words if (number := _number(word)) is not None]
    capture = raw.get("capture", "unknown")
    info = SessionInfo(
        name=raw.get("name") or path.name.removesuffix(".part").removesuffix(".mcap"),
        views=len(names),
        category=raw.get("category") or None,
        instance=raw.get("instance") or None,
        source=raw.get("source", ""),
        sensor=raw.get("sensor", ""),
        capture=cast(Capture, capture) if capture in get_args(Capture) else "unknown",
        sensor_origin=(origin[0], origin[1], origin[2]) if len(origin) == len(words) == 3 else None,
        outline_known=raw.get("outline") == _KNOWN,
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
