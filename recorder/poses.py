"""Rigid motions SE(3) as 4x4 float64 matrices: the one place that knows a convention.

`T_a_b` maps coordinates in frame b to coordinates in frame a. A camera frame is x right, y down, z forward (RDF;
ROS REP 103). Quaternions are Hamilton's, written x y z w.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.recorder.exceptions import InvalidOption, InvalidPose

ROTATION_TOLERANCE = 1e-3  # pose files carry as few as four digits
_DIRECTIONS = {  # a letter of a frame's name -> the direction its axis points to, in RDF
    "R": (1, 0, 0), "L": (-1, 0, 0),
    "D": (0, 1, 0), "U": (0, -1, 0),
    "F": (0, 0, 1), "B": (0, 0, -1),
}  # fmt: skip


def make(rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
    """The 4x4 motion of a 3x3 rotation and a translation [m]."""
    T = np.eye(4)
    T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def turn_about(axis: np.ndarray, point: np.ndarray, angle: float) -> np.ndarray:
    """The 4x4 motion that turns by an angle [rad] about the line along a unit axis (3,) through a point (3,)."""
    R = Rotation.from_rotvec(angle * axis).as_matrix()
    return make(R, point - R @ point)


def invert(T: np.ndarray) -> np.ndarray:
    """The inverse T_b_a of a motion T_a_b."""
    R = T[:3, :3]
    return make(R.T, -R.T @ T[:3, 3])


def transform(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (N, 3) given in frame b, mapped by T_a_b to frame a; float64."""
    points = np.asarray(points, dtype=np.float64)
    # Written out, not a matrix product: a BLAS may sum in another order with another number of threads.
    x, y, z = points[:, 0, None], points[:, 1, None], points[:, 2, None]
    return x * T[:3, 0] + y * T[:3, 1] + z * T[:3, 2] + T[:3, 3]


