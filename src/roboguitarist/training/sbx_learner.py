"""The learners of sbx (Stable-Baselines3 in JAX), DroQ of the paper among them."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.learner import Progress
from roboguitarist.fretting.policy import Policy
from roboguitarist.training.sbx_export import exported
from roboguitarist.training.settings import SbxConfig

try:
    import flax.serialization
    import sbx
    from flax.training.train_state import TrainState
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.noise import NormalActionNoise
except ModuleNotFoundError as error:
    raise RoboGuitaristError("sbx is not installed (pip install 'roboguitarist[train]')") from error

from roboguitarist.fretting.sb3 import FrettingVecEnv

CHUNK_TICKS = 25
"""Ticks of each environment between two reports of a learner with a replay buffer."""
_BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


class SbxLearner:
    """One of sbx's learners as a `Learner`.

    The same seed gives the same learning, and a restored learner goes on as the unbroken one would
    have.

    Args:
        batch: The environments.
        algorithm: `droq`, `sac`, `crossq`, `tqc` or `ppo`.
        config: Settings.
    """

    def __init__(self, batch: FrettingBatch, algorithm: str, config: SbxConfig) -> None:
        self.batch, self.algorithm, self.config = batch, algorithm, config
        batch.rng = np.random.default_rng(config.seed)
        self.env = FrettingVecEnv(batch=batch)
        self.model = _model(self.env, algorithm, config)
        self._keys = {name: holder for name, holder in
                      (("model", self.model), ("policy", self.model.policy))}  # fmt: skip

    @property
    def steps(self) -> int:
        """Control ticks learned from so far."""
        return self.model.num_timesteps

    def learn(self) -> Iterator[Progress]:
        """Learn until the steps are done; one report for a rollout or a few updates."""
        ticks = self.config.rollout_ticks if self.algorithm == "ppo" else CHUNK_TICKS
        while self.steps < self.config.steps:
            begin, before, means = time.perf_counter(), self.steps, _Means()
            self.model.learn(
                ticks * self.batch.n_envs, means, log_interval=None, reset_num_timesteps=False
            )
            per_s = (self.steps - before) / (time.perf_counter() - begin)
            terms = means.values()
            logged = self.model.logger.name_to_value
            losses = {
                name.removeprefix("train/"): float(value)
                for name, value in logged.items()
                if name.startswith("train/")
            }
            yield Progress(self.steps, per_s, terms.pop("reward"), terms, losses)

    def policy(self) -> Policy:
        """The actor as it is now, for playing."""
        return exported(self.model.policy.actor_state, self.algorithm, self.batch.config)

    def state(self) -> dict[str, Any]:
        """Weights, optimisers, replay buffer, counters, random generators, environments."""
        model = self.model
        networks = {name: _plain(flax.serialization.to_state_dict(state))
                    for name, _, state in self._networks()}  # fmt: skip
        legacy = np.random.get_state(legacy=False)  # noqa: NPY002 - Stable-Baselines3 draws there
        return {
            "networks": networks,
            "keys": {
                name: np.asarray(getattr(holder, key)) for name, holder, key in self._randoms()
            },
            "numpy": json.dumps(_plain(legacy), default=np.ndarray.tolist),
            "space": json.dumps(self.model.action_space.np_random.bit_generator.state),
            "counters": {name: int(getattr(model, name)) for name in _COUNTERS},
            "seen": None if model._last_obs is None else np.asarray(model._last_obs),
            "begin": _optional(getattr(model, "_last_episode_starts", None)),
            "buffer": self._buffer_state(),
            "batch": self.batch.state(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from what `state` gave."""
        model = self.model
        for name, holder, network in list(self._networks()):
            arrays = _arrays(state["networks"][name])
            restored = flax.serialization.from_state_dict(network, arrays)
            setattr(holder, name.partition("/")[2], restored)
        for name, holder, key in self._randoms():
            setattr(holder, key, np.asarray(state["keys"][name]))
        legacy = json.loads(state["numpy"])
        legacy["state"]["key"] = np.array(legacy["state"]["key"], np.uint32)
        np.random.set_state(legacy)  # noqa: NPY002
        model.action_space.np_random.bit_generator.state = json.loads(state["space"])
        for name, value in state["counters"].items():
            setattr(model, name, value)
        model._last_obs = _optional(state["seen"])
        model._last_episode_starts = _optional(state["begin"])
        self._restore_buffer(state["buffer"])
        self.batch.restore(state["batch"])

    def _networks(self) -> Iterator[tuple[str, Any, TrainState]]:
        """Every network with its optimiser: path, holder, state."""
        for name, holder in self._keys.items():
            for attribute, value in vars(holder).items():
                if isinstance(value, TrainState):
                    yield f"{name}/{attribute}", holder, value

    def _randoms(self) -> Iterator[tuple[str, Any, str]]:
        for name, holder in self._keys.items():
            for key in ("key", "noise_key"):
                if hasattr(holder, key):
                    yield f"{name}/{key}", holder, key

    def _buffer_state(self) -> dict[str, Any] | None:
        buffer = getattr(self.model, "replay_buffer", None)
        if buffer is None:
            return None
        filled = buffer.buffer_size if buffer.full else buffer.pos
        arrays = {name: getattr(buffer, name)[:filled] for name in _BUFFER}
        return {**arrays, "pos": buffer.pos, "full": buffer.full}

    def _restore_buffer(self, state: Mapping[str, Any] | None) -> None:
        if state is None:
            return
        buffer = self.model.replay_buffer
        for name in _BUFFER:
            getattr(buffer, name)[: len(state[name])] = state[name]
        buffer.pos, buffer.full = state["pos"], state["full"]


