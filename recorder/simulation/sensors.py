"""What a depth sensor makes of exact depths: noise, quantisation, holes, ragged edges, and the table's removal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

# Depth cameras lose a surface as it turns away from them; none is measured beyond about 80 degrees (Nguyen, Izadi,
# Lovell: Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking, 3DIMPVT 2012). Up to the first
# angle every point is kept, at the second none, linearly between.
KEPT_INCIDENCE_DEG, LOST_INCIDENCE_DEG = 65.0, 80.0


class DepthSensor(Protocol):
    """What a virtual camera asks of its sensor; images are (H, W), depths in metres, NaN or inf where nothing is."""

    @property
    def margin(self) -> int | None:
        """Pixels looked at around the object; None: the square of its bounding sphere."""

    def shift(self, shape: tuple[int, int], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray] | None:
        """How far [pixels] to the right and down of its own place each pixel looks; None: nowhere."""

    def measure(self, depth: np.ndarray, cosine: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """The measured depths, NaN where none is; `cosine` is of the angle of incidence."""

    def table_cut(self, rng: np.random.Generator) -> float:
        """The height above the table [m] up to which a view was taken for the table."""


@dataclass(frozen=True)
class GaussianSensor:
    """White Gaussian noise that grows with the square of depth; grazing points are lost one by one."""

    noise: float  # standard deviation of the depth at 1 m [m]
    margin: int | None = None

    def shift(self, shape: tuple[int, int], rng: np.random.Generator) -> None:
        """None: every pixel looks where it should."""

    def measure(self, depth: np.ndarray, cosine: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """The depths with noise; a draw for every pixel, hit or not: noise depends on nothing but the pixel."""
        luck, error = rng.random(depth.size).reshape(depth.shape), rng.standard_normal(depth.size).reshape(depth.shape)
        with np.errstate(invalid="ignore"):
            measured = depth + self.noise * depth**2 * error
        return np.where(np.isfinite(depth) & (luck < _chance(cosine)), measured, np.nan)

    def table_cut(self, rng: np.random.Generator) -> float:
        """Minus infinity: there is no table."""
        return -np.inf


@dataclass(frozen=True)
class Kinect:
    """The first Kinect before a turntable, as the Washington dataset's views show it.

    It matches windows of a dot pattern: errors are alike in neighbouring pixels, silhouettes ragged by a pixel or two,
    losses come in patches. Disparities are multiples of 1/8 pixel (Khoshelham, Elberink: Accuracy and Resolution of
    Kinect Depth Data, Sensors 2012), depths whole millimetres. Shifts, then noise in disparity, then quantisation, as
    Handa, Whelan, McDonald, Davison: A Benchmark for RGB-D Visual Odometry, ICRA 2014. There is no shadow of the
    projector: the dataset's views have none within an object.
    """

    noise: float = 0.001  # standard deviation of the depth at 1 m, before quantisation, which adds 0.84 mm [m]
    holes: float = 0.001  # share of the surface that is not measured though it faces the camera
    cut: float = 0.005  # of the session, above the table [m]
    cut_limit: float = np.inf  # [m]
    margin: int | None = 4

    BASELINE = 575.0 * 0.075  # focal length [pixels] times distance between projector and camera [m]
    STEP = 1 / 8  # of disparity [pixels]
    FAR = 8.0  # [m]; beyond it nothing is measured
    WINDOW = 1.8  # [pixels]; within it errors of depth are alike
    OUTLINE = 3.2  # [pixels]; within it losses and shifts are alike
    RAGGED = 1.0  # standard deviation of a pixel's shift [pixels]
    STRAY, STRAY_REACH = 0.01, 0.008  # share of edge pixels that fly behind the object, and how far on average [m]
    CUT_JITTER = 0.0015  # standard deviation from view to view [m]

    @classmethod
    def draw(cls, rng: np.random.Generator, height: float, noise: float) -> Kinect:
        """A session's sensor before an object of the height [m].

        The removal of the table took up to 15 mm of it, of one in eight sessions up to 20 % of the height, and never
        more than 40 %.
        """
        deep = rng.random() < 1 / 8
        cut = rng.uniform(0, max(0.015, 0.2 * height) if deep else 0.015)
        limit = 0.4 * height
        holes = 10 ** rng.uniform(-4, -2)
        return cls(noise, holes, min(cut, limit), limit)

    def shift(self, shape: tuple[int, int], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Smooth random shifts (H, W) [pixels] to the right and down."""
        return self.RAGGED * _smooth(shape, self.OUTLINE, rng), self.RAGGED * _smooth(shape, self.OUTLINE, rng)

    def measure(self, depth: np.ndarray, cosine: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """The measured depths (H, W) [m]: noisy, quantised, NaN where there is none."""
        from scipy.special import ndtr

        hit = np.isfinite(depth)
        luck = ndtr(_smooth(depth.shape, self.OUTLINE, rng))
        chance = np.where(hit, np.clip(_chance(cosine), 0, 1), 0)
        seen = (depth < self.FAR) & (luck < (1 - self.holes) * _highest(chance))
        stray = _edges(hit, depth) & (rng.random(depth.shape) < self.STRAY)
        far = np.where(stray, depth + rng.exponential(self.STRAY_REACH, depth.shape), depth)
        disparity = self.BASELINE / np.where(hit, far, 1)
        disparity += self.noise * self.BASELINE * _smooth(depth.shape, self.WINDOW, rng)
        quantised = self.BASELINE / (np.maximum(np.rint(disparity / self.STEP), 1) * self.STEP)
        return np.where(seen, np.round(quantised, 3), np.nan)

    def table_cut(self, rng: np.random.Generator) -> float:
        """The height [m] at which the session's views are cut, a little different in every view."""
        return float(np.clip(self.cut + self.CUT_JITTER * rng.standard_normal(), 0, self.cut_limit))


def _chance(cosine: np.ndarray) -> np.ndarray:
    """The probability that a point is measured, by the cosine between its normal and the direction to the camera."""
    incidence_deg = np.degrees(np.arccos(np.clip(cosine, 0, 1)))
    return (LOST_INCIDENCE_DEG - incidence_deg) / (LOST_INCIDENCE_DEG - KEPT_INCIDENCE_DEG)


def _smooth(shape: tuple[int, int], reach: float, rng: np.random.Generator) -> np.ndarray:
    """Random normal deviates (H, W), float32, whose correlation falls with distance as exp(-d^2 / (2 reach^2))."""
    sigma = reach / np.sqrt(2)
    rows, columns = (_kernel(length, sigma) for length in shape)
    white = rng.standard_normal((rows.shape[1], columns.shape[1]), dtype=np.float32)
    return rows @ white @ columns.T


def _kernel(length: int, sigma: float) -> np.ndarray:
    """(length, K) Gaussians about a coarse grid that reaches beyond the image; rows of unit norm keep the variance."""
    step = 1.25 * sigma  # coarse enough to be quick, fine enough that the grid is not seen
    centers = np.arange(-3 * sigma, length + 3 * sigma, step)
    kernel = np.exp(-((np.arange(length)[:, None] - centers) ** 2) / (2 * sigma**2))
    return (kernel / np.linalg.norm(kernel, axis=1, keepdims=True)).astype(np.float32)


def _highest(values: np.ndarray) -> np.ndarray:
    """Values (H, W), each the highest of each pixel's and its four neighbours'; outside the image is 0."""
    padded = np.pad(values, 1)
    neighbours = padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]
    return np.maximum.reduce([values, *neighbours])


def _edges(hit: np.ndarray, depth: np.ndarray, jump: float = 0.01) -> np.ndarray:
    """Which pixels (H, W) are hits beside which nothing is, or something deeper by more than `jump` [m]."""
    return hit & (_highest(np.where(hit, depth, np.inf)) > depth + jump)
