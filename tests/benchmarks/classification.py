"""How a model classifies shapes it never saw: `python -m tests.benchmarks.classification [MODEL.pt]`.

Real Kinect views (Washington), meshes of other people before the virtual Kinect, simulated views of others (RUG), where
$ORBITSCAN_DATA has them. Per object: the share of right views, the share called known, and what its views say together.
"""

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sklearn.metrics import roc_auc_score

from orbitscan.processing.classification import PACKAGED
from orbitscan.processing.classification.classifier import Classifier
from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.sources import open_capture

DATA = Path(os.environ.get("ORBITSCAN_DATA", "../shared/data"))
MESHES = {  # what each shape is: a category, another thing, or near: a bottle of something else, a cup without handle
    "meshes_contactdb/apple.stl": "apple",
    "meshes_contactdb/bowl.stl": "bowl",
    "meshes_contactdb/mug.stl": "coffee_mug",
    "meshes_contactdb/phone.stl": "cell_phone",
    "meshes_contactdb/waterbottle.stl": "water_bottle",
    "meshes_ycb_hoi4d/hoi4d_0001_Mug.obj": "coffee_mug",
    "meshes_ycb_hoi4d/hoi4d_0005_Mug.obj": "coffee_mug",
    "meshes_ycb_hoi4d/hoi4d_0017_Mug.obj": "coffee_mug",
    "meshes_ycb_hoi4d/hoi4d_0033_Mug.obj": "coffee_mug",
    "meshes_ycb_hoi4d/ycb_024_bowl.obj": "bowl",
    "meshes_ycb_hoi4d/ycb_025_mug.obj": "coffee_mug",
    "meshes_ycb_hoi4d/ycb_006_mustard_bottle.obj": "near",
    "meshes_ycb_hoi4d/ycb_021_bleach_cleanser.obj": "near",
    "meshes_contactdb/cup.stl": "near",
    "meshes_contactdb/flashlight.stl": "other",
    "meshes_contactdb/teapot.stl": "other",
    "meshes_ycb_hoi4d/ycb_051_large_clamp.obj": "other",
}
RUG = {
    "mug": "coffee_mug", "fatmug": "coffee_mug", "flowermug": "coffee_mug", "mixmug": "coffee_mug",
    "bowl": "bowl", "classicBowl": "bowl",
    "cocacola": "other", "fanta": "other", "pepsi": "other", "fork": "other", "spoon": "other",
}  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One object."""

    group: str
    name: str
    truth: str
    right: float  # share of views whose likeliest category is right
    known: float  # share of views called known
    fused: str
    scores: tuple[float, ...]


def collect(rug_axes: str, views: int) -> list[tuple[str, str, str, list[Session]]]:
    """Group, name, truth and sessions of every object."""
    found: list[tuple[str, str, str, list[Session]]] = []
    if (DATA / "washington").is_dir():
        for session in open_capture(DATA / "washington" / "rgbd-dataset"):
            found.append(("real", session.info.name, session.info.category, [session]))
    for name, truth in MESHES.items():
        if (DATA / name).is_file():
            circles = [
                simulate(str(DATA / name), views=views, elevation_deg=elevation, sensor="kinect")
                for elevation in (30, 45, 60)
            ]
            found.append(("mesh", Path(name).stem, truth, circles))
    for name, truth in RUG.items():
        folder = DATA / "rug_restaurant20_gazebo" / name
        if folder.is_dir():
            options = CaptureOptions(format="clouds", axes=rug_axes, sensor_origin="unknown")
            found.append(("rug", name, truth, open_capture(folder, options)))
    return found


def judge(classifier: Classifier, group: str, name: str, truth: str, sessions: list[Session]) -> Row:
    """How the model does on one object."""
    views = [view for session in sessions for view in session.views()]
    answers = [a for a in classifier.classify_views([v.index for v in views], [v.points for v in views]) if a]
    fused = classifier.fuse(answers)
    known = truth in classifier.categories
    return Row(
        group,
        name,
        truth if known else truth if truth == "near" else "other",
        float(np.mean([a.likeliest == truth for a in answers])),
        float(np.mean([a.known for a in answers])),
        f"{fused.category or 'unknown'} ({fused.likeliest} {fused.probability:.2f})",
        tuple(a.score for a in answers),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", nargs="?", type=Path, default=PACKAGED)
    parser.add_argument("--views", type=int, default=12, help="of each mesh and height")
    parser.add_argument("--rug-axes", default="FLU")
    options = parser.parse_args()
    classifier = Classifier(options.model)
    rows = [judge(classifier, *item) for item in collect(options.rug_axes, options.views)]
    print(f"{'group':6}{'object':24}{'truth':14}{'views':>6}{'right':>7}{'known':>7}  fused")
    for row in rows:
        print(
            f"{row.group:6}{row.name:24}{row.truth:14}{len(row.scores):6}{row.right:7.2f}{row.known:7.2f}  {row.fused}"
        )
    for group in ("real", "mesh", "rug"):
        inside = [row for row in rows if row.group == group and row.truth in classifier.categories]
        if inside:
            weights = [len(row.scores) for row in inside]
            right = np.average([row.right for row in inside], weights=weights)
            fused = np.mean([row.truth in row.fused.split(" ")[1] for row in inside])
            outside = [s for row in rows if row.group == group and row.truth == "other" for s in row.scores]
            scores = [s for row in inside for s in row.scores]
            auroc = roc_auc_score([1] * len(scores) + [0] * len(outside), scores + outside) if outside else np.nan
            print(
                f"{group}: right views {right:.3f} (mean of objects {np.mean([r.right for r in inside]):.3f}), "
                f"fused {fused:.3f}, AUROC known against other {auroc:.3f}"
            )


if __name__ == "__main__":
    main()
