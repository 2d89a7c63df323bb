"""What is where in a recording and in which colour: entity paths, quantities with their units, palettes.

Recordings of a session, a batch and a comparison share these, so that a colour means the same everywhere. Curves are
at `/<kind>/<quantity>/<method>`, in the units that the quantity's name ends with.
"""

import colorsys

import numpy as np
import rerun as rr

from orbitscan.processing.results.status import Color, Method, Status
from orbitscan.processing.timing import STAGES

APPLICATION_ID = "orbitscan"
VIEW_TIMELINE = "view"  # the recorded index
STAMP_TIMELINE = "stamp"  # when the sensor took the view


METHOD_COLORS: dict[str, Color] = {method: method.color for method in Method}
CURVE_WIDTHS = {"icp": 4.0, "ransac_icp": 2.0, "pairwise": 2.0, "refined": 2.0}  # an equal curve shows beneath another
GOOD_COLOR: Color = Status.OK.color
BAD_COLOR: Color = Status.DIVERGED.color  # failed views, wrong matches, contradicted edges, outliers
FREE_COLOR: Color = Status.AMBIGUOUS.color  # motions that nothing determines, and the views they leave ambiguous
TURNTABLE_COLOR: Color = (110, 205, 240)
GAP_COLOR: Color = (255, 170, 90)  # azimuths that no view covers
TRUTH_COLOR: Color = (185, 185, 185)
PLAIN_COLOR: Color = (205, 205, 210)
FOOT_COLOR: Color = (70, 95, 165)
TOP_COLOR: Color = (250, 240, 190)
LABEL_COLOR: Color = (255, 255, 255)  # of words in 3D views
BACKGROUND: Color = (60, 62, 68)  # of 3D views in either theme: black plastic and white porcelain stand out
ENTROPY_COLOR: Color = (140, 140, 140)
# Of a model's categories in their order, then round again. A contrast of 3:1 on white and on black.
_CATEGORY_COLORS: tuple[Color, ...] = (
    (228, 62, 62), (0, 158, 70), (60, 130, 240), (160, 90, 220), (222, 120, 0),
    (0, 156, 166), (140, 135, 0), (232, 80, 165), (130, 130, 140), (160, 105, 75),
)  # fmt: skip
_STAGE_COLORS: tuple[Color, ...] = (
    (208, 128, 0), (70, 140, 225), (0, 160, 112), (204, 121, 167), (140, 140, 140), (240, 90, 40), (150, 140, 30),
)  # fmt: skip

CLASSES = {
    "alone": "Probability, each view alone [0 to 1]; categories that reach 5%",
    "fused": "Probability, fused over the views so far [0 to 1]",
    "entropy": "Entropy of the fused probabilities [nats]: 0 is certain",
}
ERRORS_ROOT = "errors"
ERRORS_AGAIN = "errors_again"  # where frame {0} turned out to be that of another view than the first
ERRORS = {
    "translation_m": "Translation error [m]",
    "rotation_chordal": "Rotation error, chordal [0 to 2.83]",
    "rotation_deg": "Rotation error [deg]",
    "center_m": "Error of the object's centre [m]",
}
MM_ERRORS = {  # quantity -> (title, the error it is, in millimetres)
    "translation_mm": ("Translation error [mm]", "translation_m"),
    "center_mm": ("Error of the object's centre [mm]", "center_m"),
}
LOG_ERRORS = {  # quantity -> (title, the error it is the logarithm of, its factor)
    "translation_mm": ("log10 of it [mm]: 0 is 1 mm, 2 is 10 cm", "translation_m", 1e3),
    "rotation_chordal": ("log10 of it: -3 is 0.001", "rotation_chordal", 1.0),
    "center_mm": ("log10 of it [mm]: 0 is 1 mm, 2 is 10 cm", "center_m", 1e3),
}
BOUNDS = {  # quantity -> (title, title of its logarithm, the field of ViewEstimate, its factor)
    "rotation_deg": ("Turn: error and 95 % bound [deg]", "log10 of it [deg]: -1 is 0.1°", "rotation_bound_deg", 1.0),
    "center_mm": ("Centre: error and 95 % bound [mm]", "log10 of it [mm]: -1 is 0.1 mm", "center_bound_m", 1e3),
}
SHARES = {
    "overlap": "Overlap with the earlier view [share]",
    "confidence": "Confidence [0 to 1]",
    "inlier_ratio": "Inliers of the matches [share]",
}
EVIDENCE = SHARES | {
    "rmse_m": "Residual of the overlap, RMS [m]",
    "misfit": "Residual in standard deviations of its noise: 1 fits",
    "violations": "In front of what the other view saw [share]",
    "unseen": "The other sensor should see it, does not [share]",
    "observability": "How firmly the weakest motion is held: 0 slides",
    "edges": "Pairs that hold the view in the graph",
    "converged": "Came to rest within its iterations [0 or 1]",
    "inliers": "Inliers",
    "matches": "Matches",
    "valid_frames": "Keypoints with a reference frame",
    "keypoints": "Keypoints",
    "points": "Points of the working cloud",
}
TURNTABLE = {  # of a view's deviation from a perfect turn
    "slip_deg": "Slip: its turn off a multiple of the step [deg]",
    "wobble_deg": "Wobble: the axis leans [deg]",
    "shift_mm": "Shift of the axis [mm]",
}


