"""Fretting as arrays: many environments stepped together, on the paper's task or ours."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting.bank import fill, fingered, string_goals
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.guided import GuidedTask, guide, plans
from roboguitarist.fretting.paper import PaperTask
from roboguitarist.fretting.task import Block, Place, TaskConfig, Terms
from roboguitarist.plan import HandPlan
from roboguitarist.tablature import Tablature

OBSERVATION_LIMIT = 10.0
_KEPT = ("episode", "tick", "played", "last_action", "last_reward")


class FrettingBatch:
    """N environments stepped together as arrays; `fretting.env` wraps it for Gymnasium.

    Args:
        tablatures: What is to be fretted; each episode plays one of them, drawn at random.
        config: The task.
        n_envs: Number of environments.
        n_threads: Threads of the physics; 0 steps in the calling thread.
        plans: What the planner would do, of each tablature; for the guided task, which plans
            itself if they are not given.

    Attributes:
        task: What is seen, done and paid for.
        bank: What is to be played.
        parts: (N, R) the last rewards in their parts, see `task.Task`.

    Raises:
        RoboGuitaristError: If there is no tablature or a setting makes no sense.
    """

    def __init__(
        self,
        tablatures: Sequence[Tablature],
        config: TaskConfig | None = None,
        n_envs: int = 1,
        n_threads: int = 0,
        plans: Sequence[HandPlan] | None = None,
    ) -> None:
        if not tablatures:
            raise RoboGuitaristError("no tablature to fret (one at least)")
        self.config = config or TaskConfig()
        self.hands = HandBatch(
            self.config.scene(),
            n_envs,
            self.config.control_hz,
            n_threads,
            randomisation=self.config.randomisation,
        )
        self.task = make_task(fingered(tablatures), self.config, self.hands.model, plans)
        self.bank = self.task.bank
        self.episode, self.tick = np.zeros(n_envs, int), np.zeros(n_envs, int)
        self.played = np.zeros(n_envs, int)
        self.last_action = np.zeros((n_envs, self.n_actions))
        self.last_reward = np.zeros(n_envs)
        self.parts = np.zeros((n_envs, self.task.credit.shape[1]))
        self.rng = np.random.default_rng()

    @property
    def n_envs(self) -> int:
        """Number of environments."""
        return self.hands.n_envs

    @property
    def n_actions(self) -> int:
        """Numbers in an action."""
        return self.task.n_actions

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Rows of the observation."""
        return self.task.blocks

    @property
    def observation_size(self) -> int:
        """Numbers in an observation."""
        return sum(block.size for block in self.blocks)

    @property
    def at(self) -> Place:
        """Where each environment is: its tablature (N,) and tick (N,)."""
        return self.episode, self.tick

    def reset(self, mask: np.ndarray | None = None) -> np.ndarray:
        """Begin new episodes where `mask` (N,) is true, everywhere by default.

        Returns:
            Observations (N, observation_size) float32 of all environments.
        """
        index = np.arange(self.n_envs) if mask is None else np.flatnonzero(mask)
        self.episode[index] = self.rng.integers(len(self.bank.length), size=len(index))
        length = self.bank.length[self.episode[index]]
        begin = self.rng.integers(length) if self.config.random_start else np.zeros_like(length)
        self.tick[index], self.played[index] = begin, 0
        self.hands.put(index, self.task.start((self.episode[index], begin)))
        self.last_action[index], self.last_reward[index] = 0.0, 0.0
        return self.observe()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, Terms]:
        """Play one tick.

        Args:
            action: (N, n_actions) in [-1, 1]; what is beyond is cut.

        Returns:
            Observations (N, observation_size), rewards (N,), whether the piece has run out or
            the physics failed (N,), and the terms of the reward by name, (N,) each.
        """
        action = self.task.taken(np.minimum(np.maximum(action, -1.0), 1.0), self.last_action)
        failed = self.hands.step(self.task.ctrl(action, self.last_action, self.hands, self.at))
        parts, terms = self.task.reward(self.hands, self.at, action - self.last_action)
        parts[failed] = 0.0  # its energy may be anything
        self.parts, reward = parts, np.minimum(parts.sum(axis=1), 1.0)
        self.last_action[:], self.last_reward[:] = action, reward
        self.tick += 1
        self.played += 1
        ended = self.bank.last(self.at) | failed
        if self.config.max_ticks:
            ended |= self.played >= self.config.max_ticks
        np.minimum(self.tick, self.bank.length[self.episode] - 1, out=self.tick)
        return self.observe(), reward, ended, terms

    def state(self) -> dict[str, Any]:
        """Where all environments are, for `restore`: arrays, and the random generator as text."""
        arrays = {name: getattr(self, name).copy() for name in _KEPT}
        return {
            **arrays, "hands": self.hands.state(), "rng": json.dumps(self.rng.bit_generator.state)
        }  # fmt: skip

    def restore(self, state: Mapping[str, Any]) -> None:
        """Be where `state` was taken, with as many environments and the same tablatures."""
        for name in _KEPT:
            getattr(self, name)[:] = state[name]
        self.hands.restore(state["hands"])
        self.rng = np.random.default_rng()
        self.rng.bit_generator.state = json.loads(state["rng"])

    def follow(self, leaders: np.ndarray, mask: np.ndarray | None = None) -> None:
        """Put environments where others are.

        Args:
            leaders: (N,) whom each would follow.
            mask: (N,) bool, those that do; all by default.
        """
        index = np.arange(self.n_envs) if mask is None else np.flatnonzero(mask)
        for name in _KEPT:
            array = getattr(self, name)
            array[index] = array[leaders[index]]
        self.hands.follow(leaders[index], index)

    def observe(self) -> np.ndarray:
        """Observations (N, observation_size) float32, rows in the order of `blocks`."""
        rows = self.task.observe(self.hands, self.at, self.last_action, self.last_reward)
        return assembled(rows)


def assembled(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Rows (N, size) of an observation as one (N, observation_size) float32, cut at the limit."""
    seen = np.concatenate(rows, axis=1, dtype=np.float32)
    np.maximum(seen, -OBSERVATION_LIMIT, out=seen)
    return np.minimum(seen, OBSERVATION_LIMIT, out=seen)


def make_task(
    fingerings: Sequence[Fingering],
    config: TaskConfig,
    model: mujoco.MjModel,
    planned: Sequence[HandPlan] | None = None,
) -> PaperTask | GuidedTask:
    """The task that the settings name, over these fingerings.

    Args:
        fingerings: What is to be fretted.
        config: Settings.
        model: The left hand.
        planned: What the planner would do, for the guided task, which plans itself otherwise.

    Raises:
        RoboGuitaristError: If there is no such task.
    """
    if config.task not in TASKS:
        raise RoboGuitaristError(f"no task {config.task!r} (there are {', '.join(TASKS)})")
    bank, every = fill(fingerings, config)
    if config.task == "paper":
        return PaperTask(config, model, bank, string_goals(every, config))
    planned = planned or plans(fingerings, config)
    return GuidedTask(config, model, bank, guide(planned, bank, config))


TASKS = ("paper", "guided")
