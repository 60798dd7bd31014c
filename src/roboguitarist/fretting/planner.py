"""The left hand without learning: paths of the fingertips, inverse kinematics, statics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import mujoco
import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from roboguitarist.fingering import Fingering
from roboguitarist.fretting.paths import tip_plan
from roboguitarist.fretting.presses import find_presses
from roboguitarist.fretting.schedule import Pace, schedule
from roboguitarist.hands import TIP_RADIUS_M
from roboguitarist.kinematics import Solver, TipPaths, follow
from roboguitarist.plan import PLAN_HZ, HandPlan, plan_times
from roboguitarist.scene import SceneConfig, build
from roboguitarist.servo import servo_targets

Value = TypeVar("Value")
TIPS = ("lh_fftip", "lh_mftip", "lh_rftip", "lh_lftip")
FINGERS = ("FF", "MF", "RF", "LF")


@dataclass(frozen=True)
class PlannerConfig:
    """How the planner plays.

    Attributes:
        force_n: Normal force with which a fingertip presses.
        pace: How the fingers move.
        base_s: Standard deviation of the smoothing of the hand's way along the neck.
    """

    force_n: float = 2.5
    pace: Pace = field(default_factory=Pace)
    base_s: float = 0.08


KNOT_S = 0.1
"""Longest time between two solutions of the inverse kinematics."""
MERGE_SAMPLES = 3
"""Solutions are at least that many samples apart."""
PRESSED_WEIGHT, IDLE_WEIGHT = 100.0, 3.0

# Rest posture, costs and ranges were found by random search over 61 hand shapes, judged by the
# forces with which the shape was held in physics.
REST_RAD = {
    "WRJ1": 0.15,
    "J3": 0.5,
    "J2": 1.0,
    "J1": 1.0,
    # The thumb lies behind the neck.
    "THJ5": -0.50,
    "THJ4": 1.22,
    "THJ3": 0.21,
    "THJ2": 0.70,
    "THJ1": 1.34,
}
RANGE_RAD = {
    "WRJ1": (-0.4, 0.3),
    "WRJ2": (-0.15, 0.15),
    "J4": (-0.33, 0.33),
    "J3": (-0.2, 1.2),
    "J2": (0.1, 1.4),
    "J1": (0.1, 1.4),
}
COST = {
    "forearm_x": 5.0,
    "forearm_y": 5.0,
    "forearm_z": 5.0,
    "WRJ1": 0.6,
    "WRJ2": 0.152,
    "J4": 0.0169,
    "J3": 0.0168,
    "J2": 0.0181,
    "J1": 0.0181,
    "LFJ5": 0.1,
    "TH": 10.0,
}
POINTING, POINTING_COST = (0.0, -0.535, -1.0), 0.288


def plan(
    fingering: Fingering,
    scene: SceneConfig | None = None,
    config: PlannerConfig | None = None,
) -> HandPlan:
    """Plan the left hand's motion for a piece.

    Args:
        fingering: Which finger stops what and when.
        scene: Its guitar, hand and time step matter.
        config: How to move.

    Returns:
        The motion, with servo targets for the left hand.
    """
    scene, config = scene or SceneConfig(), config or PlannerConfig()
    guitar, pace = scene.guitar, config.pace
    presses = find_presses(fingering, guitar)
    time_s = plan_times(fingering.tablature.duration_s)
    timetable = schedule(presses, guitar, pace)
    tips = tip_plan(timetable, fingering, time_s, guitar, pace)
    weight = IDLE_WEIGHT + (PRESSED_WEIGHT - IDLE_WEIGHT) * tips.grip
    hand = solver(left_hand(scene))
    rest = rest_path(hand.model, tips.position_m, weight, config.base_s * PLAN_HZ)
    knots = knot_indices(timetable.turning_times(), time_s)
    aloft = 1.0 - tips.grip[knots]
    paths = TipPaths(tips.position_m[knots], weight[knots], rest[knots], aloft)
    postures = follow(hand, paths)
    qpos = PchipInterpolator(time_s[knots], postures, axis=0)(time_s)
    contact = contact_torque(hand.model, qpos, config.force_n * tips.force)
    return HandPlan(time_s, qpos, servo_targets(_alone(scene), qpos, PLAN_HZ, contact))


def knot_indices(turning_s: list[float], time_s: np.ndarray) -> np.ndarray:
    """Samples at which inverse kinematics is solved: where fingers touch, leave or turn.

    Between them the joints move smoothly, so that no posture is left faster than a hand can.
    """
    regular = np.arange(time_s[0], time_s[-1], KNOT_S)
    turns = np.array(turning_s)
    away = np.abs(regular[:, None] - turns).min(axis=1, initial=np.inf) > KNOT_S / 3
    index = np.searchsorted(time_s, np.sort(np.concatenate([regular[away], turns])))
    index = np.unique(np.clip([0, *index, len(time_s) - 1], 0, len(time_s) - 1))
    apart = np.diff(index, prepend=-MERGE_SAMPLES) >= MERGE_SAMPLES
    apart[-1] = True
    return index[apart]


def _alone(scene: SceneConfig) -> mujoco.MjModel:
    return build(SceneConfig(scene.guitar, scene.hand, ("left",), scene.timestep_s, visuals=False))


def left_hand(scene: SceneConfig) -> mujoco.MjModel:
    """Model of the left hand alone, with joint ranges that leave room to press."""
    model = _alone(scene)
    for index in range(model.njnt):
        limits = _lookup(model.joint(index).name, RANGE_RAD)
        if limits is not None:
            model.jnt_range[index] = limits
    return model


def _lookup(joint: str, table: Mapping[str, Value]) -> Value | None:
    """Entry for a joint: its own, that of its place in the finger (J1 to J4) or `TH`."""
    name = joint.removeprefix("lh_")
    kind = name[2:] if name[:2] in FINGERS else name[:2]
    return table.get(name, table.get(kind))


def _values(model: mujoco.MjModel, table: Mapping[str, float], default: float) -> np.ndarray:
    names = [model.joint(index).name for index in range(model.njnt)]
    found = [_lookup(name, table) for name in names]
    return np.array([default if value is None else value for value in found])


def rest_path(
    model: mujoco.MjModel, tips: np.ndarray, weight: np.ndarray, smoothing: float
) -> np.ndarray:
    """Postures (T, nq) of a relaxed hand that is moved to where its work is.

    The forearm is shifted so that the fingertips of the relaxed hand would be, in the weighted
    mean, where they are wanted.

    Args:
        model: The left hand.
        tips: (T, 4, 3) wanted positions of the fingertips.
        weight: (T, 4) how much each counts.
        smoothing: Standard deviation of the smoothing over time, in samples.
    """
    posture = _values(model, REST_RAD, 0.0)
    data = mujoco.MjData(model)
    data.qpos[:] = posture
    mujoco.mj_kinematics(model, data)
    at_rest = np.array([data.site(name).xpos for name in TIPS])
    share = weight / weight.sum(axis=1, keepdims=True)
    base = np.einsum("tk,tkc->tc", share, tips - at_rest)
    base[:, 2] = tips[..., 2].min() - at_rest[:, 2].mean() + 0.002
    rest = np.tile(posture, (len(tips), 1))
    rest[:, :3] = gaussian_filter1d(base, smoothing, axis=0, mode="nearest")
    return rest


def solver(model: mujoco.MjModel) -> Solver:
    """Inverse kinematics of the left hand."""
    links = ("proximal", "middle", "distal")
    apart = tuple(tuple(f"lh_{f.lower()}{link}" for link in links) for f in FINGERS)
    knuckles = tuple(
        (f"lh_{f.lower()}{link}", radius)
        for f in FINGERS
        for link, radius in (("middle", 0.009), ("distal", 0.009))
    )
    return Solver(
        model,
        TIPS,
        _values(model, COST, 0.03),
        apart,
        POINTING,
        POINTING_COST,
        knuckles=knuckles,
        tip_radius_m=TIP_RADIUS_M,
    )


def contact_torque(model: mujoco.MjModel, qpos: np.ndarray, force_n: np.ndarray) -> np.ndarray:
    """Generalised forces (T, nv) with which the strings push the fingertips back.

    Args:
        model: The left hand.
        qpos: (T, nq) joint path.
        force_n: (T, 4) normal forces of fingers 1 to 4, in N.
    """
    data, jacobian = mujoco.MjData(model), np.zeros((3, model.nv))
    bodies = [model.site(name).bodyid[0] for name in TIPS]
    sites = [model.site(name).id for name in TIPS]
    down = np.array([0.0, 0.0, -TIP_RADIUS_M])
    torque = np.zeros((len(qpos), model.nv))
    for tick in np.flatnonzero(force_n.any(axis=1)):
        data.qpos[:] = qpos[tick]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for finger in np.flatnonzero(force_n[tick]):
            point = data.site_xpos[sites[finger]] + down
            mujoco.mj_jac(model, data, jacobian, None, point, bodies[finger])
            torque[tick] += jacobian[2] * force_n[tick, finger]
    return torque
