"""A trained network that plays, evaluated in NumPy."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.task import TaskConfig

SEEN_LIMIT = 5.0
"""Normalised observations are cut here."""


@dataclass(frozen=True)
class Policy:
    """Mean action of a network with two hidden layers.

    Attributes:
        mean, deviation: (O,) float32, of the observations in training.
        weight_1, bias_1: (H, O) and (H,) float32.
        weight_2, bias_2: (H, H) and (H,) float32.
        weight_3, bias_3: (A, H) and (A,) float32.
        task: Name of the task it was trained on.
        hand: Hand variant it was trained with.
        control_hz: Ticks per second it was trained at.
        activation: What the hidden units do: `elu`, `relu` or `tanh`.
        squashed: The last layer's output goes through tanh too, instead of being cut.
        settings: The task's other settings as a JSON object, see `task_config`.
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
    activation: str = "elu"
    squashed: bool = False
    settings: str = "{}"

    def __post_init__(self) -> None:
        """Refuse weights that do not fit each other.

        Raises:
            RoboGuitaristError: If a shape is wrong, a number is not finite, or there is no such
                activation.
        """
        if self.activation not in _ACTIVATIONS:
            raise RoboGuitaristError(
                f"no activation {self.activation!r} (there are {', '.join(_ACTIVATIONS)})"
            )
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
        activation = _ACTIVATIONS[self.activation]
        hidden = activation(seen @ self.weight_1.T + self.bias_1)
        hidden = activation(hidden @ self.weight_2.T + self.bias_2)
        out = hidden @ self.weight_3.T + self.bias_3
        return np.tanh(out) if self.squashed else np.clip(out, -1.0, 1.0)

    def task_config(self) -> TaskConfig:
        """The task it was trained on.

        Raises:
            RoboGuitaristError: If the settings are not those of a task.
        """
        try:
            settings = json.loads(self.settings)
            named = {"task": self.task, "hand": self.hand, "control_hz": self.control_hz}
            return TaskConfig(**{**settings, **named})
        except (TypeError, ValueError) as error:
            raise RoboGuitaristError(f"policy's settings are not a task's ({error})") from error

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


def settings_of(config: TaskConfig) -> str:
    """What `Policy.settings` says of a task."""
    return json.dumps(asdict(config), sort_keys=True)


def _elu(x: np.ndarray) -> np.ndarray:
    return np.where(x > 0, x, np.expm1(np.minimum(x, 0)))


def _relu(x: np.ndarray) -> np.ndarray:
    return np.maximum(x, 0)


_ACTIVATIONS = {"elu": _elu, "relu": _relu, "tanh": np.tanh}
