"""The paper's fretting task over arrays: many environments stepped together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from roboguitarist import fingering
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting import rewards
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.goals import Goals, goals, one_hot, simplified
from roboguitarist.fretting.posture import POSTURES, rest_path, solver
from roboguitarist.fretting.presses import tip_height
from roboguitarist.fretting.task import Actions, TaskConfig, observation_blocks
from roboguitarist.sensing import PRESS_THRESHOLD_N
from roboguitarist.tablature import Tablature

OBSERVATION_LIMIT = 10.0
READY_M = 0.02
"""Height over the strings at which fingertips begin an episode."""
Terms = dict[str, np.ndarray]


@dataclass(frozen=True)
class Bank:
    """Goals of K tablatures, padded to T ticks, for N environments to read at once."""

    length: np.ndarray
    fret: np.ndarray
    key_m: np.ndarray
    key_length_m: np.ndarray
    active: np.ndarray
    string_goal: np.ndarray
    hold_position: np.ndarray


class FrettingBatch:
    """N environments stepped together as arrays; `fretting.env` wraps it for Gymnasium.

    Args:
        tablatures: What is to be fretted; each episode plays one of them, drawn at random.
        config: The task.
        n_envs: Number of environments.
        n_threads: Threads of the physics; 0 steps in the calling thread.

    Attributes:
        blocks: Rows of the observation.

    Raises:
        RoboGuitaristError: If there is no tablature or a setting makes no sense.
    """

    def __init__(
        self,
        tablatures: Sequence[Tablature],
        config: TaskConfig | None = None,
        n_envs: int = 1,
        n_threads: int = 0,
    ) -> None:
        if not tablatures:
            raise RoboGuitaristError("no tablature to fret (one at least)")
        self.config = config or TaskConfig()
        scene = self.config.scene()
        self.hands = HandBatch(scene, n_envs, self.config.control_hz, n_threads)
        self.actions = Actions(self.hands.model)
        self.blocks = observation_blocks(
            self.config, self.hands.model, scene.guitar, self.actions.size
        )
        self.bank = _bank(tablatures, self.config)
        self._starts = _starts(self.config)
        self._range = self.hands.model.jnt_range[:, 0], np.ptp(self.hands.model.jnt_range, axis=1)
        self.episode, self.tick = np.zeros(n_envs, int), np.zeros(n_envs, int)
        self.last_action = np.zeros((n_envs, self.actions.size))
        self.last_reward = np.zeros(n_envs)
        self.rng = np.random.default_rng()

    @property
    def n_envs(self) -> int:
        """Number of environments."""
        return self.hands.n_envs

    @property
    def observation_size(self) -> int:
        """Numbers in an observation."""
        return sum(block.size for block in self.blocks)

    def reset(self, mask: np.ndarray | None = None) -> np.ndarray:
        """Begin new episodes where `mask` (N,) is true, everywhere by default.

        Returns:
            Observations (N, observation_size) float32 of all environments.
        """
        index = np.arange(self.n_envs) if mask is None else np.flatnonzero(mask)
        self.episode[index] = self.rng.integers(len(self.bank.length), size=len(index))
        length = self.bank.length[self.episode[index]]
        begin = self.rng.integers(length) if self.config.random_start else np.zeros_like(length)
        self.tick[index] = begin
        hold = self.bank.hold_position[self.episode[index], begin]
        self.hands.put(index, self._starts[np.clip(hold, 1, len(self._starts)) - 1])
        self.last_action[index], self.last_reward[index] = 0.0, 0.0
        return self.observe()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, Terms]:
        """Play one tick.

        Args:
            action: (N, size) in [-1, 1].

        Returns:
            Observations (N, observation_size), rewards (N,), whether the piece has run out or
            the physics failed (N,), and the terms of the reward by name, (N,) each.
        """
        failed = self.hands.step(self.actions.ctrl(action))
        terms = self._terms()
        reward = rewards.total(terms["key"], terms["finger"], terms["energy"])
        reward[failed] = 0.0  # its energy may be anything
        self.last_action[:], self.last_reward[:] = np.clip(action, -1, 1), reward
        self.tick += 1
        ended = (self.tick >= self.bank.length[self.episode]) | failed
        np.minimum(self.tick, self.bank.length[self.episode] - 1, out=self.tick)
        return self.observe(), reward, ended, terms

    def observe(self) -> np.ndarray:
        """Observations (N, observation_size) float32, rows in the order of `blocks`."""
        at = self.episode, self.tick
        low, width = self._range
        joints = 2.0 * (self.hands.qpos - low) / width - 1.0
        active = self.bank.active[at]
        to_key = np.where(active[..., None], self.bank.key_m[at] - self.hands.tip_m, 0.0)
        rows = (
            joints[:, 3:],
            joints[:, :3],
            (self.hands.press_force_n() >= PRESS_THRESHOLD_N).reshape(self.n_envs, -1),
            self.last_action,
            self.last_reward[:, None],
            to_key.reshape(self.n_envs, -1) / 0.1,
            active,
            self.bank.string_goal[at],
        )
        seen = np.concatenate(rows, axis=1, dtype=np.float32)
        return np.clip(seen, -OBSERVATION_LIMIT, OBSERVATION_LIMIT)

    def _terms(self) -> Terms:
        at, config = (self.episode, self.tick), self.config
        fret, active = self.bank.fret[at], self.bank.active[at]
        force, tips, keys = self.hands.press_force_n(), self.hands.tip_m, self.bank.key_m[at]
        near = (
            rewards.euclidean_finger_reward(tips, keys, active, config.mapping)
            if config.euclidean
            else rewards.finger_reward(
                tips, keys, self.bank.key_length_m[at], active, config.mapping
            )
        )
        return {
            "key": rewards.key_reward(
                force, fret, config.freedom, PRESS_THRESHOLD_N, config.mapping
            ),
            "finger": near,
            "energy": rewards.energy(
                self.hands.power_w(), np.any(fret > 0, axis=1), config.energy_coefficient
            ),
        }


def _bank(tablatures: Sequence[Tablature], config: TaskConfig) -> Bank:
    guitar = config.scene().guitar
    every = [
        goals(fingering.assign(tablature), guitar, config.control_hz, config.lead_s)
        for tablature in tablatures
    ]
    frets = [goal.finger_fret.astype(float) for goal in every]
    return Bank(
        np.array([len(goal.fret) for goal in every]),
        _padded([goal.fret for goal in every]),
        _padded([goal.finger_point_m for goal in every]),
        _padded([guitar.fret_x(fret) - guitar.fret_x(fret - 1) for fret in frets]),
        _padded([goal.finger_string > 0 for goal in every]),
        _padded([_string_goal(goal, config, guitar.n_frets) for goal in every]),
        _padded([goal.hold_position for goal in every]),
    )


def _string_goal(goal: Goals, config: TaskConfig, n_frets: int) -> np.ndarray:
    if config.string_goal == "one_hot":
        return one_hot(goal, config.n_step_lookahead, n_frets).astype(np.float32)
    return simplified(goal, config.n_step_lookahead).astype(np.float32) / n_frets


def _padded(rows: list[np.ndarray]) -> np.ndarray:
    out = np.zeros((len(rows), max(map(len, rows)), *rows[0].shape[1:]), rows[0].dtype)
    for row, values in zip(out, rows, strict=True):
        row[: len(values)] = values
    return out


def _starts(config: TaskConfig) -> np.ndarray:
    """Postures (H, nq) at rest over hold positions 1 to H."""
    scene, posture = config.scene(), POSTURES[config.hand]
    hold = np.arange(1, scene.guitar.n_frets - 3)
    fret = hold[:, None] + np.arange(4)
    x = (scene.guitar.fret_x(fret - 1) + scene.guitar.fret_x(fret)) / 2
    y, z = np.zeros_like(x), np.full_like(x, tip_height(scene.guitar) + READY_M)
    tips = np.stack([x, y, z], axis=-1)
    model = solver(scene, posture).model
    # Without smoothing over time, since each row is another place.
    return np.concatenate(
        [rest_path(model, posture, tip[None], np.ones((1, 4)), 1.0) for tip in tips]
    )
