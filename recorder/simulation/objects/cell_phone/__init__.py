"""Mobile phones as they are put down on a table, 9 to 16 cm long: the reader at +x, the top of the screen towards -x.

Bars with keys, smartphones bare and in cases, messengers with a small keyboard, flip phones shut and open, sliders.
"""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.cell_phone.bars import candy_bar, cased_smartphone, messenger, smartphone
from orbitscan.recorder.simulation.objects.cell_phone.folding import flip_open, flip_shut, slider

STYLES = (candy_bar, smartphone, flip_shut, flip_open, slider, messenger, cased_smartphone)


def build(rng: np.random.Generator) -> Mesh:
    """A phone of a style drawn from the generator."""
    return STYLES[rng.integers(len(STYLES))](rng)