def view_path(method: str, view: int) -> str:
    """The entity that carries a view's pose, by a method or in `truth`; its `points` and `camera` are below."""
    return f"/object/{method}/view_{view:03d}"


def cloud_path(method: str, view: int) -> str:
    """The entity of a view's points by a method."""
    return f"{view_path(method, view)}/points"


def status_color(status: Status) -> Color | None:
    """The colour of what is not ok: one for a motion left free, another for all that fails; None for ok."""
    return None if status == Status.OK else status.color


def error_field(quantity: str) -> str:
    """The name in ViewErrors of an error's quantity: translation_m -> translation_error_m."""
    name, _, unit = quantity.rpartition("_")
    return f"{name}_error_{unit}"


def category_color(number: int) -> Color:
    """The colour of a model's category, by its number in the model's order."""
    return _CATEGORY_COLORS[number % len(_CATEGORY_COLORS)]


def curve_style(path: str) -> tuple[Color, str, float]:
    """Colour, name and width of a curve: of the stage for a stage's timing, else of the method."""
    _, kind, quantity, method = path.split("/")
    if kind == "timing" and quantity in STAGES:
        return _STAGE_COLORS[STAGES.index(quantity)], quantity, 2.0
    if kind in ("bounds", "bounds_log10"):
        return lighten(METHOD_COLORS[method]), f"{method}, 95 % bound", CURVE_WIDTHS[method]
    return METHOD_COLORS[method], method, CURVE_WIDTHS[method]


def lighten(color: Color) -> Color:
    """A colour half way to white."""
    r, g, b = ((value + 255) // 2 for value in color)
    return r, g, b


def view_color(view: int, views: int) -> Color:
    """A hue for each of a session's views, from yellow over green and blue to violet: red is for what failed."""
    r, g, b = colorsys.hsv_to_rgb(0.13 + 0.7 * view / max(views, view + 1), 0.5, 0.95)
    return round(255 * r), round(255 * g), round(255 * b)


def height_colors(points: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(N, 3) uint8 that show the form of points (N, 3) without colours: from blue at the foot to yellow at the top."""
    height = points @ up
    low, high = np.percentile(height, [1, 99]) if len(points) else (0.0, 1.0)
    share = np.clip((height - low) / max(high - low, 1e-9), 0, 1)[:, None]
    return ((1 - share) * np.array(FOOT_COLOR) + share * np.array(TOP_COLOR)).astype(np.uint8)


def entity_path(*parts: str) -> str:
    """An entity by its parts, which may hold any sign."""
    return "/" + "/".join(map(rr.escape_entity_path_part, parts))
