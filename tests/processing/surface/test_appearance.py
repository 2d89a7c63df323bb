"""The colours of surfels: values, how they change along the surface, and what is told of them badly."""

import numpy as np
import pytest

from orbitscan.processing.surface.appearance import measure_appearance
from orbitscan.processing.surface.preparation import Scale, SurfaceSettings, prepare
from orbitscan.recorder.session import View
from orbitscan.recorder.simulation.camera import simulate

W = 0.002
SCALE = Scale(W, 0.004, 0.0001, 0.1)


def surface(colors_of, seed=0):
    """A square of 10 cm at one metre that faces the camera, with colours by x and y [m]."""
    xy = np.random.default_rng(seed).uniform(-0.05, 0.05, size=(20_000, 2))
    points = np.column_stack([xy, np.ones(len(xy))]).astype(np.float32)
    colors = None if colors_of is None else np.clip(np.rint(colors_of(*xy.T)), 0, 255).astype(np.uint8)
    return prepare(View(0, "0", 0, points, colors), SCALE, (0.0, 0.0, 0.0), SurfaceSettings())


def grey(brightness):
    return np.repeat(np.asarray(brightness)[:, None], 3, axis=1)


def test_a_view_without_colours_has_no_appearance():
    assert measure_appearance(surface(None), W) is None


def test_brightness_and_its_gradient_are_those_of_the_image():
    ramp = surface(lambda x, y: grey(120 * np.exp(4 * x)))
    looks = measure_appearance(ramp, W)
    x = ramp.surfels.points[:, 0]
    assert looks.values[:, 0] == pytest.approx(np.log(120 * np.exp(4 * x) + 10), abs=0.01)
    assert np.median(looks.gradients[:, 0], axis=0) == pytest.approx([4 * 120 / 130, 0, 0], abs=0.2)
    assert np.abs(looks.values[:, 1:]).max() < 1e-9  # grey has no chroma


def test_chroma_stays_where_the_light_changes():
    red = np.array([200.0, 60, 60])
    bright = measure_appearance(surface(lambda x, y: np.tile(red, (len(x), 1))), W)
    dim = measure_appearance(surface(lambda x, y: np.tile(0.7 * red, (len(x), 1))), W)
    assert bright.values[:, 0].mean() - dim.values[:, 0].mean() > 0.3
    assert bright.values[:, 1].mean() == pytest.approx(dim.values[:, 1].mean(), abs=0.05)


def test_an_edge_tells_less_than_what_lies_beside_it():
    halves = surface(lambda x, y: grey(np.where(x > 0, 200.0, 60.0)))
    looks = measure_appearance(halves, W)
    x = halves.surfels.points[:, 0]
    assert np.median(looks.variances[np.abs(x) < W / 2, 0]) > 10 * np.median(looks.variances[np.abs(x) > 5 * W, 0])


def test_noise_is_measured():
    rng = np.random.default_rng(3)
    quiet = surface(lambda x, y: grey(np.full(len(x), 128.0)))
    noisy = surface(lambda x, y: grey(128 + 25 * rng.normal(size=len(x))))
    variances = [np.median(measure_appearance(image, W).variances[:, 0]) for image in (noisy, quiet)]
    assert variances[0] > 2 * variances[1]


def test_paint_is_told_from_one_colour_in_any_light():
    """A small label is paint; light that falls off over a ball, noise and a highlight are not."""
    rng = np.random.default_rng(4)

    def small_label(x, y):
        return grey(np.where(np.hypot(x, y) < 0.008, 40.0, 160.0))

    assert measure_appearance(surface(small_label), W).is_patterned
    assert not measure_appearance(surface(lambda x, y: grey(128 + 25 * rng.normal(size=len(x)))), W).is_patterned
    assert not measure_appearance(surface(lambda x, y: grey(np.where(x > 0.04, 250.0, 120.0))), W).is_patterned
    apple = simulate("apple", views=6, paint="plain", lamp="camera", gloss=0.5, color_noise=4).views().load(0)
    assert not measure_appearance(prepare(apple, SCALE, (0.0, 0.0, 0.0), SurfaceSettings()), W).is_patterned
