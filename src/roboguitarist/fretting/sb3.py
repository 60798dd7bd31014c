"""The fretting environments for Stable-Baselines3 and what builds on it (extra `train`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.env import Score, spaces, tablatures, task
from roboguitarist.fretting.episodes import FrettingBatch

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise RoboGuitaristError(
        "Stable-Baselines3 is not installed (pip install 'roboguitarist[train]')"
    ) from error


class FrettingVecEnv(VecEnv):
    """Many left hands as one Stable-Baselines3 `VecEnv`.

    An environment whose episode ends begins the next in the same step: the observation returned
    is the new one, the last one is `terminal_observation` in its info. The reward's terms are in
    every info. Episodes are only ever truncated, which `TimeLimit.truncated` says.

    Args:
        num_envs: Number of hands.
        score: As for `FrettingEnv`; each episode draws one of the tablatures.
        n_threads: Threads of the physics; 0 steps in the calling thread.
        batch: The hands, if they are made already; then nothing else need be said.
        settings: Those of `TaskConfig`, by name.

    Raises:
        RoboGuitaristError: If a score cannot be used or there is no such setting.
    """

    def __init__(
        self,
        num_envs: int = 1,
        score: Score | Sequence[Score] = "twinkle",
        n_threads: int = 0,
        batch: FrettingBatch | None = None,
        **settings: Any,
    ) -> None:
        self.batch = batch or FrettingBatch(
            tablatures(score), task(**settings), num_envs, n_threads
        )
        self.render_mode = None
        super().__init__(self.batch.n_envs, *spaces(self.batch))
        self._actions = np.zeros((self.num_envs, self.batch.n_actions), np.float32)

    def reset(self) -> np.ndarray:
        """Begin an episode everywhere."""
        seed = self._seeds[0]
        if seed is not None:
            self.batch.rng = np.random.default_rng(seed)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self.batch.reset()

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play one control tick."""
        seen, reward, ended, terms = self.batch.step(self._actions)
        infos = [
            {name: float(values[index]) for name, values in terms.items()}
            for index in range(self.num_envs)
        ]
        if ended.any():
            for index in np.flatnonzero(ended):
                infos[index]["TimeLimit.truncated"] = True
                infos[index]["terminal_observation"] = seen[index]
            seen = self.batch.reset(ended)
        return seen, reward.astype(np.float32), ended, infos

    def close(self) -> None:
        """Stop the physics."""
        self.batch.hands.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same attribute for each of the environments asked for: they share everything."""
        return [getattr(self, attr_name)] * len(self._chosen(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all environments; they share everything."""
        if len(self._chosen(indices)) != self.num_envs:
            raise RoboGuitaristError(f"{attr_name} can only be set for all environments at once")
        setattr(self, attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any
    ) -> list[Any]:
        """Call a method once; its result for each of the environments asked for."""
        result = getattr(self, method_name)(*args, **kwargs)
        return [result] * len(self._chosen(indices))

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Nothing is wrapped."""
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices: int | Iterable[int] | None) -> list[int]:
        return list(self._get_indices(indices))
