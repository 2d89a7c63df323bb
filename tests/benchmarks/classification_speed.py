"""Views a second of the network and of the descriptor classifiers: `python -m tests.benchmarks.classification_speed`.

Virtual Kinect views of the ten categories, medians over runs, on all cores; the descriptor classifiers on a subset of
training views, their search scaling with its size (thesis table 5.3 gives seconds for 475 views, its subset unknown).
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbitscan.processing.classification.classifier import Classifier
from orbitscan.processing.classification.descriptor_matching import KINDS, build_database, classify_views
from orbitscan.processing.classification.evaluation import EpochRecord
from orbitscan.processing.classification.labelled_views import LabelledViews, gather, split_views
from orbitscan.processing.classification.training import THESIS, TrainingSettings, train
from orbitscan.recorder.formats import ply
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.simulation.objects import CATEGORIES

TESTED = 475  # views, as in the thesis
THESIS_SECONDS = {"network": "< 0.1 (GPU)", "shot": 175, "fpfh": 240, "pfh": 6049, "esf": 15}


def seconds(run: Callable[[], object], times: int = 5) -> float:
    """The median of several runs, after one that is not counted."""
    run()
    taken = []
    for _ in range(times):
        started = time.perf_counter()
        run()
        taken.append(time.perf_counter() - started)
    return statistics.median(taken)


def training_speed(views: LabelledViews, settings: TrainingSettings) -> float:
    """Views a second of training, augmentation included, evaluation left out; the best of the epochs."""
    split = split_views(views, "last")
    return max(r.views_per_second for r in train(views, split, settings) if isinstance(r, EpochRecord))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--known", type=int, default=8, help="views of each training instance for the descriptors")
    parser.add_argument("--kinds", default=",".join(KINDS))
    options = parser.parse_args()

    def sessions(instances: range, views: int) -> list[Session]:
        return [
            simulate(name, instance=i, views=views, elevation_deg=30, sensor="kinect")
            for name in CATEGORIES
            for i in instances
        ]

    tested = [(s.info.category, v.points) for s in sessions(range(4, 5), 48) for v in s.views()][:TESTED]
    known = [(s.info.category, v.points) for s in sessions(range(1, 4), options.known) for v in s.views()]
    clouds = [points for _, points in tested]
    classifier = Classifier()
    network = seconds(lambda: classifier.classify_views(range(TESTED), clouds))
    print(f"{np.median([len(c) for c in clouds]):.0f} points a view; packaged model {classifier.checkpoint.structure}")
    print(f"network, points to probabilities: {network:.2f} s for {TESTED} views, {TESTED / network:.0f} views/s")
    with tempfile.TemporaryDirectory() as folder:
        cloud = Path(folder) / "view.ply"
        ply.write(cloud, clouds[0])
        command = [sys.executable, "-c", "from orbitscan.processing.cli import main; main()", "classify", str(cloud)]
        one = seconds(lambda: subprocess.run(command, check=True, capture_output=True), 3)
    print(f"one view from the shell: {one:.2f} s")
    views = gather(sessions(range(1, 4), 48))
    for name, settings in (("thesis", replace(THESIS, epochs=2)), ("ours", TrainingSettings(epochs=2))):
        for precision in ("float32", "bfloat16"):
            speed = training_speed(views, replace(settings, precision=precision))
            print(f"training, {name} settings, {precision}: {speed:.0f} views/s")
    for kind in options.kinds.split(","):
        database = build_database([points for _, points in known], [name for name, _ in known], kind)
        answers = classify_views(database, clouds)
        right = np.mean([a == name for a, (name, _) in zip(answers.categories, tested, strict=True)])
        print(
            f"{kind}: {100 * right:.1f} % right, {answers.description_s + answers.search_s:.1f} s for {TESTED} views "
            f"({answers.description_s:.1f} description, {answers.search_s:.1f} search in {len(known)} views); "
            f"the thesis {THESIS_SECONDS[kind]} s"
        )


if __name__ == "__main__":
    main()
