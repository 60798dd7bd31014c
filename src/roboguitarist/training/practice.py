"""What a policy for every tablature practises: generated exercises, planned on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np
from tqdm import tqdm

from roboguitarist.exercises import KINDS, ExerciseConfig, Kind, generate
from roboguitarist.fingering import assign
from roboguitarist.fretting import planner
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.policy import Policy
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.plan import HandPlan
from roboguitarist.sensing import PRESS_THRESHOLD_N
from roboguitarist.tablature import Tablature
from roboguitarist.training.loop import Evaluation

EXERCISE = ExerciseConfig(duration_s=6.0)
OFTEN = (
    Kind.BARRE_CHORDS,
    Kind.BARRE_CHORDS,
    Kind.OPEN_CHORDS,
    Kind.ARPEGGIOS,
    Kind.POWER_CHORDS,
    Kind.SLOW_CHANGES,
    Kind.FAST_CHANGES,
    Kind.RANDOM_SHAPES,
    Kind.MELODY_OVER_BASS,
)
"""Kinds that are practised more often than the others: the plan alone fails there most."""
PRACTICE_SEEDS, EXAM_SEED = (10**6, 10**9), 0
"""Exercises to learn from have seeds in this range; those of the exam begin with that one."""
EXAMS = 3
"""Exercises of each kind in the exam."""


def exercises(n: int, seed: int) -> dict[str, Tablature]:
    """Draw exercises to learn from, by name.

    Args:
        n: How many.
        seed: Of the choice.
    """
    rng, kinds = np.random.default_rng(seed), (*KINDS, *OFTEN)
    found: dict[str, Tablature] = {}
    while len(found) < n:
        kind, number = kinds[rng.integers(len(kinds))], int(rng.integers(*PRACTICE_SEEDS))
        found[f"{kind}-{number}"] = generate(kind, number, EXERCISE)
    return found


def planned(
    tablatures: Sequence[Tablature], config: TaskConfig, workers: int | None = None
) -> list[HandPlan]:
    """What the planner would do, worked out by several processes, with a progress bar.

    Args:
        tablatures: What is to be played.
        config: The task; its scene matters.
        workers: Processes; by default one for each core.
    """
    jobs = [(tablature, config) for tablature in tablatures]
    workers = min(workers or os.cpu_count() or 1, len(jobs))
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        rows = tqdm(
            pool.map(_plan, jobs, chunksize=4), "plans", len(jobs), disable=None, leave=False
        )
        return list(rows)


def _plan(job: tuple[Tablature, TaskConfig]) -> HandPlan:
    tablature, config = job
    return planner.plan(assign(tablature), config.scene())


@dataclass
class _Count:
    """Frames and onsets of one kind of exercise."""

    right: int = 0
    extra: int = 0
    missing: int = 0
    onsets: int = 0
    ready: int = 0

    def add(self, other: _Count) -> None:
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)

    @property
    def frame(self) -> float:
        return 2 * self.right / max(2 * self.right + self.extra + self.missing, 1)

    @property
    def onset(self) -> float:
        return self.ready / max(self.onsets, 1)


def examiner(config: TaskConfig, n_threads: int = 0) -> Callable[[Policy | None], Evaluation]:
    """What lets a policy play exercises that nobody practises, with the left hand alone.

    The score is the mean of `frame`, the F1 of the keys held at each tick, and `onset`, the share
    of notes whose string would sound right at the end of the tick that is nearest to their onset;
    open strings count in the latter.

    Args:
        config: The task.
        n_threads: Threads of the physics.
    """
    drawn = [(kind, EXAM_SEED + i) for kind in KINDS for i in range(EXAMS)]
    tablatures = [generate(kind, number, EXERCISE) for kind, number in drawn]
    whole = replace(config, random_start=False, max_ticks=0)
    plans = planned(tablatures, whole) if config.task == "guided" else None
    batch = FrettingBatch(tablatures, whole, len(drawn), n_threads, plans)

    def evaluate(policy: Policy | None) -> Evaluation:
        counts = _played(batch, policy)
        total, scalars = _Count(), {}
        for kind in KINDS:
            mine = _Count()
            for (other, _), count in zip(drawn, counts, strict=True):
                if other == kind:
                    mine.add(count)
            total.add(mine)
            scalars |= {f"exam/{kind}/frame": mine.frame, f"exam/{kind}/onset": mine.onset}
        scalars |= {"exam/frame": total.frame, "exam/onset": total.onset}
        return Evaluation((total.frame + total.onset) / 2, scalars)

    return evaluate


def _played(batch: FrettingBatch, policy: Policy | None) -> list[_Count]:
    """Let each environment play its own tablature from the beginning, without chance."""
    every, bank, hands = np.arange(batch.n_envs), batch.bank, batch.hands
    batch.reset()
    batch.episode[:], batch.tick[:] = every, 0
    hands.put(every, batch.task.start(batch.at))
    seen, live = batch.observe(), np.ones(batch.n_envs, bool)
    counts = [_Count() for _ in every]
    frets, tick_s = np.arange(1, hands.guitar.n_frets + 1), 1.0 / batch.config.control_hz
    while live.any():
        episode, tick = batch.episode.copy(), batch.tick.copy()
        action = np.zeros((batch.n_envs, batch.n_actions))
        seen, _, ended, _ = batch.step(policy.act(seen) if policy else action)
        now = episode, np.minimum(tick + 1, bank.fret.shape[1] - 1)
        held = hands.press_force_n() >= PRESS_THRESHOLD_N
        wanted = bank.fret[now][..., None] == frets
        until_s = bank.until_onset_s[episode, tick]
        onset = (until_s > 0.501 * tick_s) & (until_s <= 1.501 * tick_s)
        ready = onset & (hands.sounding_fret() == bank.next_fret[episode, tick])
        for one in np.flatnonzero(live):
            counts[one].add(_Count(
                int((held[one] & wanted[one]).sum()),
                int((held[one] & ~wanted[one]).sum()),
                int((~held[one] & wanted[one]).sum()),
                int(onset[one].sum()),
                int(ready[one].sum()),
            ))  # fmt: skip
        live &= ~ended
    return counts
