"""The network that learners train, and the running normalisation of what it sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import nn

from roboguitarist.fretting.policy import SEEN_LIMIT, Policy, settings_of
from roboguitarist.fretting.task import TaskConfig

LEAST_DEVIATION = 0.1
"""Added to the deviation of what is observed: else numbers that hardly change become all noise."""
MOST_COUNTED = 1e6
"""Samples after which the moments forget the oldest."""


def network(seen: int, hidden: int, out: int, last_gain: float = 0.01) -> nn.Sequential:
    """Two hidden layers of ELU units, orthogonal weights."""
    layers = [nn.Linear(seen, hidden), nn.Linear(hidden, hidden), nn.Linear(hidden, out)]
    for layer, gain in zip(layers, (2**0.5, 2**0.5, last_gain), strict=True):
        nn.init.orthogonal_(layer.weight, gain)
        nn.init.zeros_(layer.bias)
    first, second, last = layers
    return nn.Sequential(first, nn.ELU(), second, nn.ELU(), last)


@dataclass
class Moments:
    """Mean and mean square (O,) of what was observed so far, and of how many samples."""

    count: float
    mean: np.ndarray
    square: np.ndarray

    @classmethod
    def of(cls, size: int) -> Moments:
        """Of nothing yet: mean 0, square 1."""
        return cls(1e-4, np.zeros(size), np.ones(size))

    def count_in(self, observations: np.ndarray) -> None:
        """Take observations (M, O) in."""
        share = len(observations) / (self.count + len(observations))
        self.mean += share * (observations.mean(axis=0, dtype=float) - self.mean)
        self.square += share * ((observations.astype(float) ** 2).mean(axis=0) - self.square)
        self.count = min(self.count + len(observations), MOST_COUNTED)

    def pair(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation (O,) float32."""
        variance = np.maximum(self.square - self.mean**2, 0.0)
        deviation = np.sqrt(variance + LEAST_DEVIATION**2)
        return self.mean.astype(np.float32), deviation.astype(np.float32)

    def normalised(self, observations: np.ndarray) -> np.ndarray:
        """Observations (N, O) float32 as a network sees them."""
        mean, deviation = self.pair()
        return np.clip((observations - mean) / deviation, -SEEN_LIMIT, SEEN_LIMIT)

    def state(self) -> dict[str, Any]:
        """As arrays and numbers."""
        return {"count": self.count, "moments": torch.tensor(np.stack([self.mean, self.square]))}

    def restore(self, state: dict[str, Any]) -> None:
        """What `state` gave."""
        self.count, (self.mean, self.square) = state["count"], state["moments"].numpy().copy()


def exported(actor: nn.Sequential, moments: Moments, config: TaskConfig) -> Policy:
    """An actor as a policy that plays without PyTorch."""
    layers = [layer for layer in actor if isinstance(layer, nn.Linear)]
    arrays = {
        f"{kind}_{index}": getattr(layer, kind).detach().numpy().copy()
        for index, layer in enumerate(layers, 1)
        for kind in ("weight", "bias")
    }
    mean, deviation = moments.pair()
    return Policy(mean, deviation, **arrays, task=config.task, hand=config.hand,
                  control_hz=config.control_hz, settings=settings_of(config))  # fmt: skip
