"""Joint paths that lead fingertips along given paths, by inverse kinematics with mink."""

from __future__ import annotations

from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from roboguitarist.ik_tasks import ClearanceTask, SeparationTask, TipTask

_DAMPING = 1e-3
_TOLERANCE = 2e-4
ENTANGLED, FREER = 0.15, 0.7
"""Cost above which a posture is looked for from the rest posture too, and the share of it that the
one found there must not reach to be taken."""
LYING = (0.0, -1.0, -0.1)
"""Direction of a fingertip that lies across the strings, towards the bass."""


@dataclass(frozen=True)
class TipPaths:
    """Where k fingertips are to be at T times.

    Attributes:
        position_m: (T, k, 3) positions in the guitar's frame.
        weight: (T, k) cost of a metre of error; 0 lets a finger go where its posture leads.
        aloft: (T, k) how much each fingertip is to be kept off the strings, 0 to 1; None for
            fingers that may cross them.
        rest: (T, nq) posture towards which everything is weakly drawn.
        flat: (T, k) how much each finger is to lie flat on the strings, 0 to 1; None for fingers
            that never do.
        room_m: (T, k, 2) how far from its position each fingertip may be along the strings,
            towards the nut (0 or less) and towards the bridge; None for none.
    """

    position_m: np.ndarray
    weight: np.ndarray
    rest: np.ndarray
    aloft: np.ndarray | None = None
    flat: np.ndarray | None = None
    room_m: np.ndarray | None = None


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
        apart_cost: Cost of a metre less than that, and less than the height over the strings.
        knuckles: Bodies whose origins stay off the strings, with their radii in metres.
        tip_radius_m: Radius of the fingertips.
        room_pull: Share of its cost with which a fingertip is drawn to its place within its room.
        over_m: Height over the strings that idle fingertips and knuckles keep.
        half_width_m: Half width of the fretboard, beyond which heights do not matter.
    """

    model: mujoco.MjModel
    sites: tuple[str, ...]
    posture_cost: np.ndarray
    apart: tuple[tuple[str, ...], ...] = ()
    pointing: tuple[float, float, float] = (0.0, 0.0, -1.0)
    pointing_cost: float = 0.0
    clearance_m: float = 0.001
    apart_cost: float = 60.0
    knuckles: tuple[tuple[str, float], ...] = ()
    tip_radius_m: float = 0.0065
    room_pull: float = 0.022
    over_m: float = 0.004
    half_width_m: float = 0.028
    iterations: int = 40


def follow(solver: Solver, paths: TipPaths) -> np.ndarray:
    """Joint path along which the tips follow their paths.

    Each sample starts from the one before it, so a smooth path gives smooth joints. Where all
    targets stand still the joints do too. Fingers that have crossed cannot come apart that way:
    where much is missed, the search starts from the rest posture once more.

    Args:
        solver: The hand.
        paths: Where its tips go.

    Returns:
        (T, nq) joint positions in rad and m.
    """
    tasks, limits, constraints = _problem(solver)
    configuration = mink.Configuration(
        solver.model, np.clip(paths.rest[0], *solver.model.jnt_range.T)
    )
    out = np.empty((len(paths.position_m), solver.model.nq))
    settled = False
    for tick in range(len(out)):
        if tick and settled and _unchanged(paths, tick):
            out[tick] = out[tick - 1]
            continue
        _aim(tasks, paths, tick)
        rest = np.clip(paths.rest[tick], *solver.model.jnt_range.T)
        settled = _descend(configuration, tasks.every, limits, constraints, solver.iterations)
        cost, found = _cost(configuration, tasks.every), configuration.q.copy()
        if cost > ENTANGLED:
            configuration.update(rest)
            again = _descend(configuration, tasks.every, limits, constraints, solver.iterations)
            if _cost(configuration, tasks.every) < FREER * cost:
                settled = again
            else:
                configuration.update(found)
        out[tick] = configuration.q
    return out


def _descend(
    configuration: mink.Configuration,
    tasks: list[mink.Task],
    limits: list[mink.Limit],
    constraints: list[mink.Task],
    iterations: int,
) -> bool:
    """Levenberg-Marquardt: more damping after a step that did not help, less after one that did.

    Returns:
        Whether it came to rest.
    """
    damping, cost = _DAMPING, _cost(configuration, tasks)
    for _ in range(iterations):
        before = configuration.q.copy()
        try:
            step = mink.solve_ik(
                configuration, tasks, 1.0, "daqp", damping, limits=limits, constraints=constraints
            )
        except mink.NoSolutionFound:
            return False  # the limits contradict the coupling: stay here
        configuration.integrate_inplace(step, 1.0)
        if np.abs(step).max() < _TOLERANCE:
            return True
        new = _cost(configuration, tasks)
        if new < cost:
            damping, cost = max(damping / 5.0, 1e-6), new
        else:
            configuration.update(before)
            damping *= 8.0
    return False


def _cost(configuration: mink.Configuration, tasks: list[mink.Task]) -> float:
    return sum(
        float(np.sum((task.cost * task.compute_error(configuration)) ** 2)) for task in tasks
    )


@dataclass(frozen=True)
class _Tasks:
    tips: TipTask
    pointing: list[mink.AxisAlignTask]
    direction: tuple[float, float, float]
    posture: mink.PostureTask
    clearance: ClearanceTask | None
    others: list[mink.Task]

    @property
    def every(self) -> list[mink.Task]:
        clearance = [self.clearance] if self.clearance else []
        return [self.tips, *self.pointing, *self.others, *clearance, self.posture]


def _problem(solver: Solver) -> tuple[_Tasks, list[mink.Limit], list[mink.Task]]:
    model = solver.model
    others: list[mink.Task] = [SeparationTask(solver)] if solver.apart else []
    pointing: list[mink.AxisAlignTask] = []
    for site in solver.sites if solver.pointing_cost else ():
        task = mink.AxisAlignTask(site, "site", (0, 0, 1), solver.pointing_cost)
        task.set_target(solver.pointing)
        pointing.append(task)
    tasks = _Tasks(
        TipTask(solver),
        pointing,
        solver.pointing,
        mink.PostureTask(model, solver.posture_cost),
        ClearanceTask(solver) if solver.knuckles else None,
        others,
    )
    constraints: list[mink.Task] = []
    if model.neq:
        constraints.append(mink.EqualityConstraintTask(model, cost=1.0))
    return tasks, [mink.ConfigurationLimit(model)], constraints


def _aim(tasks: _Tasks, paths: TipPaths, tick: int) -> None:
    none = np.zeros((len(paths.position_m[tick]), 2))
    room_m = none if paths.room_m is None else paths.room_m[tick]
    tasks.tips.aim(paths.position_m[tick], paths.weight[tick], room_m)
    tasks.posture.set_target(paths.rest[tick])
    if tasks.clearance and paths.aloft is not None:
        tasks.clearance.aloft = paths.aloft[tick]
    if paths.flat is None:
        return
    if tasks.clearance:
        tasks.clearance.flat = paths.flat[tick]
    for task, flat in zip(tasks.pointing, paths.flat[tick], strict=False):
        direction = (1.0 - flat) * np.array(tasks.direction) + flat * np.array(LYING)
        task.set_target(direction / np.linalg.norm(direction))


def _unchanged(paths: TipPaths, tick: int) -> bool:
    targets = (paths.position_m, paths.weight, paths.rest, paths.aloft, paths.flat, paths.room_m)
    return all(
        values is None or np.array_equal(values[tick], values[tick - 1]) for values in targets
    )
