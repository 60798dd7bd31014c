from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.policy import Policy, settings_of
from roboguitarist.fretting.task import TaskConfig


def random_policy(seen: int = 7, hidden: int = 5, acted: int = 3, seed: int = 0) -> Policy:
    rng = np.random.default_rng(seed)

    def weights(*shape: int) -> np.ndarray:
        return rng.normal(0.0, 0.3, shape).astype(np.float32)

    return Policy(
        weights(seen), np.ones(seen, np.float32), weights(hidden, seen), weights(hidden),
        weights(hidden, hidden), weights(hidden), weights(acted, hidden), weights(acted),
        "guided", "linkage", 30.0,
    )  # fmt: skip


def test_saved_is_loaded(tmp_path):
    policy = random_policy()
    policy.save(tmp_path / "policy.npz")
    again = Policy.load(tmp_path / "policy.npz")
    seen = np.random.default_rng(1).normal(size=(4, 7)).astype(np.float32)
    assert np.array_equal(again.act(seen), policy.act(seen))
    assert (again.task, again.hand, again.control_hz) == ("guided", "linkage", 30.0)


def test_act_by_hand():
    one = np.ones((1, 1), np.float32)
    zero = np.zeros(1, np.float32)
    policy = Policy(zero, one[0], one, zero, one, zero, one, zero, "guided", "linkage", 30.0)
    elu = np.expm1(np.expm1(-0.5))
    assert policy.act(np.array([[0.5], [-0.5]])) == pytest.approx(np.array([[0.5], [elu]]))


@given(st.integers(0, 100))
def test_actions_are_cut(seed):
    policy = random_policy(seed=seed)
    wild = replace(policy, weight_3=100 * policy.weight_3)
    acted = wild.act(np.random.default_rng(seed).normal(0, 100, (20, 7)))
    assert np.abs(acted).max() <= 1.0


def test_weights_that_do_not_fit_are_refused():
    policy = random_policy()
    with pytest.raises(RoboGuitaristError, match="bias_2"):
        replace(policy, bias_2=policy.bias_2[1:])
    with pytest.raises(RoboGuitaristError, match="weight_1"):
        replace(policy, weight_1=policy.weight_1 * np.nan)
    with pytest.raises(RoboGuitaristError, match="sees 7"):
        policy.act(np.zeros((1, 8)))


def test_another_file_is_refused(tmp_path):
    (tmp_path / "x.npz").write_bytes(b"no policy")
    with pytest.raises(RoboGuitaristError, match="not a saved Policy"):
        Policy.load(tmp_path / "x.npz")


def test_units_and_squashing_by_hand():
    one = np.ones((1, 1), np.float32)
    zero = np.zeros(1, np.float32)
    policy = Policy(zero, one[0], one, zero, one, zero, one, zero, "paper", "tendon", 30.0)
    seen = np.array([[0.5], [-0.5]])
    relu = replace(policy, activation="relu", squashed=True)
    assert relu.act(seen) == pytest.approx(np.tanh([[0.5], [0.0]]))
    tanh = np.tanh(np.tanh(0.5))
    assert replace(policy, activation="tanh").act(seen) == pytest.approx(
        np.array([[tanh], [-tanh]])
    )
    with pytest.raises(RoboGuitaristError, match="elu, relu, tanh"):
        replace(policy, activation="gelu")


def test_a_policy_knows_its_task():
    config = TaskConfig(hand="tendon", n_step_lookahead=7, freedom=True)
    policy = replace(random_policy(), task="paper", hand="tendon", settings=settings_of(config))
    assert policy.task_config() == config
    assert random_policy().task_config() == TaskConfig("guided", "linkage")
    for settings in ('{"nonsense": 1}', "[1", "[]"):
        with pytest.raises(RoboGuitaristError, match="settings"):
            replace(policy, settings=settings).task_config()
