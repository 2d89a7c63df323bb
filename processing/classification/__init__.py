"""Chapter 3 of the thesis: what a view shows, by a voxel network."""

from pathlib import Path

PACKAGED = Path(__file__).parent / "household.pt"  # the model that comes with the package: the thesis's ten categories
