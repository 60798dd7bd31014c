from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.paper import ACTION_LIMITS, Actions, observation_blocks
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.4),))
MODEL = left_alone(TaskConfig().scene())
ACTIONS = Actions(MODEL)
SERVOS = [MODEL.actuator(f"lh_A_{name}").id for name in ACTION_LIMITS]
FIXED = ["WRJ2", "THJ4", "THJ3", "THJ2"]


def targets(value: float) -> dict[str, float]:
    ctrl = ACTIONS.ctrl(np.full((1, ACTIONS.size), value))[0]
    return dict(zip(ACTION_LIMITS, ctrl[SERVOS], strict=True))


def test_an_action_is_three_forearm_and_seventeen_joint_targets():
    names = list(ACTION_LIMITS)
    assert len(names) == 20
    assert sum(name.startswith("forearm") for name in names) == 3
    assert [name for name in names if ACTION_LIMITS[name] == (0.0, 0.0)] == FIXED


@pytest.mark.parametrize(("value", "share"), [(-1.0, 0.0), (0.0, 0.5), (1.0, 1.0)])
def test_actions_span_the_limits_of_the_table(value, share):
    reached = targets(value)
    for name, (low, high) in ACTION_LIMITS.items():
        servo = MODEL.actuator(f"lh_A_{name}").ctrlrange
        ends = np.clip((low, high), *servo)
        assert reached[name] == pytest.approx(ends[0] + share * (ends[1] - ends[0])), name


def test_only_the_wrist_is_bounded_by_its_servo():
    # The fingers' 0.35 rad is 20 degrees, rounded.
    cut = np.abs(np.array(list(ACTION_LIMITS.values())).T - (ACTIONS.low, ACTIONS.high)).max(axis=0)
    assert [name for name, lost in zip(ACTION_LIMITS, cut, strict=True) if lost > 1e-3] == ["WRJ1"]


@given(arrays(float, (3, 20), elements=st.floats(-50, 50)))
def test_targets_stay_within_the_servos_and_fixed_joints_at_zero(action):
    ctrl = ACTIONS.ctrl(action)
    low, high = MODEL.actuator_ctrlrange.T
    assert ctrl.shape == (3, MODEL.nu)
    assert np.all((ctrl >= low - 1e-12) & (ctrl <= high + 1e-12))
    assert not ctrl[:, [MODEL.actuator(f"lh_A_{name}").id for name in FIXED]].any()
    assert np.array_equal(ctrl, ACTIONS.ctrl(np.clip(action, -1, 1)))


@pytest.mark.parametrize("string_goal", ["simplified", "one_hot"])
@pytest.mark.parametrize("ahead", range(4))
def test_the_rows_of_an_observation_add_up(string_goal, ahead):
    config = TaskConfig(string_goal=string_goal, n_step_lookahead=ahead)
    batch = FrettingBatch([TUNE], config)
    sizes = {block.name: block.size for block in batch.blocks}
    assert batch.observe().shape == (1, sum(sizes.values())) == (1, batch.observation_size)
    assert sizes["string_goal"] == (6 if string_goal == "simplified" else 120) * (ahead + 1)
    assert sizes["keys"] == 120
    assert sizes["joints"] + sizes["forearm"] == MODEL.nq
    assert (sizes["fingers"], sizes["busy"], sizes["last_action"]) == (12, 4, 20)


def test_every_row_has_a_name_a_unit_and_a_meaning():
    blocks = observation_blocks(TaskConfig(), MODEL, TaskConfig().scene().guitar, 20)
    assert len({block.name for block in blocks}) == len(blocks)
    assert all(block.unit and block.meaning for block in blocks)


@given(st.floats(5, 120), st.integers(1, 30))
def test_a_tick_is_that_many_steps(control_hz, substeps):
    scene = TaskConfig(control_hz=control_hz, substeps=substeps).scene()
    assert scene.timestep_s * substeps * control_hz == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"control_hz": 0.0}, "above 0"),
        ({"control_hz": -30.0}, "above 0"),
        ({"control_hz": float("nan")}, "above 0"),
        ({"substeps": 0}, "from 1"),
        ({"n_step_lookahead": -1}, "from 0"),
        ({"guitar": "lute"}, "lute"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, message):
    with pytest.raises(RoboGuitaristError, match=message):
        replace(TaskConfig(), **settings).scene()
