"""Hands and guitars that differ a little from each other, so that a policy relies on no detail.

After Peng et al., Sim-to-Real Transfer of Robotic Control with Dynamics Randomization (2018).
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError


@dataclass(frozen=True)
class Randomisation:
    """How far the physics of an environment may lie from the model's; the default is nowhere.

    Attributes:
        friction: Largest relative change of the friction of strings and fingers, below 1: 0.3
            draws factors from 0.7 to 1.3.
        gain: The same of every servo's stiffness and damping, each drawn by itself.
        string_height_m: Most by which the strings lie higher or lower.
        delay_s: Longest time by which new servo targets come late, less than a tick.
    """

    friction: float = 0.0
    gain: float = 0.0
    string_height_m: float = 0.0
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no model can be.

        Raises:
            RoboGuitaristError: If a range is negative or reaches 0.
        """
        if not (0 <= self.friction < 1 and 0 <= self.gain < 1):
            raise RoboGuitaristError(
                f"friction {self.friction:g}, gain {self.gain:g} (0 or more, below 1)"
            )
        if self.string_height_m < 0 or self.delay_s < 0:
            raise RoboGuitaristError(
                f"string height {self.string_height_m:g} m, delay {self.delay_s:g} s (0 or more)"
            )


def varied(
    model: mujoco.MjModel, config: Randomisation, rng: np.random.Generator
) -> mujoco.MjModel:
    """A copy of a model with friction, gains and string height drawn at random."""
    other = copy.copy(model)
    other.geom_friction[:, 0] *= 1.0 + config.friction * rng.uniform(-1, 1)
    factor = 1.0 + config.gain * rng.uniform(-1, 1, model.nu)
    other.actuator_gainprm[:, 0] *= factor
    other.actuator_biasprm[:, 1:3] *= factor[:, None]
    strings = [i for i in range(model.ngeom) if model.geom(i).name.startswith("string_")]
    other.geom_pos[strings, 2] += config.string_height_m * rng.uniform(-1, 1)
    return other


def delays(
    config: Randomisation, n_envs: int, timestep_s: float, substeps: int, rng: np.random.Generator
) -> np.ndarray:
    """Physics steps (N,) by which each environment's targets come late, evenly drawn.

    Raises:
        RoboGuitaristError: If the longest delay is a tick or more.
    """
    longest = int(config.delay_s / timestep_s + 1e-6)
    if longest >= substeps:
        raise RoboGuitaristError(
            f"delay {config.delay_s:g} s (less than a tick, {substeps * timestep_s:g} s)"
        )
    return rng.integers(longest + 1, size=n_envs)