def rotate(T: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Directions (N, 3) given in frame b, mapped by T_a_b to frame a; float64."""
    return transform(make(T[:3, :3], np.zeros(3)), directions)


def project_rotation(M: np.ndarray) -> np.ndarray:
    """The rotation nearest to a 3x3 matrix in the Frobenius norm."""
    U, _, Vt = np.linalg.svd(M)
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return U @ Vt


def chordal_distance(R_a: np.ndarray, R_b: np.ndarray) -> float:
    """|| I - R_a R_b^T ||_F = 2 sqrt(2) |sin(angle / 2)| (thesis (5.2)); 0 to 2 sqrt(2)."""
    return float(np.linalg.norm(np.eye(3) - R_a @ R_b.T))


def rotation_angle(R: np.ndarray) -> float:
    """The angle [rad] of a rotation, from its chordal distance to the identity: exact also for tiny angles."""
    chordal = chordal_distance(project_rotation(R), np.eye(3))
    return float(2 * np.arcsin(min(1.0, chordal / (2 * np.sqrt(2)))))


def angle_between(R_a: np.ndarray, R_b: np.ndarray) -> float:
    """The angle [rad] between two rotations, which are taken to be exact."""
    return float(2 * np.arcsin(min(1.0, float(np.linalg.norm(R_a - R_b)) / (2 * np.sqrt(2)))))


def twist(R: np.ndarray, axis: np.ndarray) -> float:
    """The angle [rad], -pi to pi, by which a rotation turns about a unit axis (3,): R is that turn and then a swing."""
    x, y, z, w = Rotation.from_matrix(R).as_quat()
    return float((2 * np.arctan2(x * axis[0] + y * axis[1] + z * axis[2], w) + np.pi) % (2 * np.pi) - np.pi)


def check(T: np.ndarray, subject: str) -> np.ndarray:
    """The motion T (4, 4), its rotation projected onto SO(3).

    Raises InvalidPose where T is not finite, not 4x4 homogeneous, scaled, sheared or mirrored by more than the digits
    of a pose file explain.
    """
    T = np.asarray(T, dtype=np.float64)
    remedy = "give a rotation (orthonormal, determinant +1) and a translation"
    if T.shape != (4, 4):
        raise InvalidPose(subject, f"a pose has the shape {T.shape}, not 4x4", remedy)
    if not np.isfinite(T).all():
        raise InvalidPose(subject, "a pose holds a number that is not finite", remedy)
    if np.abs(T[3] - (0, 0, 0, 1)).max() > 1e-9:
        raise InvalidPose(subject, f"the last row of a pose is {T[3].tolist()}, not 0 0 0 1", remedy)
    R = T[:3, :3]
    off = float(np.abs(R.T @ R - np.eye(3)).max())
    if off > ROTATION_TOLERANCE:
        raise InvalidPose(subject, f"a pose is not a rotation (R^T R is {off:.2g} off the identity)", remedy)
    if np.linalg.det(R) < 0:
        raise InvalidPose(subject, "a pose mirrors (determinant -1)", remedy)
    return make(project_rotation(R), T[:3, 3])


def from_quaternion(translation: np.ndarray, quaternion: np.ndarray, subject: str) -> np.ndarray:
    """The motion of a translation [m] and a Hamilton quaternion (x, y, z, w), normalised; raises InvalidPose."""
    quaternion = np.asarray(quaternion, dtype=np.float64)
    norm = float(np.linalg.norm(quaternion))
    if not np.isfinite(norm) or abs(norm - 1) > 1e-2:
        problem = f"a quaternion has the length {norm:.3g}, not 1"
        raise InvalidPose(subject, problem, "give x y z w of a unit quaternion")
    return check(make(Rotation.from_quat(quaternion / norm).as_matrix(), translation), subject)


def to_quaternion(T: np.ndarray) -> np.ndarray:
    """The unit quaternion (x, y, z, w) of a motion's rotation, w >= 0."""
    return Rotation.from_matrix(T[:3, :3]).as_quat(canonical=True)


def to_tum_line(stamp_ns: int, T: np.ndarray) -> str:
    """`stamp x y z qx qy qz qw`, the stamp in seconds with nine decimals (evo reads it)."""
    seconds, nanoseconds = divmod(stamp_ns, 10**9)
    numbers = [*T[:3, 3], *to_quaternion(T)]
    return f"{seconds}.{nanoseconds:09d} " + " ".join(f"{n:.12g}" for n in numbers)


def from_tum_line(line: str, subject: str) -> tuple[int, np.ndarray]:
    """(stamp_ns, T) of a TUM line; raises InvalidPose."""
    words, remedy = line.split(), "write stamp x y z qx qy qz qw"
    if len(words) != 8:
        raise InvalidPose(subject, f"a TUM line has {len(words)} numbers, not 8", remedy)
    try:
        whole, _, fraction = words[0].partition(".")
        exact = whole.isdigit() and (fraction.isdigit() or not fraction)
        stamp_ns = int(whole) * 10**9 + int(fraction[:9].ljust(9, "0")) if exact else round(float(words[0]) * 1e9)
        numbers = [float(word) for word in words[1:]]
    except (ValueError, OverflowError):
        raise InvalidPose(subject, f"a TUM line holds no numbers ('{line[:40]}')", remedy) from None
    return stamp_ns, from_quaternion(np.array(numbers[:3]), np.array(numbers[3:]), subject)


def axes_to_rdf(axes: str) -> np.ndarray:
    """The 3x3 rotation from a frame named by where its x, y, z axes point (e.g. `RUB`, `RFU`, `FLU`) to RDF.

    Names are those of Rerun's ViewCoordinates. Raises InvalidOption for a name that is none or is left-handed.
    """
    remedy = "name where x, y and z point, right-handed, such as RDF (cameras), RUB (OpenGL), RFU, FLU (ROS bodies)"
    letters = axes.upper()
    if len(letters) != 3 or any(letter not in _DIRECTIONS for letter in letters):
        raise InvalidOption(f"axes '{axes}'", "not three of R L U D F B", remedy)
    A = np.array([_DIRECTIONS[letter] for letter in letters], dtype=np.float64).T
    determinant = round(float(np.linalg.det(A)))
    if determinant == 0:
        raise InvalidOption(f"axes '{axes}'", "two axes point along one line", remedy)
    if determinant < 0:
        raise InvalidOption(f"axes '{axes}'", "a left-handed frame", remedy)
    return A
