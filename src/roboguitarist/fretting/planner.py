"""The left hand without learning: paths of the fingertips, inverse kinematics, statics."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
from scipy.interpolate import PchipInterpolator

from roboguitarist.fingering import Fingering
from roboguitarist.fretting.paths import tip_plan
from roboguitarist.fretting.posture import (
    FINGERS,
    POSTURES,
    Posture,
    left_alone,
    rest_path,
    solver,
)
from roboguitarist.fretting.presses import find_presses
from roboguitarist.fretting.schedule import Pace, schedule
from roboguitarist.hands import TIP_RADIUS_M, Variant
from roboguitarist.kinematics import TipPaths, follow
from roboguitarist.plan import PLAN_HZ, HandPlan, plan_times
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.servo import servo_targets


@dataclass(frozen=True)
class PlannerConfig:
    """How the planner plays.

    Attributes:
        posture: How the hand holds itself.
        pace: How the fingers move.
        force_n: Normal force with which a fingertip presses.
        base_s: Standard deviation of the smoothing of the hand's way along the neck.
    """

    posture: Posture
    pace: Pace = field(default_factory=Pace)
    force_n: float = 3.26
    base_s: float = 0.072


CONFIGS: dict[Variant, PlannerConfig] = {
    "linkage": PlannerConfig(POSTURES["linkage"]),
    "tendon": PlannerConfig(
        POSTURES["tendon"],
        Pace(early_s=0.0497, release_s=0.0299, hover_m=0.0193),
        1.98,
        0.0376,
    ),
}
KNOT_S = 0.1
"""Longest time between two solutions of the inverse kinematics."""
MERGE_SAMPLES = 3
"""Solutions are at least that many samples apart."""


def plan(
    fingering: Fingering,
    scene: SceneConfig | None = None,
    config: PlannerConfig | None = None,
) -> HandPlan:
    """Plan the left hand's motion for a piece.

    Args:
        fingering: Which finger stops what and when.
        scene: Its guitar, hand and time step matter.
        config: How to play; by default as suits the hand variant.

    Returns:
        The motion, with servo targets for the left hand.
    """
    scene = scene or SceneConfig()
    config = config or CONFIGS[scene.hand]
    posture = config.posture
    timetable = schedule(find_presses(fingering, scene.guitar), scene.guitar, config.pace)
    time_s = plan_times(fingering.tablature.duration_s)
    tips = tip_plan(timetable, fingering, time_s, scene.guitar, config.pace)
    weight = posture.idle + (posture.pressed - posture.idle) * tips.grip
    hand = solver(scene, posture)
    rest = rest_path(hand.model, posture, tips.position_m, weight, config.base_s * PLAN_HZ)
    knots = knot_indices(timetable.turning_times(), time_s)
    aloft = 1.0 - tips.grip[knots]
    paths = TipPaths(
        tips.position_m[knots], weight[knots], rest[knots], aloft, tips.flat[knots],
        tips.room_m[knots],
    )  # fmt: skip
    qpos = PchipInterpolator(time_s[knots], follow(hand, paths), axis=0)(time_s)
    contact = contact_torque(hand.model, qpos, config.force_n * tips.force, tips.flat)
    ctrl = servo_targets(left_alone(scene), qpos, PLAN_HZ, contact)
    return HandPlan(time_s, qpos, ctrl, tips.grip)


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


def contact_torque(
    model: mujoco.MjModel, qpos: np.ndarray, force_n: np.ndarray, flat: np.ndarray
) -> np.ndarray:
    """Generalised forces (T, nv) with which the strings push the fingers back.

    A finger that lies flat is pushed under its fingertip and, as hard each, under the joints J1
    and J2.

    Args:
        model: The left hand.
        qpos: (T, nq) joint path.
        force_n: (T, 4) normal forces of fingers 1 to 4, in N.
        flat: (T, 4) how much each lies over several strings, 0 to 1.
    """
    data, jacobian = mujoco.MjData(model), np.zeros((3, model.nv))
    bodies = [model.site(name).bodyid[0] for name in LEFT_TIPS]
    sites = [model.site(name).id for name in LEFT_TIPS]
    down = np.array([0.0, 0.0, -TIP_RADIUS_M])
    joints = [[model.body(f"lh_{f.lower()}{link}").id for link in ("distal", "middle")]
              for f in FINGERS]  # fmt: skip
    torque = np.zeros((len(qpos), model.nv))
    for tick in np.flatnonzero(force_n.any(axis=1)):
        data.qpos[:] = qpos[tick]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for finger in np.flatnonzero(force_n[tick]):
            point = data.site_xpos[sites[finger]] + down
            mujoco.mj_jac(model, data, jacobian, None, point, bodies[finger])
            torque[tick] += jacobian[2] * force_n[tick, finger]
            for joint in joints[finger] if flat[tick, finger] else ():
                mujoco.mj_jacBody(model, data, jacobian, None, joint)
                torque[tick] += jacobian[2] * force_n[tick, finger] * flat[tick, finger]
    return torque
