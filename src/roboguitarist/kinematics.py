"""Joint paths that lead fingertips along given paths, by inverse kinematics with mink."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import mink
import mujoco
import numpy as np

_DAMPING = 1e-3
_TOLERANCE = 2e-4
LYING = (0.0, -1.0, -0.1)
"""Direction of a fingertip that lies across the strings, towards the bass."""
FIRM = 4.0
"""How much more it costs to miss that height than to come too near to the strings."""
TOUCHING_M = 0.0008
"""Height over the strings' axes at which a finger that lies flat touches them."""


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
    """

    position_m: np.ndarray
    weight: np.ndarray
    rest: np.ndarray
    aloft: np.ndarray | None = None
    flat: np.ndarray | None = None


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
    over_m: float = 0.004
    half_width_m: float = 0.028
    iterations: int = 40


def follow(solver: Solver, paths: TipPaths) -> np.ndarray:
    """Joint path along which the tips follow their paths.

    Each sample starts from the one before it, so a smooth path gives smooth joints. Where all
    targets stand still the joints do too.

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
        settled = _descend(configuration, tasks.every, limits, constraints, solver.iterations)
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
    tips: list[mink.FrameTask]
    pointing: list[mink.AxisAlignTask]
    direction: tuple[float, float, float]
    posture: mink.PostureTask
    clearance: ClearanceTask | None
    others: list[mink.Task]

    @property
    def every(self) -> list[mink.Task]:
        clearance = [self.clearance] if self.clearance else []
        return [*self.tips, *self.pointing, *self.others, *clearance, self.posture]


def _problem(solver: Solver) -> tuple[_Tasks, list[mink.Limit], list[mink.Task]]:
    model = solver.model
    others: list[mink.Task] = [SeparationTask(solver)] if solver.apart else []
    pointing: list[mink.AxisAlignTask] = []
    for site in solver.sites if solver.pointing_cost else ():
        task = mink.AxisAlignTask(site, "site", (0, 0, 1), solver.pointing_cost)
        task.set_target(solver.pointing)
        pointing.append(task)
    tasks = _Tasks(
        [mink.FrameTask(site, "site", 1.0, 0.0) for site in solver.sites],
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


class SeparationTask(mink.Task):
    """Pushes neighbouring fingers apart where they are closer than the clearance.

    A soft counterpart of `mink.CollisionAvoidanceLimit`: that one only forbids to come nearer, so
    a hand that starts entangled stays so (it blocked 11 of 51 hand shapes of the repertoire).
    """

    def __init__(self, solver: Solver) -> None:
        model = solver.model
        self.pairs = [
            (model.geom(first).id, model.geom(second).id)
            for group, neighbour in pairwise(solver.apart)
            for first in group
            for second in neighbour
        ]
        self.clearance_m = solver.clearance_m
        super().__init__(np.full(len(self.pairs), solver.apart_cost))

    def compute_error(self, configuration: mink.Configuration) -> np.ndarray:
        """Missing distance of each pair in metres, 0 or below."""
        return self._evaluate(configuration)[0]

    def compute_jacobian(self, configuration: mink.Configuration) -> np.ndarray:
        """Derivative (pairs, nv) of the error; zero for pairs that are far enough apart."""
        return self._evaluate(configuration)[1]

    def compute_qp_residual(
        self, configuration: mink.Configuration
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Both at once, as mink's solver wants them."""
        return self._weighted_residual(*self._evaluate(configuration))

    def _evaluate(self, configuration: mink.Configuration) -> tuple[np.ndarray, np.ndarray]:
        model, data = configuration.model, configuration.data
        error, jacobian = np.zeros(len(self.pairs)), np.zeros((len(self.pairs), model.nv))
        ends, first, second = np.empty(6), np.empty((3, model.nv)), np.empty((3, model.nv))
        for row, pair in enumerate(self.pairs):
            distance = mujoco.mj_geomDistance(model, data, *pair, self.clearance_m, ends)
            if distance >= self.clearance_m:
                continue
            normal = (ends[3:] - ends[:3]) / (distance or 1.0)
            mujoco.mj_jac(model, data, first, None, ends[:3], model.geom_bodyid[pair[0]])
            mujoco.mj_jac(model, data, second, None, ends[3:], model.geom_bodyid[pair[1]])
            error[row] = distance - self.clearance_m
            jacobian[row] = normal @ (second - first)
        return error, jacobian


class ClearanceTask(mink.Task):
    """Keeps joints and idle fingertips off the strings.

    A point with radius r is to stay at least r + `over_m` above the strings' axes while it is
    over the fretboard. The joints of a finger that lies flat are to be at the height at which
    they touch.
    """

    def __init__(self, solver: Solver) -> None:
        model = solver.model
        self.points = [(model.body(name).id, r) for name, r in solver.knuckles]
        self.sites = [model.site(name).id for name in solver.sites]
        self.radius = np.array(
            [r for _, r in self.points] + [solver.tip_radius_m] * len(self.sites)
        )
        self.over_m, self.half_width_m = solver.over_m, solver.half_width_m
        self.aloft = np.ones(len(self.sites))
        self.flat = np.zeros(len(self.sites))
        self._per_finger = len(self.points) // len(self.sites)
        super().__init__(np.full(len(self.radius), solver.apart_cost))

    def compute_error(self, configuration: mink.Configuration) -> np.ndarray:
        """Missing height of each point in metres, 0 or below unless it is to be flat."""
        data = configuration.data
        bodies = [body for body, _ in self.points]
        place = np.vstack([data.xpos[bodies], data.site_xpos[self.sites]])
        # Past the edge the demand fades, so that it does not jump there.
        inside = np.clip((self.half_width_m - place[:, 1]) / 0.005, 0.0, 1.0)
        inside[len(bodies) :] *= self.aloft
        over = np.minimum(0.0, place[:, 2] - self.radius - self.over_m) * inside
        flat = np.zeros_like(over)
        flat[: len(bodies)] = np.repeat(self.flat, self._per_finger)
        lying = FIRM * (place[:, 2] - self.radius - TOUCHING_M)
        return (1.0 - flat) * over + flat * lying

    def compute_jacobian(self, configuration: mink.Configuration) -> np.ndarray:
        """Derivative (points, nv) of the error; zero for points that are high enough.

        In the strip where the demand fades it is that of the height alone, so that points are
        lifted there rather than driven off the edge.
        """
        model, data = configuration.model, configuration.data
        error, jacobian = self.compute_error(configuration), np.zeros((len(self.radius), model.nv))
        arm = np.empty((3, model.nv))
        for row in np.flatnonzero(error):
            if row < len(self.points):
                mujoco.mj_jacBody(model, data, arm, None, self.points[row][0])
                arm *= 1.0 + (FIRM - 1.0) * self.flat[row // self._per_finger]
            else:
                mujoco.mj_jacSite(model, data, arm, None, self.sites[row - len(self.points)])
                arm *= self.aloft[row - len(self.points)]
            jacobian[row] = arm[2]
        return jacobian


def _aim(tasks: _Tasks, paths: TipPaths, tick: int) -> None:
    for task, position, weight in zip(
        tasks.tips, paths.position_m[tick], paths.weight[tick], strict=True
    ):
        task.set_target(mink.SE3.from_translation(position))
        task.set_position_cost(weight)
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
    targets = (paths.position_m, paths.weight, paths.rest, paths.aloft, paths.flat)
    return all(
        values is None or np.array_equal(values[tick], values[tick - 1]) for values in targets
    )
