"""A policy at the servos: it corrects a plan tick by tick, from what the sensors say."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting.bank import fill
from roboguitarist.fretting.episodes import assembled
from roboguitarist.fretting.guided import GuidedTask, guide
from roboguitarist.fretting.policy import Policy
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.plan import LEAD_IN_S, PLAN_HZ, HandPlan
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.sensing import Stops, columns, stops


@dataclass(frozen=True)
class Reading:
    """One left hand at one moment, as a task reads it (see `task.Hands`)."""

    qpos: np.ndarray
    qvel: np.ndarray
    tip_m: np.ndarray
    held: Stops

    def press_force_n(self) -> np.ndarray:
        """Normal force (1, 6, F) in each fret space."""
        return self.held.force_n

    def sounding_fret(self, capo: int = 0) -> np.ndarray:
        """Fret (1, 6) that each string would sound."""
        return self.held.sounding_fret(capo)

    def power_w(self) -> np.ndarray:
        """Not measured here."""
        return np.zeros(1)


class Pilot:
    """Plays one piece with a policy.

    Args:
        policy: What corrects.
        fingering: What is played.
        plan: How the planner would play it.
        scene: Guitar, hands and time step.
        model: A model of the scene, with the left hand first.

    Attributes:
        parts: Samples of the plan in a tick.

    Raises:
        RoboGuitaristError: If the policy was trained for something else.
    """

    def __init__(
        self,
        policy: Policy,
        fingering: Fingering,
        plan: HandPlan,
        scene: SceneConfig,
        model: mujoco.MjModel,
    ) -> None:
        if (policy.task, policy.hand) != ("guided", scene.hand):
            raise RoboGuitaristError(
                f"the policy is for the task {policy.task!r} with the hand {policy.hand!r},"
                f" not for 'guided' with {scene.hand!r}"
            )
        substeps = round(1.0 / (policy.control_hz * scene.timestep_s))
        config = TaskConfig(
            "guided", scene.hand, control_hz=policy.control_hz, substeps=substeps, lead_s=LEAD_IN_S
        )
        bank, _ = fill([fingering], config, scene.guitar)
        self._task = GuidedTask(config, model, bank, guide([plan], bank, config))
        self._policy, self._model, self._guitar = policy, model, scene.guitar
        self._tips = np.array([columns(model, tip) for tip in LEFT_TIPS])
        self._last = np.zeros((1, self._task.n_actions))
        self.parts = round(PLAN_HZ / policy.control_hz)

    @property
    def n_ticks(self) -> int:
        """Ticks until the piece ends; after that there is nothing to correct."""
        return int(self._task.bank.length[0])

    def ctrl(
        self, tick: int, qpos: np.ndarray, qvel: np.ndarray, sensordata: np.ndarray
    ) -> np.ndarray:
        """Servo targets (parts, nu) of the left hand for one tick.

        Args:
            tick: Counts from 0, and up by one with each call.
            qpos: (nq,) positions of the whole scene at the beginning of the tick.
            qvel: (nv,) velocities, then.
            sensordata: (nsensordata,) at that moment.
        """
        n_left = self._task.guide.qpos.shape[-1]
        reading = Reading(
            qpos[None, :n_left],
            qvel[None, :n_left],
            sensordata[self._tips][None],
            stops(self._model, sensordata[None], self._guitar),
        )
        at = np.zeros(1, int), np.full(1, tick)
        rows = self._task.observe(reading, at, self._last, np.zeros(1))
        action = self._policy.act(assembled(rows))
        targets = self._task.ctrl(action, self._last, at)
        self._last = action
        return targets[0]
