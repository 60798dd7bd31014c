"""Settings of a fretting task, and what every task can say and do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.randomisation import Randomisation
from roboguitarist.fretting.rewards import ENERGY_COEFFICIENT, Kind
from roboguitarist.guitar import preset
from roboguitarist.hands import Variant
from roboguitarist.scene import SceneConfig
from roboguitarist.sensing import Stops

TaskName = Literal["paper", "guided"]
StringGoal = Literal["simplified", "one_hot"]
Terms = dict[str, np.ndarray]
Place = tuple[np.ndarray, np.ndarray]
"""Where N environments are: which tablature (N,), and which of its ticks (N,)."""


@dataclass(frozen=True)
class TaskConfig:
    """Settings of the task; the defaults are the paper's.

    Attributes:
        task: `paper`: servo targets as actions, the paper's observation and reward. `guided`: an
            action corrects the planner's targets, the observation is relative to the hand, the
            reward says what would be heard.
        hand: Hand variant; the paper's is `tendon`.
        guitar: Name of a guitar preset.
        control_hz: Frame rate, ticks per second; the paper compares 10, 20 and 30.
        substeps: Physics steps in a tick.
        random_start: Episodes begin anywhere in the piece, else at its beginning.
        lead_s: Time before the first onset in which the hand gets ready.
        max_ticks: Episodes end after that many ticks, 0: at the end of the piece.
        n_step_lookahead: Ticks ahead that the observation's string goal covers (`paper`).
        string_goal: `simplified`: the fret wanted on each string; `one_hot`: 0 or 1 for each key
            (`paper`).
        full_state: The velocities of table 1's state are observed too (`paper`).
        normalisation: Joints are observed as shares of their ranges, else in rad and m (`paper`).
        mapping: Form of the function g that turns distances into rewards.
        freedom: Lower frets on a string whose wanted fret is held are no mistakes (`paper`).
        euclidean: The plain distance to the key as finger reward, for the ablation (`paper`).
        energy_coefficient: k of equation 3 (`paper`).
        vary_friction: Largest relative change of friction from hand to hand, see
            `randomisation.Randomisation`.
        vary_gain: The same of each servo's gain.
        vary_string_height_m: Most by which the strings lie higher or lower.
        vary_delay_s: Longest time by which servo targets come late.
    """

    task: TaskName = "paper"
    hand: Variant = "linkage"
    guitar: str = "classical"
    control_hz: float = 30.0
    substeps: int = 10
    random_start: bool = False
    lead_s: float = 0.5
    max_ticks: int = 0
    n_step_lookahead: int = 1
    string_goal: StringGoal = "simplified"
    full_state: bool = False
    normalisation: bool = True
    mapping: Kind = "reciprocal"
    freedom: bool = False
    euclidean: bool = False
    energy_coefficient: float = ENERGY_COEFFICIENT
    vary_friction: float = 0.0
    vary_gain: float = 0.0
    vary_string_height_m: float = 0.0
    vary_delay_s: float = 0.0

    @property
    def randomisation(self) -> Randomisation:
        """How the hands differ.

        Raises:
            RoboGuitaristError: If no model can differ so.
        """
        return Randomisation(
            self.vary_friction, self.vary_gain, self.vary_string_height_m, self.vary_delay_s
        )

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


@dataclass(frozen=True)
class Block:
    """One row of the observation: where it is, what it is, and in which unit."""

    name: str
    size: int
    unit: str
    meaning: str


class Hands(Protocol):
    """What a task reads of N hands, see `batch.HandBatch`."""

    @property
    def qpos(self) -> np.ndarray:
        """(N, nq) joint positions in rad and m."""
        ...

    @property
    def qvel(self) -> np.ndarray:
        """(N, nv) joint velocities in rad/s and m/s."""
        ...

    @property
    def tip_m(self) -> np.ndarray:
        """(N, 4, 3) centres of the fingertips of fingers 1 to 4."""
        ...

    def press_force_n(self) -> np.ndarray:
        """(N, 6, F) normal force in each fret space."""
        ...

    def sounding_fret(self, capo: int = 0) -> np.ndarray:
        """(N, 6) fret that each string would sound."""
        ...

    def over_tick(self) -> Stops:
        """How the strings were stopped during the last tick, see `batch.HandBatch.over_tick`."""
        ...

    def power_w(self) -> np.ndarray:
        """(N,) absolute mechanical power over the last tick."""
        ...


class Task(Protocol):
    """What an agent sees, does and is paid for."""

    blocks: tuple[Block, ...]
    n_actions: int
    groups: np.ndarray
    """(A,) group from 0 to G - 1 of each number of the action: those that move one finger."""
    credit: np.ndarray
    """(G, R) how much each part of the reward is owed to each group."""

    def ctrl(
        self, action: np.ndarray, last_action: np.ndarray, hands: Hands, at: Place
    ) -> np.ndarray:
        """Servo targets (N, nu), or (N, k, nu) in k parts of the tick, of actions (N, A)."""
        ...

    def taken(self, action: np.ndarray, last_action: np.ndarray) -> np.ndarray:
        """The actions (N, A) that the hands take, of those asked for and those taken before."""
        ...

    def observe(
        self, hands: Hands, at: Place, last_action: np.ndarray, last_reward: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """The rows of the observation, (N, size) each, in the order of `blocks`."""
        ...

    def reward(self, hands: Hands, at: Place, change: np.ndarray) -> tuple[np.ndarray, Terms]:
        """Rewards in parts (N, R), whose sum counts, and their terms.

        Args:
            hands: The hands at the end of a tick.
            at: Where they were at its beginning.
            change: (N, A) of the action.
        """
        ...

    def start(self, at: Place) -> np.ndarray:
        """Postures (N, nq) in which episodes begin."""
        ...

    def resting_action(self) -> np.ndarray:
        """(A,) float32, the action that keeps the hand about where episodes begin."""
        ...
