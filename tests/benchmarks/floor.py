"""The floor of a registration: how well its pose can be known at best, given the surface and the noise of both views.

A small motion of a view is a turn omega [rad] about a centre c and a shift v [m], u = (omega, v). It moves a point p
with the normal n along that normal by J u, J = ((p - c) x n, n). A view that measures p with the variance s^2 along n
so has the information H = sum J^T J / s^2 about its own motion, and its pose the covariance H^-1, the Cramér-Rao
bound for Gaussian noise and point-to-plane residuals: nobody who knows only the points does better on average.

Some surfaces do not determine all six motions: a bowl turns about its axis unseen. Lengths are brought to one unit by
the lever L, the rms distance of the points from c: u' = (L omega, v). A unit u' moves the points by about 1, and along
their normals by sqrt(u'^T H' u' / sum 1/s^2). The eigenvectors of H' where that is below `UNDETERMINED` are free. They
are left out of the floor (the covariance is that of the other motions alone, B (B^T H' B)^-1 B^T with an orthonormal
basis B of them) and out of the error alike (`take_out`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.recorder import poses

UNDETERMINED = 0.01  # along the normals, of a motion of the points by 1


@dataclass(frozen=True, eq=False)
class Information:
    """What measured points say about small motions (L omega, v) about a centre."""

    matrix: np.ndarray  # (6, 6), of (L omega, v) [1/m^2]
    center: np.ndarray  # (3,) [m]
    lever: float  # L [m]
    weight: float  # sum of 1 / s^2

    def free(self) -> np.ndarray:
        """(6, k) orthonormal: the motions that hardly move the surface along its normals."""
        values, vectors = np.linalg.eigh(self.matrix)
        return vectors[:, values < UNDETERMINED**2 * self.weight]

    def covariance(self, free: np.ndarray) -> np.ndarray:
        """(6, 6) of (omega [rad], v [m]), the free motions (6, k) left out."""
        B = complement(free)
        scaled = B @ np.linalg.inv(B.T @ self.matrix @ B) @ B.T
        units = np.repeat([1 / self.lever, 1.0], 3)
        return scaled * units[:, None] * units

    def twist(self, axis: np.ndarray, point: np.ndarray, kind: str) -> np.ndarray:
        """(6,) the unit (L omega, v) of a turn about an axis through a point, or of a shift along it."""
        axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        if kind == "shift":
            return np.concatenate([np.zeros(3), axis])
        u = np.concatenate([self.lever * axis, np.cross(axis, self.center - point)])
        return u / np.linalg.norm(u)


def inform(
    points: np.ndarray,
    normals: np.ndarray,
    variance: np.ndarray,
    center: np.ndarray | None = None,
    lever: float | None = None,
) -> Information:
    """The information of points (N, 3) with unit normals (N, 3) and variances along them (N,) [m^2].

    The centre is their centroid and the lever their rms distance from it, unless given.
    """
    center = points.mean(axis=0) if center is None else center
    arms = points - center
    lever = float(np.sqrt((arms**2).sum(axis=1).mean())) if lever is None else lever
    J = np.hstack([np.cross(arms, normals) / lever, normals])  # (N, 6)
    return Information((J / variance[:, None]).T @ J, center, lever, float((1 / variance).sum()))


def pair_variance(source: np.ndarray, target: np.ndarray, source_density: np.ndarray, target_density: np.ndarray):
    """(N,) what a source point's distance to the target's surface varies by, from both views' noise and densities.

    A patch of area A holds rho_s A source and rho_t A target points; the distance of their means has the variance
    s_s^2 / (rho_s A) + s_t^2 / (rho_t A). Its inverse, shared by the rho_s A source points of the patch, is
    1 / (s_s^2 + s_t^2 rho_s / rho_t) for each.
    """
    return source + target * source_density / target_density


def rotation_floor_deg(covariance: np.ndarray) -> float:
    """The rms angle [degrees] of a pose's error: sqrt of the trace of the covariance of omega."""
    return float(np.degrees(np.sqrt(np.trace(covariance[:3, :3]))))


def center_floor(covariance: np.ndarray, center: np.ndarray, where: np.ndarray) -> float:
    """The rms motion [m] of the point `where` by a covariance about `center`: v + omega x (where - center)."""
    A = np.hstack([-_cross_matrix(where - center), np.eye(3)])
    return float(np.sqrt(np.trace(A @ covariance @ A.T)))


def chain_covariance(first: Information, other: Information, free: np.ndarray) -> np.ndarray:
    """Of the pose between two views that are each localised on the known surface: their covariances added.

    Both must be about the same centre with the same lever. It is the floor of a chain with known shape: what the joint
    refinement of many views tends to, since together they know the surface far better than each of them its pose.
    """
    return first.covariance(free) + other.covariance(free)


def joined(*bases: np.ndarray) -> np.ndarray:
    """(6, k) an orthonormal basis of all that bases (6, n) span."""
    stacked = np.hstack([basis.reshape(6, -1) for basis in bases])
    U, s, _ = np.linalg.svd(stacked, full_matrices=True)
    return U[:, : int((s > 1e-6).sum())]


def complement(basis: np.ndarray) -> np.ndarray:
    """(6, 6 - k) an orthonormal basis of what is orthogonal to an orthonormal basis (6, k)."""
    U, _, _ = np.linalg.svd(basis, full_matrices=True) if basis.shape[1] else (np.eye(6), None, None)
    return U[:, basis.shape[1] :]


def take_out(error: np.ndarray, free: np.ndarray, center: np.ndarray, lever: float) -> np.ndarray:
    """A motion (4, 4) without its part along the free motions (6, k) about a centre.

    The free part is undone until what is left has none, so that a turn by any angle about a free axis leaves nothing.
    """
    about = poses.make(np.eye(3), center)
    T = poses.invert(about) @ error @ about
    units = np.repeat([lever, 1.0], 3)
    for _ in range(20 if free.shape[1] else 0):
        part = free @ (free.T @ (_log(T) * units))
        T = T @ _exp(-part / units)
        if np.linalg.norm(part) < 1e-10 * lever:
            break
    return about @ T @ poses.invert(about)


def _cross_matrix(a: np.ndarray) -> np.ndarray:
    """[a]x with [a]x b = a x b."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def _shift_matrix(omega: np.ndarray) -> np.ndarray:
    """V of the exponential map: the translation of exp(omega, v) is V v."""
    angle = np.linalg.norm(omega)
    K = _cross_matrix(omega)
    if angle < 1e-6:
        return np.eye(3) + K / 2
    return np.eye(3) + (1 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K


def _exp(twist: np.ndarray) -> np.ndarray:
    """The motion of a twist (omega, v)."""
    return poses.make(Rotation.from_rotvec(twist[:3]).as_matrix(), _shift_matrix(twist[:3]) @ twist[3:])


def _log(T: np.ndarray) -> np.ndarray:
    """The twist (omega, v) of a motion."""
    omega = Rotation.from_matrix(T[:3, :3]).as_rotvec()
    return np.concatenate([omega, np.linalg.solve(_shift_matrix(omega), T[:3, 3])])
