from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.hands import VARIANTS, Variant
from roboguitarist.plan import PLAN_HZ
from roboguitarist.scene import SceneConfig, build
from roboguitarist.servo import actuator_moment, inverse_dynamics, servo_targets

seeds = st.integers(0, 2**31)
SIDES = ("left", "right")
CONSTRAINTS, SERVOS = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT, mujoco.mjtDisableBit.mjDSBL_ACTUATION


@pytest.fixture(scope="module", params=[(side, hand) for side in SIDES for hand in VARIANTS])
def model(request) -> mujoco.MjModel:
    side, hand = request.param
    return alone(side, hand)


def alone(side: str, hand: Variant = "linkage") -> mujoco.MjModel:
    sides = ("left",) if side == "left" else ("right",)
    return build(SceneConfig(hand=hand, sides=sides, visuals=False))


def bent(model: mujoco.MjModel, share: float = 0.4) -> np.ndarray:
    """A hand with bent fingers that touch neither each other nor the strings."""
    qpos = model.qpos0.copy()
    for index in range(model.njnt):
        name = model.joint(index).name
        if name.endswith(("FJ1", "FJ2", "FJ3")):
            qpos[index] = share * model.jnt_range[index, 1]
    if model.nq == 27:
        qpos[:3] = 0.1, 0.05, 0.05
    return qpos


