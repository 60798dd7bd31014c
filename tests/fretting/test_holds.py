import numpy as np
import pytest

from roboguitarist.exercises.shapes import BARRE_CHORDS, OPEN_CHORDS, Shape
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.holds import SearchConfig, hold, planned
from roboguitarist.scene import SceneConfig

SCENE = SceneConfig(sides=("left",), timestep_s=1 / 300, visuals=False)


@pytest.fixture(scope="module")
def hands() -> HandBatch:
    return HandBatch(SCENE, 48, n_threads=2)


def test_the_planned_shape_has_targets_within_the_servos_ranges(hands):
    ready, ctrl = planned(OPEN_CHORDS[0], SCENE)
    assert ready.shape == (hands.model.nq,)
    low, high = hands.model.actuator_ctrlrange.T
    assert ((ctrl >= low - 1e-9) & (ctrl <= high + 1e-9)).all()


def test_one_finger_holds_one_string_firmly_and_steadily(hands):
    one = Shape("", ((3, 5, 1),))
    found = hold(one, hands, SCENE, SearchConfig(rounds=3))
    assert found.held
    assert found.reason == ""
    assert found.force_n[0] >= 2.0
    ready, _ = planned(one, SCENE)
    hands.put(np.arange(hands.n_envs), np.tile(ready, (hands.n_envs, 1)))
    force = []
    for _ in range(60):
        hands.step(np.tile(found.ctrl, (hands.n_envs, 1)))
        force.append(hands.press_force_n()[0, 2, 4])
    last = np.array(force[30:])
    assert 1.0 < last.mean() < 6.0
    assert np.ptp(last) < 0.05 * last.mean()  # it does not buzz


@pytest.mark.slow
def test_a_barre_with_two_more_frets_holds_all_six_strings(hands):
    f_chord = BARRE_CHORDS[0]
    found = hold(f_chord, hands, SCENE, SearchConfig(rounds=14))
    assert len(found.force_n) == 6
    assert found.held
    assert min(found.force_n) >= 1.0


def test_a_place_beyond_every_finger_is_not_held_and_says_so(hands):
    far = Shape("", ((1, 2, 1), (1, 2, 1), (6, 9, 2)))
    found = hold(far, hands, SCENE, SearchConfig(rounds=2))
    assert not found.held
    assert found.reason in {"reach", "finger width"}


def test_the_same_seed_finds_the_same(hands):
    shape, config = Shape("", ((2, 3, 2), (4, 4, 3))), SearchConfig(rounds=2)
    first, second = (hold(shape, hands, SCENE, config, seed=1) for _ in range(2))
    assert first.force_n == second.force_n
    assert np.array_equal(first.ctrl, second.ctrl)
