"""What a network's weights are before it is trained (thesis 3.2.1 to 3.2.3)."""

from collections.abc import Iterator
from typing import Literal

import numpy as np
import torch

from orbitscan.processing.classification.initialization import autoencoder, kmeans
from orbitscan.processing.classification.labelled_views import LabelledViews
from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings, voxel_grids

Init = Literal["glorot", "dcae", "kmeans-pca", "kmeans-zca"]
_WHITENINGS: dict[Init, kmeans.Kind] = {"kmeans-pca": "pca", "kmeans-zca": "zca"}


def initialize(
    network: Network,
    init: Init,
    views: LabelledViews,
    rows: np.ndarray,
    voxels: VoxelSettings,
    *,
    structure: str,
    precision: Literal["float32", "bfloat16"] = "float32",
    seed: int = 0,
    device: str = "cpu",
) -> None:
    """Change a Glorot network, in place, to the first weights that `init` names.

    They are learnt from the shapes of the chosen views, without their labels. Raises InvalidOption where the
    structure has nothing to give them to.
    """
    if init == "dcae":
        rng = np.random.default_rng(seed)
        pretraining = autoencoder.AutoencoderSettings(bfloat16=precision == "bfloat16")

        def batches() -> Iterator[torch.Tensor]:
            cut = np.array_split(rng.permutation(rows), -(-len(rows) // pretraining.batch))
            return (voxel_grids(views.clouds(chosen, device), voxels) for chosen in cut)

        shorthand = autoencoder.mirror(structure)
        pretrained = autoencoder.pretrain(batches, pretraining, seed, device, shorthand, voxels.div)
        autoencoder.hand_over(pretrained, network)
    elif init != "glorot":
        clustering = kmeans.KMeansSettings(whitening=_WHITENINGS[init])
        some = np.random.default_rng(seed).permutation(rows)[: clustering.at_most]
        kmeans.set_first_filters(network, [views.cloud(row) for row in some], voxels, clustering, seed)
