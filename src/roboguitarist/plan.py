"""Where a hand is to be: the servo targets of one hand over a whole piece."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from roboguitarist import storage

PLAN_HZ = 240.0
"""Samples per second of a plan."""
SERVO_DELAY_S = 0.004
"""How much later than planned a fingertip passes a point, as measured over many strokes."""
LEAD_IN_S = 1.0
"""Time before the first onset in which the hands take their places."""


@dataclass(frozen=True)
class HandPlan:
    """The planned motion of one hand, sampled at `PLAN_HZ`.

    Attributes:
        time_s: (T,) time from the start of the piece; begins with -`LEAD_IN_S`.
        qpos: (T, nq) joint path of this hand alone, in rad and m.
        ctrl: (T, nu) servo targets of this hand alone, in rad and m.
        grip: (T, 4) from 0 for a left finger in the air to 1 for one that is down; (0, 4) for
            the right hand.
    """

    time_s: np.ndarray
    qpos: np.ndarray
    ctrl: np.ndarray
    grip: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self)

    @classmethod
    def load(cls, path: str | Path) -> HandPlan:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        return storage.load(path, cls)


def plan_times(duration_s: float, tail_s: float = 1.0) -> np.ndarray:
    """Sample times of a plan for a piece of that length, in seconds."""
    return np.arange(-LEAD_IN_S, duration_s + tail_s, 1.0 / PLAN_HZ)
