"""How many control steps of the fretting environment a second of processor and of wall buys.

Usage: python benchmarks/environment.py
Writes results/environment.json and prints a table of it. Run it on a machine that does nothing
else. Actions are random, 30 ticks a second with 10 physics steps each, episodes of 100 ticks from
random places, since a hand that has long moved at random is entangled and costs more.
"""

from __future__ import annotations

import os

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # before numpy is loaded

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import get_args

import numpy as np
import record
from speed import processor

from roboguitarist import cli_report
from roboguitarist.fretting.env import FrettingVectorEnv
from roboguitarist.hands import Variant

ENVIRONMENTS = (1, 16, 64, 256)
THREADS = (0, 1, 2)
"""0 steps in the calling thread."""
CONTROL_HZ, SUBSTEPS = 30.0, 10
CONTROL_STEPS, EPISODE_TICKS, REPEATS = 2000, 100, 2


@dataclass(frozen=True)
class Speed:
    """Control steps per second, and the share of wall time that is physics."""

    hand: str
    n_envs: int
    n_threads: int
    per_cpu_s: float
    per_wall_s: float
    physics_share: float


class Clock:
    """Sums the wall time in seconds that is spent under it."""

    def __init__(self) -> None:
        self.elapsed_s = 0.0

    @contextmanager
    def running(self) -> Iterator[None]:
        """Count the time until the block ends."""
        start = time.perf_counter()
        yield
        self.elapsed_s += time.perf_counter() - start


def measure(hand: Variant, n_envs: int, n_threads: int) -> Speed:
    """The fastest of `REPEATS` runs of about `CONTROL_STEPS` control steps, in wall time."""
    settings = {"hand": hand, "control_hz": CONTROL_HZ, "substeps": SUBSTEPS}
    settings |= {"random_start": True, "max_ticks": EPISODE_TICKS}
    envs = FrettingVectorEnv(n_envs, "twinkle", n_threads, **settings)
    physics = _timed(envs)
    runs = [_run(envs, physics) for _ in range(REPEATS)]
    envs.close()
    wall_s, cpu_s, physics_s = min(runs)
    steps = n_envs * _ticks(n_envs)
    return Speed(
        hand,
        n_envs,
        n_threads,
        round(steps / cpu_s, 1),
        round(steps / wall_s, 1),
        round(physics_s / wall_s, 3),
    )


def _ticks(n_envs: int) -> int:
    return max(CONTROL_STEPS // n_envs, EPISODE_TICKS)


def _timed(envs: FrettingVectorEnv) -> Clock:
    """Let a clock run whenever the hands are stepped."""
    clock, step = Clock(), envs.batch.hands.step

    def timed(ctrl: np.ndarray) -> np.ndarray:
        with clock.running():
            return step(ctrl)

    envs.batch.hands.step = timed
    return clock


def _run(envs: FrettingVectorEnv, physics: Clock) -> tuple[float, float, float]:
    """Seconds of wall, of processor (all threads), and of wall within physics."""
    rng = np.random.default_rng(0)
    shape = (_ticks(envs.num_envs), envs.num_envs, envs.batch.n_actions)
    actions = rng.uniform(-1, 1, shape).astype(np.float32)
    envs.reset(seed=0)
    envs.step(actions[0])
    physics.elapsed_s, wall, cpu = 0.0, time.perf_counter(), time.process_time()
    for action in actions:
        envs.step(action)
    return time.perf_counter() - wall, time.process_time() - cpu, physics.elapsed_s


def main() -> None:
    """Measure everything, print the table, write the file."""
    results = [
        measure(hand, n_envs, n_threads)
        for hand in get_args(Variant)
        for n_envs in ENVIRONMENTS
        for n_threads in THREADS
    ]
    header = ("hand", "environments", "threads", "per CPU s", "per wall s", "physics")
    rows = [
        (s.hand, str(s.n_envs), str(s.n_threads), f"{s.per_cpu_s:.0f}", f"{s.per_wall_s:.0f}",
         f"{s.physics_share:.0%}")
        for s in results
    ]  # fmt: skip
    print(cli_report.table([header, *rows]))
    facts = {"processor": processor(), "cores": os.cpu_count(), "load": os.getloadavg()[0]}
    settings = {"control_hz": CONTROL_HZ, "substeps": SUBSTEPS, "best_of": REPEATS}
    print(record.write("environment", [asdict(s) for s in results], **facts, **settings))


if __name__ == "__main__":
    main()