_COUNTERS = ("num_timesteps", "_n_updates", "_episode_num", "_num_timesteps_at_start")


class _Means(BaseCallback):
    """Means of the reward and its terms over what was played."""

    def __init__(self) -> None:
        super().__init__()
        self.sums: dict[str, float] = {}
        self.count = 0

    def _on_step(self) -> bool:
        self.count += 1
        infos = self.locals["infos"]
        values = {name: np.mean([info[name] for info in infos])
                  for name, value in infos[0].items() if isinstance(value, float)}  # fmt: skip
        values["reward"] = np.mean(self.locals["rewards"])
        for name, value in values.items():
            self.sums[name] = self.sums.get(name, 0.0) + float(value)
        return True

    def values(self) -> dict[str, float]:
        return {name: value / max(self.count, 1) for name, value in self.sums.items()}


def _model(env: FrettingVecEnv, algorithm: str, config: SbxConfig) -> Any:
    usual: dict[str, Any] = {
        "policy": "MlpPolicy", "env": env, "learning_rate": config.learning_rate,
        "gamma": config.discount, "batch_size": config.batch_size, "seed": config.seed,
    }  # fmt: skip
    arch: dict[str, Any] = {"net_arch": [config.hidden, config.hidden]}
    if algorithm == "ppo":
        return sbx.PPO(n_steps=config.rollout_ticks, policy_kwargs=arch, **usual)
    acted = env.action_space.shape
    assert acted is not None
    noise = NormalActionNoise(np.zeros(acted), np.full(acted, config.noise))
    usual |= {
        "buffer_size": config.buffer_size, "learning_starts": config.learning_starts,
        "gradient_steps": config.gradient_steps, "action_noise": noise if config.noise else None,
    }  # fmt: skip
    if algorithm == "droq":  # in sbx, SAC with these two in its critic
        arch |= {"dropout_rate": config.dropout_rate, "layer_norm": True}
    kinds = {"droq": sbx.SAC, "sac": sbx.SAC, "crossq": sbx.CrossQ, "tqc": sbx.TQC}
    return kinds[algorithm](policy_kwargs=arch, **usual)


def _plain(item: Any) -> Any:
    """JAX's arrays as NumPy's, in nested dictionaries."""
    if isinstance(item, Mapping):
        return {str(key): _plain(value) for key, value in item.items()}
    return item if isinstance(item, (int, float, str)) else np.asarray(item)


def _arrays(item: Any) -> Any:
    """Tensors as NumPy's arrays, in nested dictionaries."""
    if isinstance(item, Mapping):
        return {key: _arrays(value) for key, value in item.items()}
    return item if isinstance(item, (int, float, str)) else np.asarray(item)


def _optional(item: Any) -> np.ndarray | None:
    return None if item is None else np.asarray(item).copy()
