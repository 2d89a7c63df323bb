"""Parametric meshes of known objects in real sizes: every instance of an object is another one, drawn from a seed.

The object's frame: z up, standing on z = 0, its bounding box centred on the z axis, its front towards +x. A module
per object builds it from a random generator; `build` places it in that frame. Where a module has `STYLES`, a tuple of
builders, the instances take them in turn: with n styles, instances 1, 1 + n, 1 + 2n, ... are of the first.

CATEGORIES are what the classifier tells apart, OTHERS what it must not take for one of them.
"""

import numpy as np

from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects import (
    apple,
    bell_pepper,
    bin,
    bowl,
    cap,
    cell_phone,
    coffee_mug,
    dry_battery,
    helicopter,
    notebook,
    others,
    pliers,
    robot,
    statue,
    vacuum_cleaner,
    water_bottle,
)

CATEGORIES = (
    "apple",
    "bell_pepper",
    "bowl",
    "cap",
    "cell_phone",
    "coffee_mug",
    "dry_battery",
    "notebook",
    "pliers",
    "water_bottle",
)
OTHERS = tuple(builder.__name__ for builder in others.BUILDERS)
_STYLES = {
    module.__name__.rpartition(".")[2]: getattr(module, "STYLES", None) or (module.build,)
    for module in (
        bin,
        coffee_mug,
        robot,
        bowl,
        cap,
        cell_phone,
        helicopter,
        notebook,
        pliers,
        statue,
        vacuum_cleaner,
        water_bottle,
        apple,
        bell_pepper,
        dry_battery,
    )
} | {builder.__name__: (builder,) for builder in others.BUILDERS}


def names() -> tuple[str, ...]:
    """The objects that can be built."""
    return tuple(_STYLES)


def build(name: str, instance: int = 1) -> Mesh:
    """The coloured mesh of an object; the same name and instance (1, 2, ...) always give the same one.

    Raises InvalidOption for an unknown name and an instance below 1.
    """
    if name not in _STYLES:
        raise InvalidOption(name, "not a known object", f"choose one of {', '.join(names())}")
    if instance < 1:
        raise InvalidOption(f"instance {instance}", "instances count from 1", "give 1 or more")
    styles = _STYLES[name]
    mesh = styles[(instance - 1) % len(styles)](np.random.default_rng([instance, *name.encode()]))
    low, high = mesh.bounds
    x, y, _ = -(low + high) / 2
    return mesh.moved(x, y, -low[2])
