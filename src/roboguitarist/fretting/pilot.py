"""What moves the left hand tick by tick, from what the sensors say: a policy, or a plan alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting import planner
from roboguitarist.fretting.episodes import assembled, make_task
from roboguitarist.fretting.paper import PaperTask
from roboguitarist.fretting.policy import Policy
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.plan import LEAD_IN_S, PLAN_HZ, HandPlan, plan_times
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.sensing import Stops, columns, power_columns, stops


@dataclass(frozen=True)
class Reading:
    """One left hand at one moment, as a task reads it (see `task.Hands`)."""

    qpos: np.ndarray
    qvel: np.ndarray
    tip_m: np.ndarray
    held: Stops
    mean_power_w: np.ndarray

    def press_force_n(self) -> np.ndarray:
        """Normal force (1, 6, F) in each fret space."""
        return self.held.force_n

    def sounding_fret(self, capo: int = 0) -> np.ndarray:
        """Fret (1, 6) that each string would sound."""
        return self.held.sounding_fret(capo)

    def over_tick(self) -> Stops:
        """At the end of the tick alone: nobody is paid on stage."""
        return self.held

    def power_w(self) -> np.ndarray:
        """Absolute mechanical power (1,) over the last tick."""
        return self.mean_power_w


class Pilot:
    """Plays one piece with a policy, whichever task it was trained on.

    Args:
        policy: What moves the hand, or corrects its plan; None for the plan alone.
        fingering: What is played.
        scene: Guitar, hands and time step.
        model: A model of the scene, with the left hand first.
        guitar: Name of the scene's guitar preset.
        plan: How the planner would play it, if it is at hand; for the guided task.

    Attributes:
        plan: What the hand does where the policy has no say: before and after the piece.
        first: The plan's sample at which the policy begins.
        parts: Samples of the plan in a tick.

    Raises:
        RoboGuitaristError: If the policy was trained for something else.
    """

    def __init__(
        self,
        policy: Policy | None,
        fingering: Fingering,
        scene: SceneConfig,
        model: mujoco.MjModel,
        *,
        guitar: str = "classical",
        plan: HandPlan | None = None,
    ) -> None:
        if policy and policy.hand != scene.hand:
            raise RoboGuitaristError(
                f"the policy is for the hand {policy.hand!r}, not for {scene.hand!r}"
            )
        config = _on_stage(policy, scene, guitar)
        if config.task == "guided" and plan is None:
            plan = planner.plan(fingering, scene)
        left = left_alone(scene)
        self._task = make_task([fingering], config, left, [plan] if plan else None)
        if isinstance(self._task, PaperTask):
            plan = _resting(self._task, fingering)
        assert plan is not None
        self.plan, self._policy = plan, policy
        self._model, self._guitar, self._n_left = model, scene.guitar, left.nq
        self._tips = np.array([columns(model, tip) for tip in LEFT_TIPS])
        self._power = power_columns(model)
        self._last = self._change = np.zeros((1, self._task.n_actions))
        self.parts = round(PLAN_HZ / config.control_hz)
        self.first = round((LEAD_IN_S - config.lead_s) * PLAN_HZ)

    @property
    def n_ticks(self) -> int:
        """Ticks until the piece ends; after that the policy has no say."""
        return int(self._task.bank.length[0])

    def ctrl(
        self, tick: int, qpos: np.ndarray, qvel: np.ndarray, sensordata: np.ndarray
    ) -> np.ndarray:
        """Servo targets (parts, nu) of the left hand for one tick.

        Args:
            tick: Counts from 0, and up by one with each call.
            qpos: (nq,) positions of the whole scene at the beginning of the tick.
            qvel: (nv,) velocities, then.
            sensordata: (S, nsensordata) over the physics steps of the tick before, the last
                one's being those of that moment.
        """
        force, velocity = (sensordata[:, found_at] for found_at in self._power)
        reading = Reading(
            qpos[None, : self._n_left],
            qvel[None, : self._n_left],
            sensordata[-1, self._tips][None],
            stops(self._model, sensordata[-1:], self._guitar),
            np.abs(force * velocity).sum(axis=1).mean(keepdims=True),
        )
        reward = np.zeros(1)
        if tick and self._policy and isinstance(self._task, PaperTask):
            before = np.zeros(1, int), np.full(1, tick - 1)
            reward = self._task.reward(reading, before, self._change)[0].sum(axis=1)
        at = np.zeros(1, int), np.full(1, tick)
        action = np.zeros_like(self._last)
        if self._policy:
            seen = assembled(self._task.observe(reading, at, self._last, reward))
            action = self._policy.act(seen)
        action = self._task.taken(action, self._last)
        targets = self._task.ctrl(action, self._last, reading, at)
        self._change, self._last = action - self._last, action
        if targets.ndim == 2:
            targets = np.repeat(targets[:, None], self.parts, axis=1)
        return targets[0]


def _on_stage(policy: Policy | None, scene: SceneConfig, guitar: str) -> TaskConfig:
    """The policy's task with the scene's time step.

    Raises:
        RoboGuitaristError: If the plans' samples do not fill its ticks, or it begins before them.
    """
    config = policy.task_config() if policy else TaskConfig("guided", scene.hand)
    lead_s = LEAD_IN_S if config.task == "guided" else config.lead_s
    parts = PLAN_HZ / config.control_hz
    if abs(parts - round(parts)) > 1e-6 or lead_s > LEAD_IN_S:
        raise RoboGuitaristError(
            f"a policy of {config.control_hz:g} Hz that begins {lead_s:g} s before the piece"
            f" (its ticks must be whole numbers of 1/{PLAN_HZ:g} s, at most {LEAD_IN_S:g} s before)"
        )
    substeps = round(1.0 / (config.control_hz * scene.timestep_s))
    return replace(config, guitar=guitar, substeps=substeps, lead_s=lead_s)


def _resting(task: PaperTask, fingering: Fingering) -> HandPlan:
    """A plan that keeps the hand where the episode begins."""
    at = np.zeros(1, int), np.zeros(1, int)
    time_s = plan_times(fingering.tablature.duration_s)
    rows = task.start(at), task.resting_ctrl(at)
    return HandPlan(time_s, *(np.repeat(row, len(time_s), axis=0) for row in rows))
