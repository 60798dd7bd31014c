"""Our task: the planner leads, the agent corrects its servo targets and is paid for what sounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting import planner, rewards
from roboguitarist.fretting.bank import HORIZON_S, Bank, padded
from roboguitarist.fretting.task import Block, Hands, Place, TaskConfig, Terms
from roboguitarist.plan import LEAD_IN_S, PLAN_HZ, HandPlan
from roboguitarist.sensing import DEAD
from roboguitarist.servo import actuator_moment

_FINGER = {"J4": 0.3, "J3": 0.3, "J0": 0.5}
CORRECTIONS: dict[str, float] = {
    "forearm_x": 0.004,
    "forearm_y": 0.004,
    "forearm_z": 0.002,
    "WRJ2": 0.05,
    "WRJ1": 0.05,
    "LFJ5": 0.2,
    **{f"{f}{j}": most for f in ("FF", "MF", "RF", "LF") for j, most in _FINGER.items()},
}
"""Most by which an action moves each servo target, in m and rad; the thumb's stay as planned.

Little for arm and wrist: what they do to one finger they do to all, and those that leave are late.
"""
FEEDBACK = 1.0
"""Share of what a servo misses that is added to its target, see `GuidedTask.ctrl`."""
ALOFT = 0.25
"""Share of its corrections that reaches a finger in the air."""
PROMPTNESS = 0.3
"""Share of its way that a correction goes in a tick: quicker ones make hand and policy tremble."""
READY_S = 0.01
"""A string is to be ready that long before its note begins, also if one before it still sounds."""
ONSET_S = 0.05
"""It counts more from that long before until a tick after the note has begun."""
MARGIN_M = 0.03
"""Distance from the key at which a tenth of the finger's reward is left."""
AHEAD_TICKS = (3, 8)
"""Ticks ahead at which the observation says how the planned posture will have changed."""
WEIGHTS = {"playing": 0.75, "finger": 0.15, "calm": 0.1}
FINGERS = ("FF", "MF", "RF", "LF")
NEIGHBOUR = 0.5
"""Share of what becomes of a finger that is owed to the finger beside it."""
_JOINT_RAD, _SLIDE_M, _NEAR_M, _FORCE_N = 0.2, 0.01, 0.02, 3.0


@dataclass(frozen=True)
class Guide:
    """Plans of K tablatures, padded to T ticks.

    Attributes:
        qpos: (K, T + 1, nq) float32, planned posture at the beginning of each tick.
        ctrl: (K, T, k, nu) float32, planned servo targets in k parts of each tick.
        grip: (K, T, k, 4) float32, how far each finger is down, 0 to 1.
    """

    qpos: np.ndarray
    ctrl: np.ndarray
    grip: np.ndarray


def guide(plans: Sequence[HandPlan], bank: Bank, config: TaskConfig) -> Guide:
    """Cut plans into control ticks.

    Between the samples of a plan everything changes evenly.

    Raises:
        RoboGuitaristError: If the lead is longer than the plans'.
    """
    if config.lead_s > LEAD_IN_S:
        raise RoboGuitaristError(f"lead_s {config.lead_s:g} (at most {LEAD_IN_S:g} with a plan)")
    parts = parts_of_tick(config)
    qpos, ctrl, grip = [], [], []
    for plan, length in zip(plans, bank.length.tolist(), strict=True):
        ticks = np.arange(length + 1) / config.control_hz - config.lead_s
        samples = np.arange(length * parts) / (parts * config.control_hz) - config.lead_s
        ctrl.append(_sampled(plan.time_s, plan.ctrl, samples).reshape(length, parts, -1))
        grip.append(_sampled(plan.time_s, plan.grip, samples).reshape(length, parts, -1))
        qpos.append(_sampled(plan.time_s, plan.qpos, ticks))
    return Guide(padded(qpos), padded(ctrl), padded(grip))


def parts_of_tick(config: TaskConfig) -> int:
    """In how many parts of a tick the targets differ: about as often as a plan's samples do."""
    most = int(1.3 * PLAN_HZ / config.control_hz)
    return max(k for k in range(1, max(most, 1) + 1) if config.substeps % k == 0)


