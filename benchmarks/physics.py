"""What time step and solver cost, and how far they are from a step ten times finer.

Usage: python benchmarks/physics.py
Writes results/physics.json and prints a table of it. Plans of three pieces are played to the left
hand alone; the reference has 4,800 steps a second.
"""

from __future__ import annotations

import os

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # before numpy is loaded

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import mujoco
import numpy as np
import record
from mujoco import rollout
from speed import processor

from roboguitarist import cli_report, exercises, formats, pieces
from roboguitarist.fingering import assign
from roboguitarist.fretting import planner
from roboguitarist.fretting.posture import left_alone
from roboguitarist.plan import PLAN_HZ, HandPlan
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.sensing import Stops, columns, stops

REFERENCE_HZ, JUDGED_HZ = 4800, 60
LONGEST_S = 12.0
Change = Callable[[mujoco.MjOption], None]


@dataclass(frozen=True)
class Played:
    """What one setting made of one plan: seconds of processor a second, tips, readings."""

    cost: float
    tips_m: np.ndarray
    held: Stops


@dataclass(frozen=True)
class Row:
    """A setting against the reference."""

    setting: str
    steps_per_s: int
    times_real_time: float
    tip_mean_mm: float
    tip_95_mm: float
    force_mean_n: float
    other_fret_percent: float


def play(plan: HandPlan, steps_per_s: int, change: Change) -> Played:
    """Play a plan, with feedback from nothing."""
    scene = SceneConfig(timestep_s=1 / steps_per_s)
    model = left_alone(scene)
    change(model.opt)
    data = mujoco.MjData(model)
    data.qpos[:] = plan.qpos[0]
    mujoco.mj_forward(model, data)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    length_s = min(LONGEST_S, len(plan.ctrl) / PLAN_HZ)
    step_s = np.arange(int(length_s * steps_per_s)) / steps_per_s
    ctrl = plan.ctrl[np.minimum((step_s * PLAN_HZ + 1e-9).astype(int), len(plan.ctrl) - 1)]
    begin = time.process_time()
    _, readings = rollout.rollout(model, data, state, ctrl)
    cost = (time.process_time() - begin) / length_s
    every = steps_per_s // JUDGED_HZ
    judged = readings[0, every - 1 :: every]
    tips = np.stack([judged[:, columns(model, tip)] for tip in LEFT_TIPS], axis=1)
    return Played(cost, tips, stops(model, judged, scene.guitar))


def compare(name: str, steps_per_s: int, ours: list[Played], truth: list[Played]) -> Row:
    """One row of the table."""
    tip, force, other = [], [], []
    for one, true in zip(ours, truth, strict=True):
        tip.append(np.linalg.norm(one.tips_m - true.tips_m, axis=-1).ravel())
        held, true_held = one.held.force_n.sum(axis=2), true.held.force_n.sum(axis=2)
        force.append(np.abs(held - true_held)[true_held > 0.5])
        other.append((one.held.sounding_fret() != true.held.sounding_fret()).ravel())
    tips = 1e3 * np.concatenate(tip)
    return Row(
        name,
        steps_per_s,
        round(1.0 / float(np.mean([one.cost for one in ours])), 1),
        round(float(tips.mean()), 3),
        round(float(np.percentile(tips, 95)), 3),
        round(float(np.concatenate(force).mean()), 3),
        round(100.0 * float(np.concatenate(other).mean()), 2),
    )


def _set(**options: float) -> Change:
    def change(option: mujoco.MjOption) -> None:
        for name, value in options.items():
            setattr(option, name, value)

    return change


SETTINGS: tuple[tuple[str, int, Change], ...] = (
    *((f"as it is, {rate}", rate, _set()) for rate in (240, 300, 480, 600, 960)),
    ("pyramidal cone", 480, _set(cone=mujoco.mjtCone.mjCONE_PYRAMIDAL)),
    ("conjugate gradients", 480, _set(solver=mujoco.mjtSolver.mjSOL_CG)),
    ("5 iterations", 480, _set(iterations=5)),
    ("100 iterations", 480, _set(iterations=100)),
    ("Euler", 480, _set(integrator=mujoco.mjtIntegrator.mjINT_EULER)),
    ("implicit", 480, _set(integrator=mujoco.mjtIntegrator.mjINT_IMPLICIT)),
)


def main() -> None:
    """Play, compare, print, write."""
    chords = exercises.generate("open-chords", 3, exercises.ExerciseConfig(duration_s=8.0))
    scores = [formats.load(pieces.path(name)) for name in ("chord-transition", "fur-elise")]
    plans = [planner.plan(assign(score)) for score in (*scores, chords)]
    truth = [play(plan, REFERENCE_HZ, _set()) for plan in plans]
    rows = [
        compare(name, rate, [play(plan, rate, change) for plan in plans], truth)
        for name, rate, change in SETTINGS
    ]
    header = ("setting", "steps/s", "x real time", "tip mm", "95 %", "force N", "other fret %")
    print(cli_report.table([header, *(tuple(map(str, asdict(row).values())) for row in rows)]))
    print(record.write("physics", [asdict(row) for row in rows], processor=processor()))


if __name__ == "__main__":
    main()
