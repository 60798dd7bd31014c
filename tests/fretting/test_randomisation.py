import numpy as np
import pytest

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.randomisation import Randomisation, delays, varied
from roboguitarist.scene import SceneConfig

SCENE = SceneConfig(sides=("left",), timestep_s=1 / 300, visuals=False)


@pytest.fixture(scope="module")
def model():
    return left_alone(SCENE)


def test_nothing_changes_by_default(model):
    same = varied(model, Randomisation(), np.random.default_rng(0))
    assert np.array_equal(same.geom_friction, model.geom_friction)
    assert np.array_equal(same.actuator_gainprm, model.actuator_gainprm)
    assert np.array_equal(same.geom_pos, model.geom_pos)


def test_each_range_changes_what_it_names_and_keeps_within(model):
    config = Randomisation(friction=0.3, gain=0.2, string_height_m=0.0005)
    rng = np.random.default_rng(0)
    others = [varied(model, config, rng) for _ in range(20)]
    friction = np.array([other.geom_friction[0, 0] / model.geom_friction[0, 0] for other in others])
    assert 0.7 <= friction.min() < 0.85
    assert 1.15 < friction.max() <= 1.3
    gain = np.array(
        [other.actuator_gainprm[:, 0] / model.actuator_gainprm[:, 0] for other in others]
    )
    assert 0.8 <= gain.min() < 0.85
    assert 1.15 < gain.max() <= 1.2
    for other, factor in zip(others, gain, strict=True):
        # A position servo stays one: its bias follows its gain.
        assert other.actuator_biasprm[:, 1] == pytest.approx(factor * model.actuator_biasprm[:, 1])
    string = model.geom("string_3").id
    height = np.array([other.geom_pos[string, 2] - model.geom_pos[string, 2] for other in others])
    assert -0.0005 <= height.min() < -0.0003
    assert 0.0003 < height.max() <= 0.0005
    board = model.geom("fretboard").id
    assert all(np.array_equal(other.geom_pos[board], model.geom_pos[board]) for other in others)


def test_delays_are_whole_steps_within_the_tick():
    late = delays(Randomisation(delay_s=0.01), 200, 1 / 300, 10, np.random.default_rng(0))
    assert set(late.tolist()) == {0, 1, 2, 3}
    with pytest.raises(RoboGuitaristError, match="less than a tick"):
        delays(Randomisation(delay_s=0.04), 1, 1 / 300, 10, np.random.default_rng(0))


def moved(randomisation: Randomisation | None, seed: int = 0) -> np.ndarray:
    hands = HandBatch(SCENE, 6, 30.0, randomisation=randomisation, seed=seed)
    hands.put(np.arange(6), np.zeros((6, hands.model.nq)))
    ctrl = np.full((6, hands.model.nu), 0.1)
    path = [(hands.step(ctrl), hands.qpos.copy())[1] for _ in range(5)]
    hands.close()
    return np.array(path)


def test_a_seed_repeats_the_hands_and_others_differ():
    config = Randomisation(gain=0.3)
    assert np.array_equal(moved(config), moved(config))
    assert not np.array_equal(moved(config), moved(config, 1))
    apart = np.ptp(moved(config)[-1], axis=0)
    assert apart.max() > 1e-4
    assert np.ptp(moved(None)[-1], axis=0).max() == 0.0


def test_a_late_hand_moves_later():
    prompt, late = moved(None), moved(Randomisation(delay_s=0.03), 3)
    slowest = np.abs(late[0]).sum(axis=1).min()
    assert slowest < 0.5 * np.abs(prompt[0]).sum(axis=1).min()
    assert late[-1] == pytest.approx(prompt[-1], abs=0.1)


@pytest.mark.parametrize("field", ["friction", "gain", "string_height_m", "delay_s"])
def test_impossible_ranges_are_refused(field):
    with pytest.raises(RoboGuitaristError, match="0 or more"):
        Randomisation(**{field: -0.1})
