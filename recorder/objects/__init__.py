"""Parametric meshes of known objects in real sizes: every instance of an object is another one, drawn from a seed.

The object's frame: z up, standing on z = 0, its bounding box centred on the z axis, its front towards +x. A module
per object builds it from a random generator; `build` places it in that frame.
"""

import numpy as np

from recorder.exceptions import InvalidOption
from recorder.objects import (
    bin,
    bowl,
    cap,
    coffee_mug,
    helicopter,
    pliers,
    robot,
    statue,
    vacuum_cleaner,
    water_bottle,
)
from recorder.objects.mesh import Mesh

_BUILDERS = {
    module.__name__.rpartition(".")[2]: module.build
    for module in (bin, coffee_mug, robot, bowl, cap, helicopter, pliers, statue, vacuum_cleaner, water_bottle)
}


def names() -> tuple[str, ...]:
    """The objects that can be built."""
    return tuple(_BUILDERS)


def build(name: str, instance: int = 1) -> Mesh:
    """The coloured mesh of an object; the same name and instance (1, 2, ...) always give the same one.

    Raises InvalidOption for an unknown name and an instance below 1.
    """
    if name not in _BUILDERS:
        raise InvalidOption(name, "no known object", f"choose one of {', '.join(names())}")
    if instance < 1:
        raise InvalidOption(f"instance {instance}", "instances count from 1", "give 1 or more")
    mesh = _BUILDERS[name](np.random.default_rng([instance, *name.encode()]))
    low, high = mesh.bounds
    x, y, _ = -(low + high) / 2
    return mesh.moved(x, y, -low[2])
