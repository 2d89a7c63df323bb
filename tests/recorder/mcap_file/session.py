"""A recorded session, and where in its file the views are, for tests of the file."""

import numpy as np
from mcap.reader import make_reader

from orbitscan.recorder.session import SessionInfo, View, in_memory
from tests.geometry import random_pose


def make_session(views=6, points=200, colors=True, seed=0, missing=()):
    rng = np.random.default_rng(seed)
    clouds = [
        View(
            index=i,
            name=f"scan{i * 45:03d}",
            stamp_ns=1_700_000_000_123_456_789 + i,
            points=rng.normal(size=(points + i, 3)).astype(np.float32),
            colors=rng.integers(0, 256, (points + i, 3), dtype=np.uint8) if colors else None,
        )
        for i in range(views)
    ]
    info = SessionInfo(
        name="mug",
        views=views,
        category="coffee_mug",
        instance="3",
        source="clouds",
        sensor="Kinect",
        capture="circle",
        sensor_origin=(0.125, 0.0, -10.0),
        source_axes="RUB",
        source_units="mm",
        source_poses="object-to-camera RUB mm",
        elevation_deg=30.0,
        views_per_turn=17.25,
    )
    return in_memory(info, clouds, {i: random_pose(rng) for i in range(views) if i not in missing})


def assert_same_view(found, view):
    assert (found.index, found.name, found.stamp_ns, found.damage) == (view.index, view.name, view.stamp_ns, None)
    assert found.points.dtype == np.float32
    np.testing.assert_array_equal(found.points, view.points)
    if view.colors is None:
        assert found.colors is None
    else:
        assert found.colors.dtype == np.uint8
        np.testing.assert_array_equal(found.colors, view.colors)


def assert_same(found, session):
    assert found.info == session.info
    assert found.names == session.names
    for view in session.views():
        assert_same_view(found.load(view.index), view)
    assert set(found.truth()) == set(session.truth())
    for i, T in session.truth().items():
        np.testing.assert_allclose(found.truth()[i], T, atol=1e-12)


def cloud_offsets(path):
    """Offset and length of each view's chunk."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    channel = next(c.id for c in summary.channels.values() if c.topic == "/camera/points")
    chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    return [(c.chunk_start_offset, c.chunk_length) for c in chunks if channel in c.message_index_offsets]


def damage_chunk(path, where):
    offset, length = where
    content = bytearray(path.read_bytes())
    content[offset + length // 2] ^= 0x10
    path.write_bytes(content)
