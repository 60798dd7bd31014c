"""The paper's task: what an agent sees, does and is paid for when it frets a tablature.

After sections 5 and 7.1, tables 1, 2 and 4 of Luo et al., Learning to Play Guitar with Robotic
Hands (2024).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.rewards import ENERGY_COEFFICIENT, Kind
from roboguitarist.guitar import Guitar, preset
from roboguitarist.hands import Variant
from roboguitarist.scene import SceneConfig

StringGoal = Literal["simplified", "one_hot"]


@dataclass(frozen=True)
class TaskConfig:
    """Settings of the task; the defaults are the paper's.

    Attributes:
        hand: Hand variant; the paper's is `tendon`.
        guitar: Name of a guitar preset.
        control_hz: Frame rate, ticks per second; the paper compares 10, 20 and 30.
        substeps: Physics steps in a tick.
        n_step_lookahead: Ticks ahead that the observation's string goal covers.
        string_goal: `simplified`: the fret wanted on each string; `one_hot`: 0 or 1 for each key.
        mapping: Form of the function g that turns distances into rewards.
        freedom: Lower frets on a string whose wanted fret is held are no mistakes.
        euclidean: The plain distance to the key as finger reward, for the ablation.
        energy_coefficient: k of equation 3.
        random_start: Episodes begin anywhere in the piece, else at its beginning.
        lead_s: Time before the first onset in which the hand gets ready.
    """

    hand: Variant = "linkage"
    guitar: str = "classical"
    control_hz: float = 30.0
    substeps: int = 10
    n_step_lookahead: int = 1
    string_goal: StringGoal = "simplified"
    mapping: Kind = "reciprocal"
    freedom: bool = False
    euclidean: bool = False
    energy_coefficient: float = ENERGY_COEFFICIENT
    random_start: bool = False
    lead_s: float = 0.5

    def scene(self) -> SceneConfig:
        """The scene of the task: the left hand alone.

        Raises:
            RoboGuitaristError: If a setting is out of range or names something that there is not.
        """
        if not (self.control_hz > 0 and self.substeps >= 1 and self.n_step_lookahead >= 0):
            raise RoboGuitaristError(
                f"{self.control_hz:g} Hz, {self.substeps} substeps, lookahead"
                f" {self.n_step_lookahead} (above 0, from 1, from 0)"
            )
        step_s = 1.0 / (self.control_hz * self.substeps)
        return SceneConfig(preset(self.guitar), self.hand, ("left",), step_s, visuals=False)


# Table 4. Its forearm ranges are in the frame of the paper's code; here they keep their widths
# and lie around the place from which the hand plays.
_FINGER_LIMITS = {"J4": (-0.35, 0.35), "J3": (0.0, 1.57), "J0": (0.0, 2.0)}
ACTION_LIMITS: dict[str, tuple[float, float]] = {
    "forearm_x": (-0.04, 0.28),
    "forearm_y": (-0.03, 0.08),
    "forearm_z": (-0.07, 0.05),
    "WRJ2": (0.0, 0.0),
    "WRJ1": (0.0, 0.79),
    **{f"{f}{j}": pair for f in ("FF", "MF", "RF", "LF") for j, pair in _FINGER_LIMITS.items()},
    "THJ4": (0.0, 0.0),
    "THJ3": (0.0, 0.0),
    "THJ2": (0.0, 0.0),
}
"""The 20 servo targets of an action, in m and rad; where both ends are 0 nothing moves."""


class Actions:
    """Turns actions in [-1, 1] into servo targets.

    Args:
        model: The left hand.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        servos = [model.actuator(f"lh_A_{name}").id for name in ACTION_LIMITS]
        low, high = np.array(list(ACTION_LIMITS.values())).T
        # A wrist that the paper bends further than the hand's servo goes ends at its limit.
        self.low, self.high = np.clip((low, high), *model.actuator_ctrlrange[servos].T)
        self._servos, self._nu = np.array(servos), model.nu

    @property
    def size(self) -> int:
        """Numbers in an action."""
        return len(self._servos)

    def ctrl(self, action: np.ndarray) -> np.ndarray:
        """Servo targets (N, nu) in rad and m of actions (N, size); values beyond 1 are cut."""
        share = (np.clip(action, -1.0, 1.0) + 1.0) / 2.0
        out = np.zeros((len(action), self._nu))
        out[:, self._servos] = self.low + share * (self.high - self.low)
        return out


@dataclass(frozen=True)
class Block:
    """One row of the observation: where it is, what it is, and in which unit."""

    name: str
    size: int
    unit: str
    meaning: str


def observation_blocks(
    config: TaskConfig, model: mujoco.MjModel, guitar: Guitar, n_actions: int
) -> tuple[Block, ...]:
    """The rows of the observation in their order, as table 1 has them."""
    ahead = config.n_step_lookahead + 1
    keys = 6 * guitar.n_frets
    goal = (
        Block("string_goal", 6 * ahead, "fret / frets", "wanted fret on each string, 0 for none")
        if config.string_goal == "simplified"
        else Block("string_goal", keys * ahead, "0 or 1", "wanted keys, string by string")
    )
    return (
        Block("joints", model.nq - 3, "share of range", "hand joint positions"),
        Block("forearm", 3, "share of range", "forearm positions"),
        Block("keys", keys, "0 or 1", "keys pressed with at least the threshold"),
        Block("last_action", n_actions, "-1 to 1", "the action before"),
        Block("last_reward", 1, "1", "the reward before"),
        Block("fingers", 12, "0.1 m", "from each fingertip to its key, 0 for an idle finger"),
        Block("busy", 4, "0 or 1", "which fingers have a key"),
        goal,
    )
