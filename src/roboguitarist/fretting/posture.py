"""How the left hand holds itself: its relaxed posture, and what leaving it costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from roboguitarist.hands import TIP_RADIUS_M, Variant
from roboguitarist.kinematics import Solver
from roboguitarist.scene import LEFT_TIPS, SceneConfig, build

Value = TypeVar("Value")
FINGERS = ("FF", "MF", "RF", "LF")
KNUCKLE_RADIUS_M = 0.009

# The thumb lies behind the neck.
_THUMB = {"THJ5": -0.50, "THJ4": 1.22, "THJ3": 0.209, "THJ2": 0.698, "THJ1": 1.34}


@dataclass(frozen=True)
class Posture:
    """Preferences of the inverse kinematics of the left hand.

    Tables name joints without the prefix `lh_`; `J1` to `J4` stand for those of all four
    fingers, `TH` for all of the thumb.

    Attributes:
        rest: Relaxed joint positions in rad.
        limits: Ranges in rad, inside those of the joints, that leave the servos room to press.
        cost: Cost of a radian or metre away from the relaxed posture.
        pointing: Direction that fingertips are drawn to, and the cost of a radian away from it.
        pressed, idle: Cost of a metre of error of a fingertip that is down, and of one that
            is not.
        bend: J1 = bend + J2 in the planned path.
        room_pull: Share of its cost with which a pressing fingertip is drawn to its place between
            the wires.
    """

    rest: Mapping[str, float]
    limits: Mapping[str, tuple[float, float]]
    cost: Mapping[str, float]
    pointing: tuple[float, float, float] = (0.0, -0.535, -1.0)
    pointing_cost: float = 0.288
    pressed: float = 100.0
    idle: float = 3.0
    bend: float = 0.0
    room_pull: float = 0.022


_LIMITS = {
    "WRJ1": (-0.4, 0.3),
    "WRJ2": (-0.15, 0.15),
    "J4": (-0.33, 0.33),
    "J3": (-0.2, 1.2),
    "J2": (0.1, 1.4),
    "J1": (0.1, 1.4),
}
_COST = {
    "forearm_x": 5.28,
    "forearm_y": 5.33,
    "forearm_z": 5.0,
    "WRJ1": 0.746,
    "WRJ2": 0.133,
    "J4": 0.0169,
    "J3": 0.0144,
    "J2": 0.0265,
    "J1": 0.0265,
    "LFJ5": 0.1,
    "TH": 10.0,
}
# Found by random search: first over 61 hand shapes, judged by the force with which physics held
# them, then over the first 18 s of the eight pieces of the repertoire.
POSTURES: dict[Variant, Posture] = {
    "linkage": Posture(
        {"WRJ1": 0.158, "J3": 0.505, "J2": 1.0, "J1": 1.0, **_THUMB}, _LIMITS, _COST
    ),
    # A tendon's finger rests when the string's force lies along the middle phalanx, or when the
    # last joint is straight: it comes down with both nearly upright.
    "tendon": Posture(
        {"WRJ1": 0.28, "J3": 1.32, "J2": 1.35, "J1": 0.05, **_THUMB},
        {**_LIMITS, "J3": (-0.2, 1.5), "J1": (0.0038, 1.4)},
        {**_COST, "WRJ1": 1.37, "J4": 0.0169, "J3": 0.0149, "J2": 0.0306, "J1": 0.0306},
        pointing=(0.0, -0.0266, -1.0),
        pointing_cost=0.333,
        idle=5.02,
        bend=-1.3,
        room_pull=0.3,
    ),
}


def left_alone(scene: SceneConfig) -> mujoco.MjModel:
    """Model of the left hand and the strings, without what only the eye needs."""
    return build(SceneConfig(scene.guitar, scene.hand, ("left",), scene.timestep_s, visuals=False))


def solver(scene: SceneConfig, posture: Posture) -> Solver:
    """Inverse kinematics of the left hand with these preferences.

    In both variants the planned path couples J1 and J2, in the tendon's as they move when
    nothing holds them: both by the same angle.
    """
    model = left_alone(SceneConfig(scene.guitar, "linkage", timestep_s=scene.timestep_s))
    model.eq_data[:, 0] = posture.bend
    for index in range(model.njnt):
        limits = _lookup(model.joint(index).name, posture.limits)
        if limits is not None:
            model.jnt_range[index] = limits
    stems = [f"lh_{finger.lower()}" for finger in FINGERS]
    return Solver(
        model,
        LEFT_TIPS,
        _values(model, posture.cost, 0.03),
        tuple(tuple(stem + link for link in ("proximal", "middle", "distal")) for stem in stems),
        posture.pointing,
        posture.pointing_cost,
        knuckles=tuple(
            (stem + link, KNUCKLE_RADIUS_M) for stem in stems for link in ("middle", "distal")
        ),
        tip_radius_m=TIP_RADIUS_M,
        room_pull=posture.room_pull,
    )


def rest_path(
    model: mujoco.MjModel,
    posture: Posture,
    tips: np.ndarray,
    weight: np.ndarray,
    smoothing: float,
) -> np.ndarray:
    """Postures (T, nq) of a relaxed hand that is moved to where its work is.

    The forearm is shifted so that the fingertips of the relaxed hand would be, in the weighted
    mean, where they are wanted.

    Args:
        model: The left hand.
        posture: How it relaxes.
        tips: (T, 4, 3) wanted positions of the fingertips in metres.
        weight: (T, 4) how much each counts.
        smoothing: Standard deviation of the smoothing over time, in samples.
    """
    relaxed = _values(model, posture.rest, 0.0)
    data = mujoco.MjData(model)
    data.qpos[:] = relaxed
    mujoco.mj_kinematics(model, data)
    at_rest = np.array([data.site(name).xpos for name in LEFT_TIPS])
    share = weight / weight.sum(axis=1, keepdims=True)
    base = np.einsum("tk,tkc->tc", share, tips - at_rest)
    base[:, 2] = tips[..., 2].min() - at_rest[:, 2].mean() + 0.002
    path = np.tile(relaxed, (len(tips), 1))
    path[:, :3] = gaussian_filter1d(base, smoothing, axis=0, mode="nearest")
    return path


def _lookup(joint: str, table: Mapping[str, Value]) -> Value | None:
    """Entry for a joint: its own, that of its place in the finger (J1 to J4) or `TH`."""
    name = joint.removeprefix("lh_")
    kind = name[2:] if name[:2] in FINGERS else name[:2]
    return table.get(name, table.get(kind))


def _values(model: mujoco.MjModel, table: Mapping[str, float], default: float) -> np.ndarray:
    found = [_lookup(model.joint(index).name, table) for index in range(model.njnt)]
    return np.array([default if value is None else value for value in found])
