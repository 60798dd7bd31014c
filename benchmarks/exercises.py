"""How the planner meets music that it was not tuned on: generated exercises of every kind.

Usage: python benchmarks/exercises.py
Writes results/exercises.json, the same for the same versions, and prints a table of it.
"""

from __future__ import annotations

import numpy as np
import record

from roboguitarist import cli_report, exercises
from roboguitarist.fingering import assign
from roboguitarist.metrics import evaluate
from roboguitarist.performance import perform

SEEDS = range(1000, 1004)
SETTINGS = exercises.ExerciseConfig(duration_s=8.0)


def played(kind: str) -> dict[str, float]:
    """Mean note and frame F1 of the exercises of a kind, and their notes per second."""
    notes, frames, density = [], [], []
    for seed in SEEDS:
        tablature = exercises.generate(kind, seed, SETTINGS)
        metrics = evaluate(perform(assign(tablature)))
        notes += [metrics.note.f1] if metrics.note else []
        frames += [metrics.frame.f1] if metrics.frame else []
        density.append(len(tablature.notes) / tablature.duration_s)
    names = ("note", "frame", "notes per second")
    means = (float(np.mean(values)) for values in (notes, frames, density))
    return {name: round(mean, 3) for name, mean in zip(names, means, strict=True)}


def main() -> None:
    """Play four exercises of each kind with the `linkage` hand."""
    results = {str(kind): played(kind) for kind in exercises.KINDS}
    rows = [(kind, *(f"{value:.2f}" for value in row.values())) for kind, row in results.items()]
    print(cli_report.table([("kind", *results["scales"]), *rows]))
    print(record.write("exercises", results, seeds=list(SEEDS), hand="linkage"))


if __name__ == "__main__":
    main()
