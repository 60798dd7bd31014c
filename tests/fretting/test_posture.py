import mujoco
import numpy as np
import pytest

from roboguitarist.fretting.posture import POSTURES, rest_path, solver
from roboguitarist.hands import VARIANTS
from roboguitarist.scene import LEFT_TIPS, SceneConfig


@pytest.mark.parametrize("variant", VARIANTS)
def test_limits_leave_room_inside_the_joints(variant):
    hand = solver(SceneConfig(hand=variant), POSTURES[variant])
    free = solver(SceneConfig(hand=variant), POSTURES["linkage"]).model
    low, high = hand.model.jnt_range.T
    assert np.all(low < high)
    assert hand.posture_cost.shape == (hand.model.nv,)
    assert np.all(hand.posture_cost > 0)
    assert free.nq == hand.model.nq


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_relaxed_hand_keeps_its_coupling_and_its_limits(variant):
    posture = POSTURES[variant]
    hand = solver(SceneConfig(hand=variant), posture)
    tips = np.tile([[0.05, 0.0, 0.0073]], (4, 1))[None]
    rest = rest_path(hand.model, posture, tips, np.ones((1, 4)), 1.0)[0]
    low, high = hand.model.jnt_range.T
    assert np.all(rest >= low - 1e-9)
    assert np.all(rest <= high + 1e-9)
    for finger in ("FF", "MF", "RF", "LF"):
        first, second = (rest[hand.model.joint(f"lh_{finger}J{j}").qposadr[0]] for j in (1, 2))
        assert first == pytest.approx(posture.bend + second, abs=0.02)


def test_the_hand_is_moved_to_its_work():
    posture = POSTURES["linkage"]
    model = solver(SceneConfig(), posture).model
    wanted = np.array([[[0.3 + 0.022 * f, 0.01, 0.0073] for f in range(4)]])
    data = mujoco.MjData(model)
    data.qpos[:] = rest_path(model, posture, wanted, np.ones((1, 4)), 1.0)[0]
    mujoco.mj_kinematics(model, data)
    tips = np.array([data.site(name).xpos for name in LEFT_TIPS])
    assert tips.mean(axis=0) == pytest.approx(wanted[0].mean(axis=0), abs=0.004)
