"""Small labelled sessions in memory: balls, planks and sticks, every instance another one."""

import numpy as np

from orbitscan.recorder.session import SessionInfo, View, in_memory

SHAPES = {"ball": (1.0, 1.0, 1.0), "plank": (1.0, 0.7, 0.08), "stick": (1.0, 0.1, 0.1)}
SIZES = {"ball": 0.05, "plank": 0.05, "stick": 0.05}  # metres


def cloud(name, rng, points=200):
    """Points on an ellipsoid of a shape, a third of a metre away."""
    directions = rng.normal(size=(points, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    stretched = directions * np.array(SHAPES[name]) * rng.uniform(0.8, 1.2, 3) * SIZES[name]
    return (stretched + np.array([0, 0, 0.3])).astype(np.float32)


def session(name, instance, views=4, category=True, elevation=45.0, per_turn=None):
    """One session of a shape."""
    rng = np.random.default_rng([instance, *name.encode()])
    clouds = [cloud(name, rng) for _ in range(views)]
    info = SessionInfo(
        name=f"{name}_{instance}",
        views=views,
        category=name if category else None,
        instance=str(instance),
        capture="circle",
        elevation_deg=elevation,
        views_per_turn=per_turn or views,
    )
    return in_memory(info, [View(i, f"v{i}", (i + 1) * 10**9, points) for i, points in enumerate(clouds)])


def sessions(names=tuple(SHAPES), instances=4, views=4):
    """Several instances of each shape."""
    return [session(name, i, views) for name in names for i in range(1, instances + 1)]
