"""What a policy for every tablature practises: generated exercises, planned on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
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
        scalars: dict[str, float] = {}
        for kind in KINDS:
            mine = np.array([other == kind for other, _ in drawn])
            frame, onset = _scores(counts[mine])
            scalars |= {f"exam/{kind}/frame": frame, f"exam/{kind}/onset": onset}
        frame, onset = _scores(counts)
        return Evaluation(
            (frame + onset) / 2, {**scalars, "exam/frame": frame, "exam/onset": onset}
        )

    return evaluate


def _scores(counts: np.ndarray) -> tuple[float, float]:
    """F1 of the frames, and the share of onsets that were ready, of what `_played` counted."""
    right, extra, missing, onsets, ready = counts.sum(axis=0).tolist()
    return 2 * right / max(2 * right + extra + missing, 1), ready / max(onsets, 1)


def _played(batch: FrettingBatch, policy: Policy | None) -> np.ndarray:
    """Let each environment play its own tablature from the beginning, without chance.

    Returns:
        (N, 5) keys held rightly, held in vain, and missing over all ticks; onsets, and onsets whose
        string was ready.
    """
    every, bank, hands = np.arange(batch.n_envs), batch.bank, batch.hands
    batch.reset()
    batch.episode[:], batch.tick[:] = every, 0
    hands.put(every, batch.task.start(batch.at))
    seen, live = batch.observe(), np.ones(batch.n_envs, bool)
    counts = np.zeros((batch.n_envs, 5), int)
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
        keys = [part.sum(axis=(1, 2)) for part in (held & wanted, held & ~wanted, ~held & wanted)]
        notes = [part.sum(axis=1) for part in (onset, ready)]
        counts[live] += np.column_stack([*keys, *notes])[live]
        live &= ~ended
    return counts
