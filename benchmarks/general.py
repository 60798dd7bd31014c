"""The general policy beside the planner that it corrects: the eight pieces, and exercises.

Usage: python benchmarks/general.py
Writes results/general.json, the same for the same versions, and prints a table of it. Neither the
pieces nor these exercises were practised.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context

import numpy as np
import record
from tqdm import tqdm

from roboguitarist import cli_report, exercises, formats, pieces
from roboguitarist.fingering import assign
from roboguitarist.metrics import evaluate
from roboguitarist.performance import PerformConfig, perform

PIECES = pieces.names()[:8]
SEEDS = range(1000, 1002)
SETTINGS = exercises.ExerciseConfig(duration_s=8.0)
CONTROLLERS = ("planner", "policy")
Job = tuple[str, int, str]


def played(job: Job) -> tuple[float, float]:
    """Note and frame F1 of a piece or an exercise; the seed of a piece is -1."""
    name, seed, controller = job
    tablature = (
        formats.load(pieces.path(name))
        if seed < 0
        else exercises.generate(exercises.Kind(name), seed, SETTINGS)
    )
    metrics = evaluate(perform(assign(tablature), PerformConfig(controller=controller)))
    assert metrics.note is not None
    assert metrics.frame is not None
    return metrics.note.f1, metrics.frame.f1


def main() -> None:
    """Play everything, print the table, write the file."""
    places = [(name, -1) for name in PIECES]
    places += [(kind, seed) for kind in exercises.KINDS for seed in SEEDS]
    jobs = [(*place, controller) for place, controller in product(places, CONTROLLERS)]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = dict(zip(jobs, tqdm(pool.map(played, jobs), total=len(jobs)), strict=True))
    results: dict[str, dict[str, float]] = {}
    for name in dict.fromkeys(name for name, _ in places):
        results[name] = {}
        for controller in CONTROLLERS:
            scores = [found[job] for job in jobs if job[0] == name and job[2] == controller]
            note, frame = np.mean(scores, axis=0)
            results[name] |= {
                f"{controller} note": round(float(note), 3),
                f"{controller} frame": round(float(frame), 3),
            }
    for title, names in (("mean of the pieces", PIECES), ("mean of the kinds", exercises.KINDS)):
        rows = [results[name] for name in names]
        results[title] = {
            column: round(float(np.mean([row[column] for row in rows])), 3) for column in rows[0]
        }
    columns = list(results[PIECES[0]])
    table = [(name, *(f"{row[column]:.3f}" for column in columns)) for name, row in results.items()]
    print(cli_report.table([("", *columns), *table]))
    print(record.write("general", results))


if __name__ == "__main__":
    main()
