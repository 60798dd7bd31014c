from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.hands import FINGERS, PREFIX, VARIANTS, Side, Variant, add_hand

TURN = 1.5708
# Joint: range, gain and force limit of its servo, as published; J1 and J2 share the servo J0.
PUBLISHED = {
    "WRJ2": (-0.523599, 0.174533, 10, 10),
    "WRJ1": (-0.698132, 0.488692, 8, 5),
    "FFJ4": (-0.349066, 0.349066, 1, 1),
    "FFJ3": (-0.261799, TURN, 1, 1),
    "MFJ4": (-0.349066, 0.349066, 1, 1),
    "MFJ3": (-0.261799, TURN, 1, 1),
    "RFJ4": (-0.349066, 0.349066, 1, 1),
    "RFJ3": (-0.261799, TURN, 1, 1),
    "LFJ5": (0, 0.785398, 1, 1),
    "LFJ4": (-0.349066, 0.349066, 1, 1),
    "LFJ3": (-0.261799, TURN, 1, 1),
    "THJ5": (-1.0472, 1.0472, 0.4, 3),
    "THJ4": (0, 1.22173, 1, 2),
    "THJ3": (-0.20944, 0.20944, 0.5, 1),
    "THJ2": (-0.698132, 0.698132, 1.5, 1),
    "THJ1": (-0.261799, TURN, 1, 1),
}
COUPLED = ("FF", "MF", "RF", "LF")
MASS_KG = {"forearm": 3.0, "palm": 0.3, "ffproximal": 0.03, "lfmetacarpal": 0.03, "thdistal": 0.017}
SIDES: tuple[Side, ...] = ("left", "right")
shares = st.lists(st.floats(0, 1), min_size=24, max_size=24).map(np.array)


def build(side: Side, variant: Variant = "linkage") -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    base = spec.worldbody.add_body(name=f"{PREFIX[side]}forearm")
    add_hand(spec, base, side, variant)
    return spec.compile()


@pytest.fixture(scope="module")
def hands() -> dict[tuple[str, str], mujoco.MjModel]:
    """Both variants of both hands."""
    return {(side, variant): build(side, variant) for side in SIDES for variant in VARIANTS}


def posture(model: mujoco.MjModel, share: np.ndarray | float) -> np.ndarray:
    """Joints at a share of their ranges, with J1 = J2 as the linkage wants it."""
    low, high = model.jnt_range.T
    qpos = low + share * (high - low)
    for joint in range(model.njnt):
        name = model.joint(joint).name
        if name.endswith("J1") and name[3:5] in COUPLED:
            qpos[joint] = qpos[model.joint(f"{name[:-1]}2").id]
    return qpos


