"""Numbers drawn at random, as tasks: what other processes import to draw them, and little else."""

import time
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Draw:
    seed: int
    scale: float = 1.0

    @property
    def name(self):
        return f"draw-{self.seed}"

    @property
    def key(self):
        return {"seed": self.seed, "scale": self.scale}


def draw_slowly(task):
    time.sleep(0.3)
    return {"number": np.random.default_rng(task.seed).normal()}
