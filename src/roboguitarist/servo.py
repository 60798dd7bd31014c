"""Servo targets that make a hand follow a joint path and press as hard as planned.

A position servo at its target exerts no force, and damping makes it lag. Both are repaired by
inverse dynamics: from the path and the wanted contact forces follow the joint torques, from
these the targets (computed torque; Siciliano et al., Robotics, 2009, section 8.5.2).
"""

from __future__ import annotations

import mujoco
import numpy as np

FRICTION_SPEED = 0.1
"""Speed in rad/s at which dry friction is compensated to three quarters."""


def servo_targets(
    model: mujoco.MjModel,
    qpos: np.ndarray,
    rate_hz: float,
    qfrc_contact: np.ndarray | None = None,
) -> np.ndarray:
    """Targets of all servos for a joint path.

    Args:
        model: The model; every actuator must be a position servo.
        qpos: (T, nq) joint path in rad and m; nq equals nv, there are only hinges and slides.
        rate_hz: Samples per second of the path.
        qfrc_contact: (T, nv) generalised forces that contacts will exert, in N m and N.

    Returns:
        (T, nu) targets in rad and m, within the servos' ranges. Where a target would need more
        than a servo can do, its limit is returned.
    """
    qvel = np.gradient(qpos, 1.0 / rate_hz, axis=0)
    qacc = np.gradient(qvel, 1.0 / rate_hz, axis=0)
    torque = inverse_dynamics(model, qpos, qvel, qacc)
    torque += model.dof_frictionloss * np.tanh(qvel / FRICTION_SPEED)
    if qfrc_contact is not None:
        torque -= qfrc_contact
    moment = actuator_moment(model)
    force = np.clip(torque @ _effort(model, moment).T, *_force_limits(model))
    gain, bias = model.actuator_gainprm[:, 0], model.actuator_biasprm[:, :3]
    length, velocity = qpos @ moment.T, qvel @ moment.T
    ctrl = (force - bias[:, 0] - bias[:, 1] * length - bias[:, 2] * velocity) / gain
    return np.clip(ctrl, *model.actuator_ctrlrange.T)


def inverse_dynamics(
    model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray, qacc: np.ndarray
) -> np.ndarray:
    """Generalised forces (T, nv) that move the joints along a path, without constraints.

    Args:
        model: The model.
        qpos: (T, nq) positions.
        qvel: (T, nv) velocities.
        qacc: (T, nv) accelerations.
    """
    data = mujoco.MjData(model)
    flags = model.opt.disableflags
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    out = np.empty_like(qvel)
    try:
        for tick in range(len(qpos)):
            data.qpos[:], data.qvel[:], data.qacc[:] = qpos[tick], qvel[tick], qacc[tick]
            mujoco.mj_inverse(model, data)
            out[tick] = data.qfrc_inverse
    finally:
        model.opt.disableflags = flags
    return out


def actuator_moment(model: mujoco.MjModel) -> np.ndarray:
    """Moment arms (nu, nv) of the actuators, which do not depend on the pose here."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    moment = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(
        moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    return moment


def _effort(model: mujoco.MjModel, moment: np.ndarray) -> np.ndarray:
    """Matrix (nu, nv) from generalised forces to actuator forces.

    A coupled pair of joints (J1 = J2) passes torque from one to the other, so the coupling's
    force is an unknown beside those of the actuators. What no actuator can supply, such as the
    split of torque between J1 and J2 of the tendon hand, is met in the least-squares sense.
    """
    couplings = []
    for index in range(model.neq):
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT:
            row = np.zeros(model.nv)
            row[model.jnt_dofadr[model.eq_obj1id[index]]] = 1.0
            row[model.jnt_dofadr[model.eq_obj2id[index]]] = -model.eq_data[index, 1]
            couplings.append(row)
    rows = np.vstack([moment, *couplings])
    return np.linalg.pinv(rows.T)[: model.nu]


def _force_limits(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    low, high = model.actuator_forcerange.T
    return low, high