def _sampled(time_s: np.ndarray, values: np.ndarray, at_s: np.ndarray) -> np.ndarray:
    """Values (T, n) of a plan at other times (S,), as (S, n) float32."""
    place = np.clip(np.interp(at_s, time_s, np.arange(len(time_s))), 0, len(time_s) - 1)
    first = np.minimum(place.astype(int), len(time_s) - 2)
    share = (place - first)[:, None]
    return ((1.0 - share) * values[first] + share * values[first + 1]).astype(np.float32)


def plans(fingerings: Sequence[Fingering], config: TaskConfig) -> list[HandPlan]:
    """What the planner would do, of all fingerings."""
    scene = config.scene()
    return [planner.plan(one, scene) for one in fingerings]


class GuidedTask:
    """Corrections to a plan.

    Args:
        config: Settings.
        model: The left hand, or a scene in which its joints and servos come first.
        bank: What is to be played.
        guide: How the planner would play it.
    """

    def __init__(self, config: TaskConfig, model: mujoco.MjModel, bank: Bank, guide: Guide) -> None:
        self.config, self.bank, self.guide = config, bank, guide
        nq, nu = guide.qpos.shape[-1], guide.ctrl.shape[-1]
        self._servos = np.array([model.actuator(f"lh_A_{name}").id for name in CORRECTIONS])
        self._most = np.array(list(CORRECTIONS.values()))
        self._range = model.actuator_ctrlrange[:nu].T
        self._moment = actuator_moment(model)[:nu, :nq]
        names = [model.joint(index).name for index in range(nq)]
        self._joints = np.array([i for i, name in enumerate(names) if "_TH" not in name])
        slides = np.array(["forearm" in names[i] for i in self._joints])
        self._unit = np.where(slides, _SLIDE_M, _JOINT_RAD)
        low, high = model.jnt_range[self._joints].T
        self._middle, self._half = (low + high) / 2, (high - low) / 2
        self.n_actions = len(self._servos)
        # Each finger is a group, arm and wrist the last; all are owed what no finger alone does.
        self.groups = np.array([(*FINGERS, name[:2]).index(name[:2]) for name in CORRECTIONS])
        self.credit = np.ones((5, 5))
        beside = np.abs(np.subtract.outer(np.arange(4), np.arange(4)))
        self.credit[:4, :4] = np.select([beside == 0, beside == 1], [1.0, NEIGHBOUR])
        self.blocks = observation_blocks(len(self._joints), self.n_actions)

    def ctrl(
        self, action: np.ndarray, last_action: np.ndarray, hands: Hands, at: Place
    ) -> np.ndarray:
        """Planned targets, corrected by the action and by how far the hand is from both.

        The corrections of a finger count in full while it is down. They go evenly from the last
        ones to these. What the hand missed of plan and corrections at the beginning of the tick is
        added: the servos alone are too weak to hold a finger against its neighbours.
        """
        targets = self.guide.ctrl[at].astype(float)
        share = (np.arange(targets.shape[1]) + 1.0)[:, None] / targets.shape[1]
        old, new = last_action[:, None], np.clip(action, -1.0, 1.0)[:, None]
        most = self._most * self._say(at)
        targets[:, :, self._servos] += (old + share * (new - old)) * most
        missed = (self.guide.qpos[at] - hands.qpos) @ self._moment.T
        missed[:, self._servos] += last_action * most[:, 0]
        targets += FEEDBACK * missed[:, None]
        return np.clip(targets, *self._range)

    def _say(self, at: Place) -> np.ndarray:
        """How much of each correction (N, k, A) counts: a finger's in full while it is down.

        A finger in the air goes nearly as planned, so that what was right for the press ends
        with it.
        """
        grip = self.guide.grip[at]
        grip = np.concatenate([grip, np.ones_like(grip[..., :1])], axis=-1)
        return ALOFT + (1.0 - ALOFT) * grip[..., self.groups]

    def taken(self, action: np.ndarray, last_action: np.ndarray) -> np.ndarray:
        """A part of the way from the last correction to the one that is asked for."""
        return last_action + PROMPTNESS * (action - last_action)

    def start(self, at: Place) -> np.ndarray:
        """As the planner would have it there."""
        return self.guide.qpos[at]

    def resting_action(self) -> np.ndarray:
        """No correction: (A,) zeros."""
        return np.zeros(self.n_actions, np.float32)

    def observe(
        self, hands: Hands, at: Place, last_action: np.ndarray, last_reward: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """The hand as it is beside the plan, and what is to come, seen from the fingertips."""
        bank, (episode, tick) = self.bank, at
        n_envs, last = len(tick), self.guide.qpos.shape[1] - 1
        qpos = hands.qpos[:, self._joints]
        planned = self.guide.qpos[at][:, self._joints]
        ahead = [
            self.guide.qpos[episode, np.minimum(tick + k, np.minimum(bank.length[episode], last))]
            for k in AHEAD_TICKS
        ]
        tips, active = hands.tip_m, bank.active[at]
        coming = bank.until_next_s[at] < HORIZON_S
        to_key = np.where(active[..., None], bank.key_m[at] - tips, 0.0)
        to_next = np.where(coming[..., None], bank.next_key_m[at] - tips, 0.0)
        return (
            (qpos - self._middle) / self._half,
            (qpos - planned) / self._unit,
            0.1 * hands.qvel[:, self._joints] / self._unit,
            *((posture[:, self._joints] - planned) / (3 * self._unit) for posture in ahead),
            np.tanh(to_key / _NEAR_M).reshape(n_envs, -1),
            np.tanh(to_next / _NEAR_M).reshape(n_envs, -1),
            active,
            bank.key_length_m[at] / (2 * _NEAR_M),
            bank.next_key_length_m[at] / (2 * _NEAR_M),
            bank.span[at] / 5.0,
            bank.next_span[at] / 5.0,
            _soon(bank.left_s[at]),
            _soon(bank.until_next_s[at]),
            *self._strings(hands, at),
            last_action,
        )

    def _strings(self, hands: Hands, at: Place) -> tuple[np.ndarray, ...]:
        bank, force = self.bank, hands.press_force_n()
        fret, asked = bank.fret[at].astype(int), bank.asked[at]
        held = _force_at(force, fret)
        sounding = hands.sounding_fret()
        wanted = np.maximum(fret, bank.capo[at[0]][:, None])
        return (
            np.minimum(held / _FORCE_N, 2.0),
            np.minimum((force.sum(axis=-1) - held) / _FORCE_N, 2.0),
            sounding == DEAD,
            asked & (np.maximum(sounding, bank.capo[at[0]][:, None]) == wanted),
            asked,
            fret > 0,
            bank.next_fret[at] > 0,
            _soon(bank.until_onset_s[at]),
        )

    def reward(self, hands: Hands, at: Place, change: np.ndarray) -> tuple[np.ndarray, Terms]:
        """What would be heard during the tick, by the fingers that hold it and the rest."""
        bank = self.bank
        now = at[0], np.minimum(at[1] + 1, bank.fret.shape[1] - 1)
        playing = self._heard(hands, at)
        near = rewards.nearness(
            hands.tip_m,
            bank.key_m[now],
            bank.key_length_m[now],
            self.config.mapping,
            margin_m=MARGIN_M,
        )
        active = bank.active[now]
        count = active.sum(axis=1, keepdims=True)
        near = np.where(active, near, 0.0) / np.maximum(count, 1)
        calm = rewards.calm_reward(change)
        idle = (count[:, 0] == 0).astype(float)
        parts = np.zeros((len(calm), 5))
        parts[:, :4] = WEIGHTS["finger"] * near
        parts[:, 4] = WEIGHTS["finger"] * idle + WEIGHTS["calm"] * calm
        parts += WEIGHTS["playing"] * self._shared(playing, now)
        sums = {"playing": playing.sum(axis=1), "finger": near.sum(axis=1) + idle}
        terms = {name: np.minimum(value, 1.0) for name, value in sums.items()} | {"calm": calm}
        return parts, terms

    def _heard(self, hands: Hands, at: Place) -> np.ndarray:
        """What each string (N, 6) adds to the reward, in the mean over moments of the tick.

        A string is to sound what it is asked to at the tick's beginning, and its next note from
        a little before that begins.
        """
        bank, held = self.bank, hands.over_tick()
        n_envs = len(at[0])
        n_samples = len(held.force_n) // n_envs
        passed_s = np.arange(1, n_samples + 1) / (n_samples * self.config.control_hz)
        until_s = bank.until_onset_s[at][:, None] - passed_s[:, None]
        asked, fret = bank.asked[at][:, None], bank.fret[at][:, None]
        ready_s = np.where(asked, READY_S, ONSET_S)
        soon = until_s < ready_s
        wanted = np.where(soon, bank.next_fret[at][:, None], fret)
        capo = bank.capo[at[0]][:, None, None]
        sounding = held.sounding_fret().reshape(n_envs, n_samples, 6)
        sounding = np.where(sounding == DEAD, DEAD, np.maximum(sounding, capo))
        rows = (sounding, np.maximum(wanted, capo), asked | soon, until_s < ONSET_S)
        playing = rewards.playing_reward(held.force_n, *(row.reshape(-1, 6) for row in rows))
        return playing.reshape(n_envs, n_samples, 6).mean(axis=1)

    def _shared(self, playing: np.ndarray, at: Place) -> np.ndarray:
        """What the strings (N, 6) add, by the fingers that hold them and, last, by none: (N, 5)."""
        bass, span = self.bank.string[at][:, :, None], self.bank.span[at][:, :, None]
        strings = np.arange(1, 7)
        under = (strings <= bass) & (strings >= bass - span) & (bass > 0)
        # Of several fingers on a string the one on the higher fret counts.
        under &= ~np.flip(np.cumsum(np.flip(under, 1), axis=1) > 1, 1)
        held = np.where(under, playing[:, None], 0.0).sum(axis=2)
        rest = playing.sum(axis=1) - held.sum(axis=1)
        return np.column_stack([held, rest])


def _soon(time_s: np.ndarray) -> np.ndarray:
    """1 for now, falling to almost 0 at the horizon."""
    return np.exp(-time_s / 0.3)


def _force_at(force_n: np.ndarray, fret: np.ndarray) -> np.ndarray:
    """Force (N, 6) in the fret space wanted on each string, 0 where none is."""
    index = np.clip(fret - 1, 0, force_n.shape[-1] - 1)[..., None]
    return np.where(fret > 0, np.take_along_axis(force_n, index, axis=-1)[..., 0], 0.0)


def observation_blocks(n_joints: int, n_actions: int) -> tuple[Block, ...]:
    """Rows of the observation in their order."""
    first, second = AHEAD_TICKS
    return (
        Block("joints", n_joints, "half range", "joint positions, the thumb's left out"),
        Block("off_plan", n_joints, "0.2 rad, 10 mm", "joint positions less the planned ones"),
        Block("velocities", n_joints, "2 rad/s, 0.1 m/s", "joint velocities"),
        Block("plan_soon", n_joints, "0.6 rad, 30 mm", f"change of the plan in {first} ticks"),
        Block("plan_later", n_joints, "0.6 rad, 30 mm", f"change of the plan in {second} ticks"),
        Block("to_key", 12, "tanh of 20 mm", "from each fingertip to its key, 0 for none"),
        Block("to_next", 12, "tanh of 20 mm", "from each fingertip to its next key, 0 for none"),
        Block("busy", 4, "0 or 1", "which fingers have a key"),
        Block("key_length", 4, "40 mm", "length of each finger's key"),
        Block("next_length", 4, "40 mm", "length of its next key"),
        Block("span", 4, "5 strings", "how many more strings each finger lies over"),
        Block("next_span", 4, "5 strings", "the same of its next key"),
        Block("key_left", 4, "exp of -0.3 s", "how soon each finger's key changes"),
        Block("key_soon", 4, "exp of -0.3 s", "how soon its next key begins"),
        Block("held", 6, "3 N, at most 2", "force on each string where it is wanted"),
        Block("pressed", 6, "3 N, at most 2", "force on it elsewhere"),
        Block("dead", 6, "0 or 1", "strings touched but not fretted"),
        Block("right", 6, "0 or 1", "strings that would sound what is asked"),
        Block("asked", 6, "0 or 1", "strings on which a note sounds"),
        Block("stopped", 6, "0 or 1", "strings to be held at a fret"),
        Block("next_stopped", 6, "0 or 1", "strings whose next note is stopped"),
        Block("onset_soon", 6, "exp of -0.3 s", "how soon each string's next note begins"),
        Block("last_action", n_actions, "-1 to 1", "the action before"),
    )
