"""How much faster than real time each stage runs on one core.

Usage: python benchmarks/speed.py
Writes results/speed.json and prints a table of it. Run it on a machine that does nothing else.
"""

from __future__ import annotations

import os

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # before numpy is loaded

import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import record

from roboguitarist import cli_report, formats, pieces, plucking, sound
from roboguitarist.fingering import assign
from roboguitarist.fretting import planner
from roboguitarist.performance import PerformConfig, perform, scene_config, simulate
from roboguitarist.scene import build

PIECES = pieces.names()[:8]
REPEATS = 3
STAGES = ("fingering", "right plan", "left plan", "physics", "performance", "sound")
"""`performance` is all that `perform` does: both plans, the physics and reading its sensors."""

T = TypeVar("T")


def best_of(work: Callable[[], T]) -> tuple[T, float]:
    """What `work` returns, and the least wall time in seconds that it took."""
    result, seconds = work(), []
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = work()
        seconds.append(time.perf_counter() - start)
    return result, min(seconds)


def factors(name: str) -> dict[str, float]:
    """Seconds of the piece per second of work, for each of `STAGES`."""
    tablature = formats.load(pieces.path(name))
    scene = scene_config(PerformConfig())
    fingering, fingering_s = best_of(lambda: assign(tablature))
    right, right_s = best_of(lambda: plucking.plan(fingering, scene))
    left, left_s = best_of(lambda: planner.plan(fingering, scene))
    _, physics_s = best_of(lambda: simulate(build(scene), left, right))
    performance, performance_s = best_of(lambda: perform(fingering))
    _, sound_s = best_of(lambda: sound.synthesize(performance))
    seconds = (fingering_s, right_s, left_s, physics_s, performance_s, sound_s)
    return {
        stage: round(tablature.duration_s / elapsed, 1)
        for stage, elapsed in zip(STAGES, seconds, strict=True)
    }


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def main() -> None:
    """Measure everything, print the table, write the file."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    results = {name: factors(name) for name in PIECES}
    rows = [(name, *(f"{row[stage]:.1f}" for stage in STAGES)) for name, row in results.items()]
    print(cli_report.table([("piece", *STAGES), *rows]))
    print(record.write("speed", results, processor=processor(), cores=1, best_of=REPEATS))


if __name__ == "__main__":
    main()
