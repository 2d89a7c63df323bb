"""What a recording holds, read back, and how legible its colours are."""

import subprocess
from pathlib import Path

import numpy as np
from rerun.chunk import RrdReader

from orbitscan.processing.review import entities
from tests import viewer


def read_rows(path: Path, content: str, column: str) -> dict[str, dict[int, list]]:
    """Entity -> recorded index -> cell; a static cell is at -1."""
    rows: dict[str, dict[int, list]] = {}
    for chunk in RrdReader(path).stream().filter(content=content):
        batch = chunk.to_record_batch()
        if column in batch.schema.names:
            times = batch.column("view").to_pylist() if "view" in batch.schema.names else [-1] * batch.num_rows
            rows.setdefault(chunk.entity_path, {}).update(zip(times, batch.column(column).to_pylist(), strict=True))
    return rows


def read_all(path: Path, content: str, column: str) -> list:
    """The first item of every cell, several at one view included."""
    batches = [chunk.to_record_batch() for chunk in RrdReader(path).stream().filter(content=content)]
    return [cell[0] for batch in batches if column in batch.schema.names for cell in batch.column(column).to_pylist()]


def run_rerun(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([viewer.RERUN, *map(str, arguments)], capture_output=True, text=True)


def packed(color: entities.Color) -> int:
    """A colour as Rerun keeps it."""
    return int.from_bytes(bytes([*color, 255]), "big")


def contrast(color: entities.Color, background: entities.Color) -> float:
    """The contrast ratio of two colours (WCAG 2.1), 1 to 21."""
    bright, dark = sorted((_luminance(color), _luminance(background)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


def _luminance(color: entities.Color) -> float:
    c = np.array(color) / 255
    return float(np.where(c <= 0.03928, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722))
