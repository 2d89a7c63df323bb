"""The recording that is damaged, and what of it is whole in a damaged copy: told by its bytes, not by our reader."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from orbitscan.recorder import mcap_file
from orbitscan.recorder.session import Session, SessionInfo, in_memory
from tests.fuzz.mutations import MAGIC, Bytes
from tests.geometry import scan

VIEWS = 3
Stretch = tuple[int, int]  # start and length


@dataclass(frozen=True, eq=False)
class Original:
    """A recording of three tiny views in colour, with true poses."""

    session: Session
    content: bytes
    clouds: dict[int, Stretch]  # view -> its chunk
    poses: dict[int, Stretch]
    metadata: dict[str, Stretch]


@dataclass(frozen=True)
class Whole:
    """What of the original is in a damaged copy, unbroken."""

    views: set[int]
    poses: set[int]
    facts: bool
    names: bool
    either_end: bool  # a file that neither begins nor ends as an MCAP is none


def make_original(folder: Path) -> Original:
    """Write the recording and note, by mcap's own reader, where its records are."""
    bare = scan(n_views=VIEWS, points=2500)
    rng = np.random.default_rng(0)
    views = [
        type(view)(
            view.index,
            f"scan{45 * view.index:03d}",
            1_700_000_000_000_000_000 + view.index * 10**8,
            view.points,
            rng.integers(0, 256, view.points.shape, dtype=np.uint8),
        )
        for view in bare.views()
    ]
    info = SessionInfo(
        "blob", VIEWS, "coffee_mug", "3", "clouds", "Kinect", "circle", (0.0, 0.0, 0.0), elevation_deg=24.0
    )
    path = folder / "original.mcap"
    mcap_file.write(in_memory(info, views, bare.truth()), path)
    clouds, poses = {}, {}
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
        messages = list(reader.iter_messages(log_time_order=False))
        for chunk, (_, channel, message) in zip(chunks, messages, strict=True):
            kind = {mcap_file.POINTS_TOPIC: clouds, mcap_file.POSES_TOPIC: poses}[channel.topic]
            kind[message.sequence] = chunk.chunk_start_offset, chunk.chunk_length
        metadata = {index.name: (index.offset, index.length) for index in summary.metadata_indexes}
    assert set(clouds) == set(poses) == set(range(VIEWS))
    return Original(mcap_file.read(path), path.read_bytes(), clouds, poses, metadata)


def find_whole(original: Original, damaged: Bytes) -> Whole:
    """What of the original a damaged copy still holds."""
    size = len(original.content)
    ends = range(MAGIC), range(size - MAGIC, size)
    found = damaged.origin[:MAGIC], damaged.origin[-MAGIC:]
    return Whole(
        views={view for view, stretch in original.clouds.items() if damaged.whole(*stretch)},
        poses={view for view, stretch in original.poses.items() if damaged.whole(*stretch)},
        facts=damaged.whole(*original.metadata["scan_session"]),
        names=damaged.whole(*original.metadata["scan_views"]),
        either_end=any(np.array_equal(a, b) for a, b in zip(found, ends, strict=True)),
    )
