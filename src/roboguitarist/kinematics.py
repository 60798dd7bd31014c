"""Joint paths that lead fingertips along given paths, by inverse kinematics with mink."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mink
import mujoco
import numpy as np

_MAX_STEP_RAD = 0.3
_FIRST_ITERATIONS = 80
_TOLERANCE = 2e-4


@dataclass(frozen=True)
class TipPaths:
    """Where k fingertips are to be at T times.

    Attributes:
        position_m: (T, k, 3) positions in the guitar's frame.
        weight: (T, k) cost of a metre of error; 0 lets a finger go where its posture leads.
        rest: (T, nq) posture towards which everything is weakly drawn.
    """

    position_m: np.ndarray
    weight: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True)
class Solver:
    """Settings of the inverse kinematics of one hand.

    Attributes:
        model: A model with this hand alone; its joint ranges are kept.
        sites: Names of the k sites to lead.
        posture_cost: (nv,) cost of a radian or metre away from the rest posture.
        apart: Groups of geom names of which neighbouring groups must not touch.
        pointing: Direction that the sites' z axes are drawn to, in the guitar's frame.
        pointing_cost: Its cost, 0 for none.
        clearance_m: Distance kept between the groups of `apart`.
    """

    model: mujoco.MjModel
    sites: tuple[str, ...]
    posture_cost: np.ndarray
    apart: tuple[tuple[str, ...], ...] = ()
    pointing: tuple[float, float, float] = (0.0, 0.0, -1.0)
    pointing_cost: float = 0.0
    clearance_m: float = 0.0005
    iterations: int = field(default=2)


def follow(
    solver: Solver,
    paths: TipPaths,
    progress: Callable[[Sequence[int]], Sequence[int]] | None = None,
) -> np.ndarray:
    """Joint path along which the tips follow their paths.

    Each sample starts from the one before it, so a smooth path gives smooth joints. Where all
    targets stand still the joints do too.

    Args:
        solver: The hand.
        paths: Where its tips go.
        progress: Wraps the loop over the samples, to show how far it is.

    Returns:
        (T, nq) joint positions in rad and m.
    """
    tasks, limits, constraints = _problem(solver)
    configuration = mink.Configuration(solver.model, paths.rest[0])
    out = np.empty((len(paths.position_m), solver.model.nq))
    ticks: Sequence[int] = range(len(out))
    settled = False
    for tick in progress(ticks) if progress else ticks:
        if tick and settled and _unchanged(paths, tick):
            out[tick] = out[tick - 1]
            continue
        _aim(tasks, paths, tick)
        settled = False
        for _ in range(solver.iterations if tick else _FIRST_ITERATIONS):
            velocity = mink.solve_ik(
                configuration,
                [*tasks.tips, *tasks.pointing, tasks.posture],
                1.0,
                "daqp",
                1e-6,
                limits=limits,
                constraints=constraints,
            )
            configuration.integrate_inplace(np.clip(velocity, -_MAX_STEP_RAD, _MAX_STEP_RAD), 1.0)
            settled = bool(np.abs(velocity).max() < _TOLERANCE)
            if settled:
                break
        out[tick] = configuration.q
    return out


@dataclass(frozen=True)
class _Tasks:
    tips: list[mink.FrameTask]
    pointing: list[mink.AxisAlignTask]
    posture: mink.PostureTask


def _problem(solver: Solver) -> tuple[_Tasks, list[mink.Limit], list[mink.Task]]:
    model = solver.model
    pointing = []
    if solver.pointing_cost:
        pointing = [
            mink.AxisAlignTask(site, "site", (0, 0, 1), solver.pointing_cost)
            for site in solver.sites
        ]
        for task in pointing:
            task.set_target(solver.pointing)
    tasks = _Tasks(
        [mink.FrameTask(site, "site", 1.0, 0.0, gain=0.7) for site in solver.sites],
        pointing,
        mink.PostureTask(model, solver.posture_cost, gain=0.7),
    )
    limits: list[mink.Limit] = [mink.ConfigurationLimit(model)]
    if solver.apart:
        pairs = list(zip(solver.apart, solver.apart[1:], strict=False))
        limits.append(
            mink.CollisionAvoidanceLimit(
                model,
                pairs,
                gain=0.5,
                minimum_distance_from_collisions=solver.clearance_m,
                collision_detection_distance=0.02,
            )
        )
    constraints: list[mink.Task] = []
    if model.neq:
        constraints.append(mink.EqualityConstraintTask(model, cost=1.0))
    return tasks, limits, constraints


def _aim(tasks: _Tasks, paths: TipPaths, tick: int) -> None:
    for task, position, weight in zip(
        tasks.tips, paths.position_m[tick], paths.weight[tick], strict=True
    ):
        task.set_target(mink.SE3.from_translation(position))
        task.set_position_cost(weight)
    tasks.posture.set_target(paths.rest[tick])


def _unchanged(paths: TipPaths, tick: int) -> bool:
    return all(
        np.array_equal(values[tick], values[tick - 1])
        for values in (paths.position_m, paths.weight, paths.rest)
    )
