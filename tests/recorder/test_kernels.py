"""Slices cover every point once, and the number of threads does not show."""

import numba
import numpy as np
import pytest

from orbitscan.processing.surface.normals import estimate_normals
from orbitscan.recorder.kernels import kernel, kernels_of, over_slices


@kernel
def _count(start: int, stop: int, visits: np.ndarray) -> None:
    for i in range(start, stop):
        visits[i] += 1


@pytest.fixture
def one_thread():
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    yield
    numba.set_num_threads(before)


@pytest.mark.parametrize("count", [0, 1, 2, 17, 1000, 1001])
def test_every_point_is_visited_once(count):
    visits = np.zeros(count, np.int64)
    over_slices(_count, count, visits)
    assert (visits == 1).all()


def test_an_error_in_a_slice_is_raised():
    def fail(start: int, stop: int) -> None:
        if stop == 100:
            raise ValueError("the last slice")

    with pytest.raises(ValueError, match="the last slice"):
        over_slices(fail, 100)


def test_one_thread_finds_the_same(request):
    points = np.random.default_rng(0).random((3000, 3))
    many = estimate_normals(points, 0.1, np.zeros(3))
    request.getfixturevalue("one_thread")
    assert estimate_normals(points, 0.1, np.zeros(3)).tobytes() == many.tobytes()


def test_kernels_are_known_by_the_module_or_package_they_stand_in():
    names = [found.__name__ for found in kernels_of("orbitscan.processing.surface.normals")]
    assert names == ["_fill_normals"]
    assert set(names) <= {found.__name__ for found in kernels_of("orbitscan.processing.surface")}
    assert kernels_of("orbitscan.processing.surf") == []
    assert _count in kernels_of(__name__)
