"""A trained network that plays, evaluated in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError

SEEN_LIMIT = 5.0
"""Normalised observations are cut here."""


@dataclass(frozen=True)
class Policy:
    """Mean action of a network with two hidden layers of ELU units.

    Attributes:
        mean, deviation: (O,) float32, of the observations in training.
        weight_1, bias_1: (H, O) and (H,) float32.
        weight_2, bias_2: (H, H) and (H,) float32.
        weight_3, bias_3: (A, H) and (A,) float32.
        task: Name of the task it was trained on.
        hand: Hand variant it was trained with.
        control_hz: Ticks per second it was trained at.
    """

    mean: np.ndarray
    deviation: np.ndarray
    weight_1: np.ndarray
    bias_1: np.ndarray
    weight_2: np.ndarray
    bias_2: np.ndarray
    weight_3: np.ndarray
    bias_3: np.ndarray
    task: str
    hand: str
    control_hz: float

    def __post_init__(self) -> None:
        """Refuse weights that do not fit each other.

        Raises:
            RoboGuitaristError: If a shape is wrong or a number is not finite.
        """
        seen, (hidden, acted) = len(self.mean), self.weight_3.shape[::-1]
        shapes = {
            "mean": (seen,), "deviation": (seen,),
            "weight_1": (hidden, seen), "bias_1": (hidden,),
            "weight_2": (hidden, hidden), "bias_2": (hidden,),
            "weight_3": (acted, hidden), "bias_3": (acted,),
        }  # fmt: skip
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array.shape != shape or not np.isfinite(array).all():
                raise RoboGuitaristError(f"policy's {name} is not {shape} finite numbers")

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Actions (N, A) float32 in [-1, 1] for observations (N, O).

        Raises:
            RoboGuitaristError: If the observations have another size than in training.
        """
        if observation.shape[-1] != len(self.mean):
            raise RoboGuitaristError(
                f"the policy sees {len(self.mean)} numbers, not {observation.shape[-1]}"
            )
        seen = np.clip((observation - self.mean) / self.deviation, -SEEN_LIMIT, SEEN_LIMIT)
        hidden = _elu(seen @ self.weight_1.T + self.bias_1)
        hidden = _elu(hidden @ self.weight_2.T + self.bias_2)
        return np.clip(hidden @ self.weight_3.T + self.bias_3, -1.0, 1.0)

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self)

    @classmethod
    def load(cls, path: str | Path) -> Policy:
        """Read what `save` wrote; nothing in the file is executed.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        return storage.load(path, cls)


def _elu(x: np.ndarray) -> np.ndarray:
    return np.where(x > 0, x, np.expm1(np.minimum(x, 0)))