def at_rest(model: mujoco.MjModel, qpos: np.ndarray) -> mujoco.MjData:
    """A hand in a posture, with every servo at its target."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    data.ctrl[:] = data.actuator_length
    return data


def tips(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return data.site_xpos.copy()


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("side", SIDES)
def test_sizes(hands, side, variant):
    model = hands[side, variant]
    assert (model.nq, model.nv, model.nu, model.ntendon) == (24, 24, 20, 4)
    assert (model.nbody, model.nsite) == (26, 10)
    assert model.neq == (4 if variant == "linkage" else 0)


@pytest.mark.parametrize("side", SIDES)
def test_figures_are_those_published(hands, side):
    model, prefix = hands[side, "tendon"], PREFIX[side]
    assert model.body_mass.sum() == pytest.approx(3.794)
    for body, mass in MASS_KG.items():
        assert model.body(prefix + body).mass[0] == pytest.approx(mass)
    for name, (low, high, gain, limit) in PUBLISHED.items():
        servo = model.actuator(f"{prefix}A_{name}")
        np.testing.assert_allclose(model.joint(prefix + name).range, (low, high), atol=1e-5)
        np.testing.assert_allclose(servo.ctrlrange, (low, high), atol=1e-5)
        np.testing.assert_allclose(servo.forcerange, (-limit, limit))
        assert (servo.gainprm[0], servo.biasprm[1], servo.biasprm[2]) == (gain, -gain, 0)
    np.testing.assert_array_equal(model.dof_armature, 0.0002)
    np.testing.assert_array_equal(model.dof_frictionloss, 0.01)
    assert {round(float(x), 6) for x in model.dof_damping} == {0.05, 0.5}


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("finger", COUPLED)
def test_one_servo_drives_the_sum_of_the_two_outer_joints(hands, side, finger):
    model, stem = hands[side, "tendon"], f"{PREFIX[side]}{finger}"
    for joint in ("J1", "J2"):
        np.testing.assert_allclose(model.joint(stem + joint).range, (0, TURN), atol=1e-5)
    servo = model.actuator(f"{PREFIX[side]}A_{finger}J0")
    assert servo.gainprm[0] == 0.5
    np.testing.assert_allclose(servo.ctrlrange, (0, 3.1415))
    data = mujoco.MjData(model)
    data.qpos[model.joint(f"{stem}J1").id], data.qpos[model.joint(f"{stem}J2").id] = 0.3, 0.9
    mujoco.mj_forward(model, data)
    assert data.actuator_length[servo.id] == pytest.approx(1.2)


def test_stretched_fingers_are_as_long_as_published(hands):
    model = hands["left", "linkage"]
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for finger, height in {"ff": 0.095, "mf": 0.099, "rf": 0.095, "lf": 0.0865}.items():
        nail_z = data.site(f"lh_{finger}nail").xpos[2]
        assert nail_z == pytest.approx(0.21301 + 0.034 + height + 0.045 + 0.025 + 0.032, abs=1e-6)
    knuckles = [data.body(f"lh_{finger}knuckle").xpos[0] for finger in ("ff", "mf", "rf", "lf")]
    np.testing.assert_allclose(np.diff(knuckles), 0.022, atol=1e-6)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("finger", COUPLED)
@pytest.mark.parametrize("joint", ["J3", "J2", "J1"])
def test_flexion_brings_a_fingertip_to_the_palm_side(hands, side, finger, joint):
    model = hands[side, "tendon"]
    qpos = np.zeros(model.nq)
    tip = model.site(f"{PREFIX[side]}{finger.lower()}tip").id
    before = tips(model, qpos)[tip]
    qpos[model.joint(f"{PREFIX[side]}{finger}{joint}").id] = 0.5
    assert tips(model, qpos)[tip, 1] < before[1] - 0.005


@given(shares)
def test_the_right_hand_is_the_mirror_image_of_the_left(hands, share):
    left, right = hands["left", "linkage"], hands["right", "linkage"]
    qpos = posture(left, share)
    np.testing.assert_array_equal(left.jnt_range, right.jnt_range)
    np.testing.assert_allclose(tips(right, qpos), tips(left, qpos) * (-1, 1, 1), rtol=0, atol=1e-12)


def test_names_of_both_hands_differ_in_the_prefix_only(hands):
    left, right = hands["left", "linkage"], hands["right", "linkage"]
    for kind, count in (("joint", 24), ("actuator", 20), ("body", 26), ("site", 10)):
        names = [[getattr(hand, kind)(i).name for i in range(count)] for hand in (left, right)]
        assert [name.replace("lh_", "rh_") for name in names[0]] == names[1]
        assert len(set(names[0])) == count
    assert {left.site(i).name for i in range(10)} == {
        f"lh_{finger.lower()}{part}" for finger in FINGERS for part in ("tip", "nail")
    }


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("side", SIDES)
@settings(max_examples=10, deadline=None)
@given(share=st.floats(0.1, 0.9), down=st.tuples(*[st.floats(-1, 1)] * 3))
def test_a_hand_left_alone_does_not_sink_whichever_way_is_down(side, variant, share, down):
    model = build(side, variant)
    model.opt.gravity, model.dof_frictionloss[:] = 9.81 * np.array(down), 0.0
    qpos = posture(model, share)
    data = at_rest(model, qpos)
    mujoco.mj_step(model, data, nstep=round(1.0 / model.opt.timestep))
    np.testing.assert_allclose(data.qpos, qpos, rtol=0, atol=1e-6)


def split_under_load(variant: Variant) -> tuple[float, float]:
    """Angles J1 and J2 of the middle finger while its tip is pushed from the palm side."""
    model = build("left", variant)
    data = at_rest(model, posture(model, 0.5))
    tip, body = model.site("lh_mftip").id, model.body("lh_mfdistal").id
    jacobian = np.zeros((3, model.nv))
    for _ in range(1000):
        mujoco.mj_jac(model, data, jacobian, None, data.site_xpos[tip], body)
        data.qfrc_applied[:] = (1.5 * data.xmat[body].reshape(3, 3)[:, 1]) @ jacobian
        mujoco.mj_step(model, data)
    return data.joint("lh_MFJ1").qpos[0], data.joint("lh_MFJ2").qpos[0]


def test_the_linkage_keeps_the_outer_joints_equal_under_load():
    first, second = split_under_load("linkage")
    assert first == pytest.approx(second, abs=0.01)


def test_the_tendon_lets_the_load_decide_their_split():
    first, second = split_under_load("tendon")
    assert abs(first - second) > 0.2


@pytest.mark.parametrize("side", SIDES)
def test_the_linkage_keeps_the_outer_joints_equal_in_motion(hands, side):
    model, rng = hands[side, "linkage"], np.random.default_rng(1)
    data, worst = at_rest(model, posture(model, 0.3)), 0.0
    outer, inner = ([model.joint(f"{PREFIX[side]}{f}J{k}").id for f in COUPLED] for k in (1, 2))
    for step in range(2000):
        if step % 100 == 0:
            data.ctrl[:] = rng.uniform(*model.actuator_ctrlrange.T)
        mujoco.mj_step(model, data)
        worst = max(worst, np.abs(data.qpos[outer] - data.qpos[inner]).max())
    assert 0 < worst < 0.03
