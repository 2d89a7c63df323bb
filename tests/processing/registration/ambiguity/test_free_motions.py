"""Motions that views cannot determine: named with the right axis where there are any, and only there."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.ambiguity.free_motions import find_freedoms, turn_around
from orbitscan.processing.registration.unobservable import SymmetrySettings, find_motions
from orbitscan.processing.registration.verification import VerificationSettings
from orbitscan.recorder import poses
from tests.geometry import blob, bottle, cylinder, plane, scan, sphere
from tests.processing.scene import Scene, degrees

HOW = SymmetrySettings()
NOISES = (0.0, 0.0005, 0.001)
ONE_DEGREE = np.cos(np.radians(1))


class Object(Scene):
    """Two views of a scanned surface, and where its z axis and middle are in the first one."""

    def __init__(self, surface, noise, seed=0):
        super().__init__(scan(n_views=2, step_deg=20, noise=noise, surface=surface, seed=seed, points=12_000))
        self.source, self.target = self.views[1], self.views[0]
        T_camera_object = poses.invert(self.truth[0])
        self.z, self.middle = T_camera_object[:3, 2], T_camera_object[:3, 3]
        self.x = T_camera_object[:3, 0]

    def motions(self):
        gate = VerificationSettings().encounter.gate * self.scale.working
        return find_motions(self.T(0, 1), self.source.surface.surfels, self.target.fine_target, gate)

    def freedoms(self):
        return find_freedoms(self.pair(self.source, self.target), self.T(0, 1), self.motions())

    def off_the_line(self, freedom):
        """How far the object's middle is from a freedom's axis [m]."""
        return np.linalg.norm(np.cross(self.middle - freedom.point, freedom.axis))


@cache
def views_of(surface, noise=0.0005, seed=0):
    """The same object for all tests, which change nothing of it."""
    return Object(surface, noise, seed)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize(("surface", "free"), [(sphere, 3), (cylinder, 2), (plane, 3), (bottle, 1), (blob, 0)])
def test_information_tells_how_many_motions_are_free(surface, free, noise):
    information = [motion.information for motion in views_of(surface, noise).motions()]
    assert len(information) == 6
    assert (np.diff(information) >= 0).all()
    assert all(np.abs(value) < HOW.suspicious / 2 for value in information[:free])
    assert information[free] > 0.01
    assert information[-1] <= 1


@pytest.mark.parametrize("noise", NOISES)
def test_a_sphere_turns_about_its_middle_every_way(noise):
    found = views_of(sphere, noise)
    freedoms = found.freedoms()
    assert [f.kind for f in freedoms] == ["turn"] * 3
    assert max(found.off_the_line(f) for f in freedoms) < 0.001
    assert abs(np.linalg.det([f.axis for f in freedoms])) > 0.5


@pytest.mark.parametrize("noise", NOISES)
def test_a_bottle_turns_about_its_axis(noise):
    found = views_of(bottle, noise)
    (freedom,) = found.freedoms()
    assert freedom.kind == "turn"
    assert abs(freedom.axis @ found.z) > ONE_DEGREE
    assert found.off_the_line(freedom) < 0.001


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("seed", range(2))
def test_a_cylinder_turns_about_its_axis_and_shifts_only_along_it(noise, seed):
    found = views_of(cylinder, noise, seed)
    freedoms = found.freedoms()
    turns = [f for f in freedoms if f.kind == "turn"]
    assert len(turns) == 1
    assert abs(turns[0].axis @ found.z) > ONE_DEGREE
    assert found.off_the_line(turns[0]) < 0.001
    for shift in (f for f in freedoms if f.kind == "shift"):
        assert abs(shift.axis @ found.z) > np.cos(np.radians(5))


@pytest.mark.parametrize("noise", NOISES)
def test_a_plane_turns_about_its_normal_and_shifts_across(noise):
    found = views_of(plane, noise)
    freedoms = found.freedoms()
    assert len(freedoms) == 3
    for freedom in freedoms:
        across = abs(freedom.axis @ found.x)
        assert across > ONE_DEGREE if freedom.kind == "turn" else across < np.sin(np.radians(2))


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("seed", range(2))
def test_what_has_no_symmetry_has_no_freedom(noise, seed):
    assert views_of(blob, noise, seed).freedoms() == ()


def test_views_that_do_not_meet_have_no_motions():
    found = views_of(blob)
    far = poses.make(np.eye(3), [9.0, 0, 0])
    assert find_motions(far, found.source.surface.surfels, found.target.fine_target, 0.01) == []


def test_a_motion_is_rigid_and_as_large_as_it_says():
    for motion in views_of(blob).motions():
        size = motion.size(np.radians(5), 0.01)
        D = motion.pose(size)
        assert np.allclose(D[:3, :3] @ D[:3, :3].T, np.eye(3))
        turned, shifted = degrees(D, np.eye(4)), size * np.linalg.norm(motion.shift)
        assert turned <= 5 + 1e-6
        assert shifted <= 0.01 + 1e-9
        assert max(turned / 5, shifted / 0.01) == pytest.approx(1)
        assert np.allclose(motion.pose(-size), poses.invert(D), atol=1e-12)
        assert np.allclose(motion.pose(size / 2) @ motion.pose(size / 2), D, atol=1e-12)


def test_poses_about_a_bottle_are_turned_about_its_axis():
    found = views_of(bottle)
    T = found.T(0, 1)
    around = turn_around(found.pair(found.source, found.target), T, found.motions())
    assert 0 < len(around) <= HOW.around_most
    for pose in around.values():
        D = pose @ poses.invert(T)
        axis = Rotation.from_matrix(D[:3, :3]).as_rotvec()
        assert abs(axis @ found.z) / np.linalg.norm(axis) > np.cos(np.radians(3))
        assert degrees(D, np.eye(4)) > 10


def test_which_of_two_weak_motions_comes_first_does_not_show_in_the_poses_about_them():
    """A can turns about its axis and slides along it: whichever is the weaker, the turns are looked at."""
    found = views_of(cylinder)
    T, motions = found.T(0, 1), found.motions()
    for ordered in (motions, [motions[1], motions[0], *motions[2:]]):
        around = turn_around(found.pair(found.source, found.target), T, ordered)
        axes = [Rotation.from_matrix((pose @ poses.invert(T))[:3, :3]).as_rotvec() for pose in around.values()]
        along = np.array([abs(axis @ found.z) / np.linalg.norm(axis) for axis in axes])
        assert (along > np.cos(np.radians(3))).sum() >= HOW.around_most // 2


def test_nothing_is_turned_where_nothing_is_weak():
    found = views_of(blob)
    firm = [motion for motion in found.motions() if motion.information > HOW.suspicious]
    assert turn_around(found.pair(found.source, found.target), np.eye(4), firm) == {}
