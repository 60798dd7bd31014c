"""The paper's task: what an agent sees, does and is paid for when it frets a tablature.

After sections 5 and 7.1, tables 1, 2 and 4 of Luo et al., Learning to Play Guitar with Robotic
Hands (2024).
"""

from __future__ import annotations

import mujoco
import numpy as np

from roboguitarist.fretting import rewards
from roboguitarist.fretting.bank import Bank
from roboguitarist.fretting.posture import POSTURES, rest_path, solver
from roboguitarist.fretting.presses import tip_height
from roboguitarist.fretting.task import Block, Hands, Place, TaskConfig, Terms
from roboguitarist.guitar import Guitar
from roboguitarist.sensing import PRESS_THRESHOLD_N
from roboguitarist.servo import actuator_moment

READY_M = 0.02
"""Height over the strings at which fingertips begin an episode."""
VELOCITY_S = 0.1
"""Velocities are observed as what they cover in this time."""
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

    def of(self, ctrl: np.ndarray) -> np.ndarray:
        """The actions (N, size) in [-1, 1] nearest to servo targets (N, nu); 0 where none moves."""
        width = self.high - self.low
        share = (ctrl[:, self._servos] - self.low) / np.where(width > 0, width, 1.0)
        return np.where(width > 0, np.clip(2.0 * share - 1.0, -1.0, 1.0), 0.0)

    @property
    def size(self) -> int:
        """Numbers in an action."""
        return len(self._servos)

    def ctrl(self, action: np.ndarray) -> np.ndarray:
        """Servo targets (N, nu) in rad and m of actions (N, size); values beyond 1 are cut."""
        share = (np.minimum(np.maximum(action, -1.0), 1.0) + 1.0) / 2.0
        out = np.zeros((len(action), self._nu))
        out[:, self._servos] = self.low + share * (self.high - self.low)
        return out


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
    share = "share of range" if config.normalisation else "rad"
    length = share if config.normalisation else "m"
    velocities = (
        Block("joint_velocities", model.nv - 3, f"{share} / 0.1 s", "hand joint velocities"),
        Block("forearm_velocities", 3, f"{length} / 0.1 s", "forearm velocities"),
    )
    return (
        Block("joints", model.nq - 3, share, "hand joint positions"),
        Block("forearm", 3, length, "forearm positions"),
        *(velocities if config.full_state else ()),
        Block("keys", keys, "0 or 1", "keys pressed with at least the threshold"),
        Block("last_action", n_actions, "-1 to 1", "the action before"),
        Block("last_reward", 1, "1", "the reward before"),
        Block("fingers", 12, "0.1 m", "from each fingertip to its key, 0 for an idle finger"),
        Block("busy", 4, "0 or 1", "which fingers have a key"),
        goal,
    )


class PaperTask:
    """The task of the paper.

    Args:
        config: Its settings.
        model: The left hand.
        bank: What is to be played.
        string_goal: (K, T, size) goals of the strings, see `bank.string_goals`.
    """

    def __init__(
        self, config: TaskConfig, model: mujoco.MjModel, bank: Bank, string_goal: np.ndarray
    ) -> None:
        self.config, self.bank, self.string_goal = config, bank, string_goal
        self.actions = Actions(model)
        self.n_actions = self.actions.size
        self.groups, self.credit = np.zeros(self.n_actions, int), np.ones((1, 1))
        self.blocks = observation_blocks(config, model, config.scene().guitar, self.n_actions)
        self._low, self._width = model.jnt_range[:, 0], np.ptp(model.jnt_range, axis=1)
        self._starts, self._moment = _starts(config), actuator_moment(model)

    def ctrl(
        self, action: np.ndarray, last_action: np.ndarray, hands: Hands, at: Place
    ) -> np.ndarray:
        """Servo targets (N, nu) of actions (N, 20)."""
        return self.actions.ctrl(action)

    def taken(self, action: np.ndarray, last_action: np.ndarray) -> np.ndarray:
        """As asked for."""
        return action

    def start(self, at: Place) -> np.ndarray:
        """At rest over the strings, where the fingering holds the hand."""
        hold = self.bank.hold_position[at]
        return self._starts[np.clip(hold, 1, len(self._starts)) - 1]

    def resting_ctrl(self, at: Place) -> np.ndarray:
        """Servo targets (N, nu) that keep the hand where episodes begin, gravity being balanced."""
        return self.start(at) @ self._moment.T

    def resting_action(self) -> np.ndarray:
        """(A,) float32, in the mean over the beginnings of the tablatures."""
        first = np.arange(len(self.bank.length)), np.zeros(len(self.bank.length), int)
        return self.actions.of(self.resting_ctrl(first)).mean(axis=0).astype(np.float32)

    def observe(
        self, hands: Hands, at: Place, last_action: np.ndarray, last_reward: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """Rows of table 1."""
        n_envs, qpos, qvel = len(last_action), hands.qpos, hands.qvel
        if self.config.normalisation:
            qpos, qvel = 2.0 * (qpos - self._low) / self._width - 1.0, 2.0 * qvel / self._width
        active = self.bank.active[at]
        to_key = np.where(active[..., None], self.bank.key_m[at] - hands.tip_m, 0.0)
        velocities = (VELOCITY_S * qvel[:, 3:], VELOCITY_S * qvel[:, :3])
        return (
            qpos[:, 3:],
            qpos[:, :3],
            *(velocities if self.config.full_state else ()),
            (hands.press_force_n() >= PRESS_THRESHOLD_N).reshape(n_envs, -1),
            last_action,
            last_reward[:, None],
            to_key.reshape(n_envs, -1) / 0.1,
            active,
            self.string_goal[at],
        )

    def reward(self, hands: Hands, at: Place, change: np.ndarray) -> tuple[np.ndarray, Terms]:
        """Equation 4, in one part, and its terms."""
        config, bank = self.config, self.bank
        fret, active = bank.fret[at], bank.active[at]
        tips, keys = hands.tip_m, bank.key_m[at]
        near = (
            rewards.euclidean_finger_reward(tips, keys, active, config.mapping)
            if config.euclidean
            else rewards.finger_reward(tips, keys, bank.key_length_m[at], active, config.mapping)
        )
        terms = {
            "key": rewards.key_reward(
                hands.press_force_n(), fret, config.freedom, PRESS_THRESHOLD_N, config.mapping
            ),
            "finger": near,
            "energy": rewards.energy(
                hands.power_w(), np.any(fret > 0, axis=1), config.energy_coefficient
            ),
        }
        total = rewards.total(terms["key"], terms["finger"], terms["energy"])
        return total[:, None], terms


def _starts(config: TaskConfig) -> np.ndarray:
    """Postures (H, nq) at rest over hold positions 1 to H."""
    scene, posture = config.scene(), POSTURES[config.hand]
    hold = np.arange(1, scene.guitar.n_frets - 3)
    fret = hold[:, None] + np.arange(4)
    x = (scene.guitar.fret_x(fret - 1) + scene.guitar.fret_x(fret)) / 2
    y, z = np.zeros_like(x), np.full_like(x, tip_height(scene.guitar) + READY_M)
    tips = np.stack([x, y, z], axis=-1)
    model = solver(scene, posture).model
    # Without smoothing over time, since each row is another place.
    return np.concatenate(
        [rest_path(model, posture, tip[None], np.ones((1, 4)), 1.0) for tip in tips]
    )
