"""The paper's fretting task as Gymnasium environments, one hand or many at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from roboguitarist import formats, pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.episodes import OBSERVATION_LIMIT, FrettingBatch
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Tablature

Score = Tablature | str


class FrettingEnv(gym.Env[np.ndarray, np.ndarray]):
    """One left hand that frets tablatures: the batch of one.

    An action is 20 numbers in [-1, 1] for the servo targets of table 4 of the paper. The
    observation's rows are listed in the documentation (`docs/environment.md`). The reward is
    that of equation 4, its terms are in `info`. An episode is `truncated` where the piece ends.

    Args:
        score: A tablature, a score file, the name of a piece, or a sequence of these.
        settings: Those of `TaskConfig`, by name.

    Raises:
        RoboGuitaristError: If a score cannot be used or there is no such setting.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(self, score: Score | Sequence[Score] = "twinkle", **settings: Any) -> None:
        self.batch = FrettingBatch(tablatures(score), task(**settings))
        self.observation_space, self.action_space = spaces(self.batch)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; a seed makes all that follow repeatable."""
        super().reset(seed=seed)
        if seed is not None:
            self.batch.rng = np.random.default_rng(seed)
        return self.batch.reset()[0], {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Play one control tick."""
        seen, reward, ended, terms = self.batch.step(np.asarray(action)[None])
        info = {name: float(values[0]) for name, values in terms.items()}
        return seen[0], float(reward[0]), False, bool(ended[0]), info

    def close(self) -> None:
        """Stop the physics."""
        self.batch.hands.close()


class FrettingVectorEnv(VectorEnv):
    """Many left hands that fret tablatures, stepped together by all cores.

    An environment whose episode has ended begins a new one in the next step, as Gymnasium's
    vector environments do by default.

    Args:
        num_envs: Number of hands.
        score: As for `FrettingEnv`; each episode draws one of the tablatures.
        n_threads: Threads of the physics; 0 steps in the calling thread.
        settings: Those of `TaskConfig`, by name.

    Raises:
        RoboGuitaristError: If a score cannot be used or there is no such setting.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        score: Score | Sequence[Score] = "twinkle",
        n_threads: int = 0,
        **settings: Any,
    ) -> None:
        self.num_envs = num_envs
        self.batch = FrettingBatch(tablatures(score), task(**settings), num_envs, n_threads)
        self.single_observation_space, self.single_action_space = spaces(self.batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode everywhere; a seed or a list of them makes what follows repeatable."""
        if seed is not None:
            self.batch.rng = np.random.default_rng(seed)
        self._ended[:] = False
        return self.batch.reset(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Play one control tick; where the last one ended an episode, begin the next."""
        begin = self._ended.copy()
        seen, reward, ended, terms = self.batch.step(actions)
        if begin.any():
            seen = self.batch.reset(begin)
            reward, ended = np.where(begin, 0.0, reward), ended & ~begin
        self._ended = ended
        return seen, reward, np.zeros(self.num_envs, bool), ended, dict(terms)

    def close_extras(self, **kwargs: Any) -> None:
        """Stop the physics."""
        self.batch.hands.close()


def tablatures(score: Score | Sequence[Score]) -> list[Tablature]:
    """The tablatures of a score or several: tablatures, files or names of pieces.

    Raises:
        RoboGuitaristError: If one cannot be used.
    """
    several = [score] if isinstance(score, (str, Tablature)) else list(score)
    return [one if isinstance(one, Tablature) else _load(one) for one in several]


def _load(score: str) -> Tablature:
    return formats.load(pieces.path(score) if score in pieces.names() else score)


def task(**settings: Any) -> TaskConfig:
    """Task with these settings.

    Raises:
        RoboGuitaristError: If there is no such setting; the message lists the names.
    """
    names = [field.name for field in fields(TaskConfig)]
    unknown = sorted(set(settings) - set(names))
    if unknown:
        raise RoboGuitaristError(f"no setting {unknown[0]!r} (there are {', '.join(names)})")
    return TaskConfig(**settings)


def spaces(batch: FrettingBatch) -> tuple[gym.spaces.Box, gym.spaces.Box]:
    """Observation and action space of one environment of a batch."""
    seen = gym.spaces.Box(
        -OBSERVATION_LIMIT, OBSERVATION_LIMIT, (batch.observation_size,), np.float32
    )
    return seen, gym.spaces.Box(-1.0, 1.0, (batch.n_actions,), np.float32)
