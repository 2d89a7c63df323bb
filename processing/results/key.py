"""What results depend on: a complete folder with the same key need not be made again."""

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any


def input_sha256(path: Path) -> str:
    """The SHA-256 of a file, hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def make_key(
    sha256: str, model: str | None, views: str, methods: tuple[str, ...], settings: Mapping[str, Any], seed: int
) -> dict[str, Any]:
    """The key of the results of a recording, by the SHA-256 of its file and of the classifier's."""
    key = {
        "orbitscan": version("orbitscan"),
        "input_sha256": sha256,
        "model_sha256": model,
        "views": views,
        "methods": list(methods),
        "settings": settings,
        "seed": seed,
    }
    return json.loads(json.dumps(key))  # as it is read back: a tuple is a list there


def read_key(folder: Path) -> dict[str, Any] | None:
    """The key of a complete results folder, of an earlier version too; None where there is none."""
    try:
        return dict(json.loads((folder / "results.json").read_text(encoding="utf-8"))["key"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def changed(known: Mapping[str, Any] | None, key: Mapping[str, Any]) -> str | None:
    """Which parts of the key differ from a folder's, in words; None where none does."""
    if known is None:
        return None
    return ", ".join(name.replace("_", " ") for name in key if known.get(name) != key[name]) or None