def waves(model: mujoco.MjModel, seconds: float, rate_hz: float, seed: int = 0) -> np.ndarray:
    """A joint path (T, nq) in which all fingers bend and stretch, each at its own slow pace."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0, seconds, 1 / rate_hz)
    path = np.tile(bent(model), (len(time_s), 1))
    for index in range(model.njnt):
        name = model.joint(index).name
        if name.endswith(("FJ3", "WRJ1", "forearm_x")):
            pace_hz, swing = rng.uniform(0.5, 1.5), 0.1 if "x" in name else 0.3
            path[:, index] += swing * (1 - np.cos(2 * np.pi * pace_hz * time_s)) / 2
        if name.endswith(("FJ1", "FJ2")):  # both alike, as the linkage wants it
            path[:, index] += 0.3 * (1 - np.cos(2 * np.pi * time_s)) / 2
    return path


def track(model: mujoco.MjModel, path: np.ndarray, ctrl: np.ndarray, rate_hz: float) -> np.ndarray:
    """Joint path (T, nq) that physics makes of the targets."""
    data = mujoco.MjData(model)
    data.qpos[:] = path[0]
    out = np.empty_like(path)
    for tick, targets in enumerate(ctrl):
        out[tick] = data.qpos
        data.ctrl[:] = targets
        mujoco.mj_step(model, data, nstep=round(1 / (rate_hz * model.opt.timestep)))
    return out


@settings(max_examples=25, deadline=None)
@given(seeds)
def test_inverse_dynamics_inverts_forward_dynamics(model, seed):
    rng = np.random.default_rng(seed)
    qpos = rng.uniform(*model.jnt_range.T)
    qvel, qacc = rng.normal(size=model.nv), 10 * rng.normal(size=model.nv)
    force = inverse_dynamics(model, qpos[None], qvel[None], qacc[None])[0]
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = qpos, qvel, force
    flags = int(model.opt.disableflags)
    model.opt.disableflags = flags | CONSTRAINTS | SERVOS
    mujoco.mj_forward(model, data)
    model.opt.disableflags = flags
    np.testing.assert_allclose(data.qacc, qacc, rtol=0, atol=1e-6)


def test_inverse_dynamics_leaves_the_model_as_it_was(model):
    flags = int(model.opt.disableflags)
    still = np.zeros((1, model.nv))
    inverse_dynamics(model, bent(model)[None], still, still)
    assert model.opt.disableflags == flags


def test_a_hand_at_rest_needs_no_force(model):
    still = np.zeros((1, model.nv))
    force = inverse_dynamics(model, bent(model)[None], still, still)
    np.testing.assert_allclose(force, 0, atol=1e-12)


@settings(max_examples=10, deadline=None)
@given(seeds)
def test_moment_arms_are_the_derivatives_of_the_actuators_lengths(model, seed):
    data, step = mujoco.MjData(model), 1e-6
    qpos = np.random.default_rng(seed).uniform(*model.jnt_range.T)
    slopes = np.empty((model.nu, model.nv))
    for joint in range(model.nv):
        lengths = []
        for sign in (-1, 1):
            data.qpos[:] = qpos
            data.qpos[joint] += sign * step
            mujoco.mj_forward(model, data)
            lengths.append(data.actuator_length.copy())
        slopes[:, joint] = (lengths[1] - lengths[0]) / (2 * step)
    np.testing.assert_allclose(actuator_moment(model), slopes, atol=1e-6)


def test_a_hand_that_stands_still_is_its_own_target(model):
    path = np.tile(bent(model), (5, 1))
    ctrl = servo_targets(model, path, PLAN_HZ)
    np.testing.assert_allclose(ctrl, path @ actuator_moment(model).T, atol=1e-9)


def test_slow_waves_are_followed(model):
    path = waves(model, 2.0, PLAN_HZ)
    error = np.abs(track(model, path, servo_targets(model, path, PLAN_HZ), PLAN_HZ) - path)
    naive = np.clip(path @ actuator_moment(model).T, *model.actuator_ctrlrange.T)
    without = np.abs(track(model, path, naive, PLAN_HZ) - path)
    assert np.max(error) < 0.006
    assert np.mean(error) < 0.1 * np.mean(without)


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(0.1, 100))
def test_targets_stay_within_the_servos_ranges(model, seed, force):
    rng = np.random.default_rng(seed)
    path = rng.uniform(*model.jnt_range.T, size=(6, model.nq))
    contact = force * rng.normal(size=(6, model.nv))
    ctrl = servo_targets(model, path, PLAN_HZ, contact)
    assert np.isfinite(ctrl).all()
    low, high = model.actuator_ctrlrange.T
    assert np.all((low <= ctrl) & (ctrl <= high))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("newton", [0.5, 1.5])
def test_a_posture_is_held_against_a_force_that_was_foreseen(side, newton):
    model = alone(side)
    path = np.tile(bent(model), (240, 1))
    data, jacobian = mujoco.MjData(model), np.zeros((3, model.nv))
    data.qpos[:] = path[0]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    site = model.site(f"{side[0]}h_mftip")
    mujoco.mj_jacSite(model, data, jacobian, None, site.id)
    palm = data.site_xmat[site.id].reshape(3, 3)[:, 1]
    push = newton * palm @ jacobian  # from the palm's side, as a string pushes a fingertip
    data.qfrc_applied[:] = push
    ends = []
    for foreseen in (np.tile(push, (240, 1)), None):
        data.qpos[:], data.qvel[:] = path[0], 0.0
        data.ctrl[:] = servo_targets(model, path, PLAN_HZ, foreseen)[0]
        mujoco.mj_step(model, data, nstep=480)
        ends.append(np.abs(data.qpos - path[0]).max())
    assert ends[0] < 0.005
    assert ends[1] > 10 * ends[0]


def test_what_no_servo_can_do_is_asked_up_to_its_limit():
    model = alone("left")
    path = np.tile(bent(model), (3, 1))
    contact = np.zeros_like(path)
    servo, joint = model.actuator("lh_A_WRJ1"), model.joint("lh_WRJ1")
    for pull in (-1e3, 1e3):
        contact[:, joint.dofadr[0]] = pull
        ctrl = servo_targets(model, path, PLAN_HZ, contact)[0, servo.id]
        wanted = -np.sign(pull) * servo.forcerange[1] / servo.gainprm[0]
        assert ctrl == pytest.approx(np.clip(wanted, *servo.ctrlrange))
