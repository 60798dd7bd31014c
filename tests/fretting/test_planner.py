from dataclasses import replace

import mujoco
import numpy as np
import pytest

from roboguitarist import formats, pieces
from roboguitarist.fingering import assign
from roboguitarist.fretting.planner import contact_torque, knot_indices, plan
from roboguitarist.fretting.posture import POSTURES, solver
from roboguitarist.metrics import evaluate
from roboguitarist.performance import PerformConfig, perform
from roboguitarist.plan import plan_times
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.tablature import Note, Tablature

C_MAJOR = Tablature(
    tuple(Note(0.5, s, f, 1.5) for s, f in ((1, 0), (2, 1), (3, 0), (4, 2), (5, 3)))
)


@pytest.fixture(scope="module")
def chord():
    return plan(assign(C_MAJOR))


def test_plans_of_one_piece_are_equal(chord):
    again = plan(assign(C_MAJOR))
    assert np.array_equal(chord.ctrl, again.ctrl)
    assert np.array_equal(chord.qpos, again.qpos)


def test_plan_keeps_to_the_joints_and_servos(chord):
    model = solver(SceneConfig(), POSTURES["linkage"]).model
    low, high = model.jnt_range.T
    assert np.all(chord.qpos >= low - 1e-3)
    assert np.all(chord.qpos <= high + 1e-3)
    low, high = model.actuator_ctrlrange.T
    assert np.all((chord.ctrl >= low) & (chord.ctrl <= high))


def test_planned_fingertips_are_on_their_strings(chord):
    model = solver(SceneConfig(), POSTURES["linkage"]).model
    data = mujoco.MjData(model)
    data.qpos[:] = chord.qpos[np.searchsorted(chord.time_s, 1.2)]
    mujoco.mj_kinematics(model, data)
    guitar = SceneConfig().guitar
    for tip, string, fret in zip(LEFT_TIPS, (2, 4, 5), (1, 2, 3), strict=False):
        x, y, _ = data.site(tip).xpos
        assert int(guitar.fret_at(np.array(x))) == fret
        assert abs(y - guitar.string_y(string, x)) < 0.002


def test_contact_torque_is_the_force_times_the_jacobian():
    model = solver(SceneConfig(), POSTURES["linkage"]).model
    rng = np.random.default_rng(0)
    qpos = rng.uniform(*model.jnt_range.T, size=(3, model.nq))
    force = np.array([[2.0, 0, 0, 0], [0, 0, 0, 0], [0, 1.0, 0, 3.0]])
    torque = contact_torque(model, qpos, force, np.zeros_like(force))
    assert not torque[1].any()
    # Virtual work: the height of the lowest point of the fingertips under a small motion.
    step, data = 1e-6 * rng.normal(size=model.nv), mujoco.MjData(model)

    def heights(positions: np.ndarray) -> np.ndarray:
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        return np.array([data.site(tip).xpos[2] for tip in LEFT_TIPS])

    for tick in (0, 2):
        work = force[tick] @ (heights(qpos[tick] + step) - heights(qpos[tick] - step)) / 2
        # Rolling about the fingertip's centre adds no height to first order.
        assert torque[tick] @ step == pytest.approx(work, rel=1e-3, abs=1e-12)


def test_knots_are_in_order_and_meet_the_turning_points():
    time_s = plan_times(2.0)
    turning = [0.031, 0.5, 1.234]
    knots = knot_indices(turning, time_s)
    assert knots[0] == 0
    assert knots[-1] == len(time_s) - 1
    assert np.all(np.diff(knots) > 0)
    gaps = np.abs(time_s[knots][:, None] - turning).min(axis=0)
    assert gaps.max() < 0.02


def test_a_piece_without_notes_is_planned():
    assert np.isfinite(plan(assign(Tablature(()))).ctrl).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("piece", "frame", "note"),
    [("scales-practice", 0.92, 0.97), ("long-long-ago", 0.92, 0.97), ("farewell", 0.85, 0.9)],
)
def test_the_planner_plays(piece, frame, note):
    tablature = formats.load(pieces.path(piece))
    opening = replace(tablature, notes=tuple(n for n in tablature.notes if n.end_s < 15))
    metrics = evaluate(perform(assign(opening), PerformConfig()))
    assert metrics.frame is not None
    assert metrics.note is not None
    assert metrics.frame.f1 >= frame
    assert metrics.note.f1 >= note
