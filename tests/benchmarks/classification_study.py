"""The four initialisations side by side, on test instances never seen.

    orbitscan simulate corpus -o corpus --every 8 --workers 2
    python -m tests.benchmarks.classification_study corpus --seeds 3 --epochs 16

The last instance of each category is tested (thesis table 3.1), the one before it validates. `ours` is the default
training, the others the thesis's (counts, no augmentation) from each initialisation. A corpus thinned by N needs N
times the epochs for the thesis's number of steps.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import log_softmax

from orbitscan.processing.batch.inputs import find_recordings
from orbitscan.processing.classification.calibration import joint_logits
from orbitscan.processing.classification.checkpoint import Checkpoint
from orbitscan.processing.classification.evaluation import EpochRecord, Evaluator
from orbitscan.processing.classification.labelled_views import LabelledViews, gather, split_views
from orbitscan.processing.classification.training import THESIS, TrainingSettings, train
from orbitscan.recorder import mcap_file

INITS = ("glorot", "dcae", "kmeans-pca", "kmeans-zca")


def measure(model: Checkpoint, views: LabelledViews, rows: np.ndarray, settings: TrainingSettings) -> dict[str, float]:
    """Loss, and accuracy by views and fused over recordings."""
    evaluator = Evaluator(views, np.zeros((len(views), len(views.names))), settings.voxels, settings.precision)
    logits = evaluator.predict(model.network(), rows)
    truth, sessions = views.categories[rows], views.sessions[rows]
    logs = log_softmax(joint_logits(logits, views.radii[rows], model.calibration), axis=1)
    names = np.unique(sessions)
    fused = [logs[sessions == name].mean(axis=0).argmax() == truth[sessions == name][0] for name in names]
    return {
        "loss": -float(logs[np.arange(len(rows)), truth].mean()),
        "views %": 100 * float((logs.argmax(axis=1) == truth).mean()),
        "fused %": 100 * float(np.mean(fused)),
    }


def main() -> None:
    """Print a row for each training, and the means over the seeds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--epochs", type=int, default=16)
    parser.add_argument("--held", default="last", help="instances of each category to test, and as many to validate")
    parser.add_argument("--precision", choices=("float32", "bfloat16"), default="float32")
    parser.add_argument("--only", help="one of ours, glorot, dcae, kmeans-pca, kmeans-zca")
    options = parser.parse_args()
    ours = TrainingSettings(epochs=options.epochs, precision=options.precision)
    thesis = replace(THESIS, epochs=options.epochs, precision=options.precision)
    runs = {"ours": ours} | {init: replace(thesis, init=init) for init in INITS}
    read = [mcap_file.read(path) for path in find_recordings([options.corpus])]
    for name, settings in runs.items():
        if options.only not in (None, name):
            continue
        views = gather(read, trim_share=settings.voxels.trim)
        split = split_views(views, options.held, options.held)
        found = []
        for seed in range(options.seeds):
            started = time.perf_counter()
            *records, model = train(views, split, settings, seed=seed)
            assert isinstance(records[-1], EpochRecord)
            row = measure(model, views, split.test, settings)
            row |= {"overfitting": row["loss"] - records[-1].train_loss, "seconds": time.perf_counter() - started}
            found.append(row)
            print(
                f"{name:11} seed {seed}  " + "  ".join(f"{key} {value:.4g}" for key, value in row.items()), flush=True
            )
        means = {key: np.mean([row[key] for row in found]) for key in found[0]}
        print(f"{name:11} mean    " + "  ".join(f"{key} {value:.4g}" for key, value in means.items()), flush=True)


if __name__ == "__main__":
    main()
