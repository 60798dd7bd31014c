"""The actors of sbx as a `Policy`, whose arrays need neither JAX nor sbx."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from roboguitarist.fretting.policy import Policy, settings_of
from roboguitarist.fretting.task import TaskConfig

BATCH_NORM_EPSILON = 1e-3
"""What sbx's batch renormalisation adds to variances."""


def exported(actor: Any, algorithm: str, config: TaskConfig) -> Policy:
    """The mean action of an actor with two hidden layers.

    Batch normalisation, which CrossQ has before and after each layer, is linear when playing, so it
    goes into the weights that follow it.

    Args:
        actor: The actor's `TrainState`.
        algorithm: Which learner it is from: `ppo` has tanh units and cuts its actions, the others
            have relu units and squash them.
        config: The task.
    """
    tree = {name: {key: np.asarray(value, np.float32) for key, value in layer.items()}
            for name, layer in _layers(actor).items()}  # fmt: skip
    layers = [(tree[f"Dense_{k}"]["kernel"].T, tree[f"Dense_{k}"]["bias"]) for k in range(3)]
    for index in range(3):
        norm = tree.get(f"BatchRenorm_{index}")
        if norm is not None:
            layers[index] = _after(norm, *layers[index])
    arrays = {f"{kind}_{index}": np.ascontiguousarray(array, np.float32)
              for index, pair in enumerate(layers, 1)
              for kind, array in zip(("weight", "bias"), pair, strict=True)}  # fmt: skip
    seen = arrays["weight_1"].shape[1]
    ppo = algorithm == "ppo"
    return Policy(
        np.zeros(seen, np.float32), np.ones(seen, np.float32), **arrays, task=config.task,
        hand=config.hand, control_hz=config.control_hz, activation="tanh" if ppo else "relu",
        squashed=not ppo, settings=settings_of(config),
    )  # fmt: skip


def _layers(actor: Any) -> dict[str, dict[str, Any]]:
    """Parameters and running statistics of each layer by its name."""
    params = actor.params.get("params", actor.params)
    statistics = getattr(actor, "batch_stats", {})
    return {
        name: {**layer, **statistics.get(name, {})}
        for name, layer in params.items()
        if isinstance(layer, Mapping)
    }


def _after(
    norm: Mapping[str, np.ndarray], weight: np.ndarray, bias: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A layer (weight (H, O), bias (H,)) that does the normalisation before it as well."""
    scale = norm["scale"] / np.sqrt(norm["var"] + BATCH_NORM_EPSILON)
    return weight * scale, bias + weight @ (norm["bias"] - norm["mean"] * scale)
