"""What a network's weights are before it is trained (thesis 3.2.1 to 3.2.3)."""

import numpy as np

from processing.classification.labelled_views import LabelledViews
from processing.classification.network import Network
from processing.classification.voxels import VoxelSettings


def initialise(
    network: Network, init: str, views: LabelledViews, rows: np.ndarray, voxels: VoxelSettings, seed: int, device: str
) -> None:
    """Give a Glorot network, in place, the first weights that `init` names, learnt from the chosen views unlabelled."""
