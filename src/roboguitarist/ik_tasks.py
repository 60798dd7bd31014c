"""Tasks of the inverse kinematics beside mink's own: fingers apart, off the strings, at places."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import mink
import mujoco
import numpy as np

if TYPE_CHECKING:
    from roboguitarist.kinematics import Solver

TOUCHING_M = 0.0008
"""Height over the strings' axes at which a finger that lies flat touches them."""
FIRM = 4.0
"""How much more it costs to miss that height than to come too near to the strings."""


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


class TipTask(mink.Task):
    """Leads sites to places that leave them room along the strings.

    Within its room a site is drawn to its place by no more than `Solver.room_pull` of its cost:
    anywhere between two fret wires a finger sounds the same note, and fingers that share a fret
    find places beside each other.
    """

    def __init__(self, solver: Solver) -> None:
        self.sites = [solver.model.site(name).id for name in solver.sites]
        self.pull = solver.room_pull
        self.target_m = np.zeros((len(self.sites), 3))
        self.room_m = np.zeros((len(self.sites), 2))
        super().__init__(np.zeros(3 * len(self.sites)))

    def aim(self, target_m: np.ndarray, weight: np.ndarray, room_m: np.ndarray) -> None:
        """Set places (k, 3), costs of a metre (k,), and room (k, 2) as `TipPaths` has them."""
        self.target_m, self.room_m = target_m, room_m
        self.cost = np.repeat(weight, 3)

    def compute_error(self, configuration: mink.Configuration) -> np.ndarray:
        """Position less place (3 k,) in metres, along the strings with the room taken off."""
        error = configuration.data.site_xpos[self.sites] - self.target_m
        within = np.clip(error[:, 0], *self.room_m.T)
        error[:, 0] += (self.pull - 1.0) * within
        return error.ravel()

    def compute_jacobian(self, configuration: mink.Configuration) -> np.ndarray:
        """Derivative (3 k, nv) of the error."""
        model, data = configuration.model, configuration.data
        arms = np.zeros((len(self.sites), 3, model.nv))
        for arm, site in zip(arms, self.sites, strict=True):
            mujoco.mj_jacSite(model, data, arm, None, site)
        off = data.site_xpos[self.sites, 0] - self.target_m[:, 0]
        within = (self.room_m[:, 0] < off) & (off < self.room_m[:, 1])
        arms[within, 0] *= self.pull
        return arms.reshape(-1, model.nv)
