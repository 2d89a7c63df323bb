"""Results of trainings that nobody ran."""

import numpy as np


def run(accuracy, loss=0.5, train_loss=0.2, steps=4):
    """One run's result, as `training_run.train_once` returns it."""
    ramp = np.linspace(0.1, accuracy, steps).tolist()
    return {
        "accuracy": accuracy,
        "loss": loss,
        "train_accuracy": 1.0,
        "train_loss": train_loss,
        "overfitting": loss - train_loss,
        "confusion": (100 * np.eye(10, dtype=int) + 3 * np.eye(10, k=1, dtype=int)).tolist(),
        "views_per_second": 400.0,
        "seconds": 12.0,
        "curve": {
            "step": list(range(1, steps + 1)),
            "train_loss": [train_loss] * steps,
            "train_accuracy": ramp,
            "validation_loss": [loss] * steps,
            "validation_accuracy": ramp,
        },
    }


def runs(level, count=4, **numbers):
    """Several runs about a level of accuracy."""
    return [run(level + 0.01 * (i % 2), **numbers) for i in range(count)]


def stub(monkeypatch, module, levels):
    """Let a study's trainings reach these accuracies, in the order of their changes; the changes it asked for."""
    asked = []

    def run_trainings(plan, changes, what):
        asked.extend(changes.values())
        assert len(changes) == len(levels)
        return {name: runs(level, plan.runs) for name, level in zip(changes, levels, strict=True)}

    monkeypatch.setattr(module, "run_trainings", run_trainings)
    return asked
