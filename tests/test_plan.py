from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.plan import LEAD_IN_S, PLAN_HZ, SERVO_DELAY_S, HandPlan, plan_times
from roboguitarist.scene import SceneConfig, build


@given(st.floats(0, 600), st.floats(0, 5))
def test_times_begin_before_the_piece_and_end_after_it(duration_s, tail_s):
    time_s = plan_times(duration_s, tail_s)
    assert time_s[0] == -LEAD_IN_S
    assert duration_s + tail_s - 1 / PLAN_HZ - 1e-9 <= time_s[-1] <= duration_s + tail_s + 1e-9
    np.testing.assert_allclose(np.diff(time_s), 1 / PLAN_HZ, atol=1e-9)


def test_physics_steps_fit_into_the_samples_of_a_plan():
    substeps = 1 / (PLAN_HZ * build(SceneConfig(sides=(), visuals=False)).opt.timestep)
    assert substeps == pytest.approx(2)


def test_the_servos_delay_is_a_small_part_of_the_lead_in():
    assert 0 <= SERVO_DELAY_S < 0.02 < LEAD_IN_S


def test_save_and_load_keep_every_bit(tmp_path):
    rng = np.random.default_rng(0)
    time_s = plan_times(0.5)
    plan = HandPlan(time_s, rng.normal(size=(len(time_s), 24)), rng.normal(size=(len(time_s), 20)))
    plan.save(tmp_path / "plan.npz")
    loaded = HandPlan.load(tmp_path / "plan.npz")
    for name in ("time_s", "qpos", "ctrl"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(plan, name))


def test_other_files_are_refused(tmp_path):
    (tmp_path / "plan.npz").write_text("no plan")
    with pytest.raises(RoboGuitaristError, match=r"plan\.npz: not a saved HandPlan"):
        HandPlan.load(tmp_path / "plan.npz")
