"""Paper notebooks on a table, A6 to A4 (10 to 30 cm): the reader at +x, the top of a page towards -x, y to the right.

Shut hard and soft covers, coils along a side or the top, open ones with curved pages, covers ajar, pads.
"""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.notebook.opened import ajar, open_coiled, open_flat
from orbitscan.recorder.simulation.objects.notebook.shut import coiled, hard_cover, pad, soft_cover

STYLES = (hard_cover, coiled, open_flat, soft_cover, pad, open_coiled, ajar)


def build(rng: np.random.Generator) -> Mesh:
    """A notebook of a style drawn from the generator."""
    return STYLES[rng.integers(len(STYLES))](rng)
