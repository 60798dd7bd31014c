import numpy as np
import pytest

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.fretting.paper import Actions
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.guitar import Guitar
from roboguitarist.scene import SceneConfig

SCENE = TaskConfig().scene()


def batch(n_envs: int, n_threads: int = 0, **settings) -> HandBatch:
    config = TaskConfig(**settings)
    hands = HandBatch(config.scene(), n_envs, config.control_hz, n_threads)
    hands.put(np.arange(n_envs), np.tile(hands.model.qpos0, (n_envs, 1)))
    return hands


def targets(hands: HandBatch, ticks: int, seed: int = 0) -> np.ndarray:
    actions, rng = Actions(hands.model), np.random.default_rng(seed)
    return np.array([actions.ctrl(rng.uniform(-1, 1, (1, actions.size))) for _ in range(ticks)])


def trajectory(hands: HandBatch, ctrl: np.ndarray) -> np.ndarray:
    seen = []
    for row in ctrl:
        assert not hands.step(np.broadcast_to(row, (hands.n_envs, row.shape[-1]))).any()
        force = hands.press_force_n().reshape(hands.n_envs, -1)
        tips = hands.tip_m.reshape(hands.n_envs, -1)
        seen.append(np.hstack([hands.qpos, hands.qvel, tips, force, hands.power_w()[:, None]]))
    return np.array(seen)


@pytest.mark.parametrize("hand", ["linkage", "tendon"])
def test_neither_threads_nor_copies_change_a_trajectory(hand):
    alone = batch(1, hand=hand)
    ctrl = targets(alone, 15)
    expected = trajectory(alone, ctrl)
    assert np.ptp(expected, axis=0).max() > 0.1
    for n_threads in (0, 1, 2):
        many = trajectory(batch(4, n_threads, hand=hand), ctrl)
        assert np.array_equal(many, np.repeat(expected, 4, axis=1))


def test_a_copy_minds_its_own_targets_only():
    one, other = batch(2), batch(2)
    ctrl = targets(one, 10)
    for row in ctrl:
        one.step(np.repeat(row, 2, axis=0))
        other.step(np.vstack([row, np.zeros_like(row)]))
    assert np.array_equal(one.qpos[0], other.qpos[0])
    assert not np.allclose(one.qpos[1], other.qpos[1], atol=1e-3)


def test_a_copy_is_put_at_rest_and_its_sensors_say_where():
    hands = batch(3)
    for row in targets(hands, 5):
        hands.step(np.repeat(row, 3, axis=0))
    qpos, tips = hands.qpos.copy(), hands.tip_m
    moved = hands.model.qpos0 + np.eye(hands.model.nq)[0] * 0.1
    hands.put(np.array([1]), moved[None])
    assert np.array_equal(hands.qpos[1], moved)
    assert not hands.qvel[1].any()
    assert hands.tip_m[1] != pytest.approx(tips[1], abs=1e-3)
    assert np.array_equal(hands.qpos[[0, 2]], qpos[[0, 2]])
    assert np.array_equal(hands.tip_m[[0, 2]], tips[[0, 2]])
    before = hands.tip_m[1]
    hands.put(np.array([1]), (moved + np.eye(len(moved))[0] * 0.02)[None])
    # forearm_x slides along the neck.
    assert np.linalg.norm(hands.tip_m[1] - before, axis=1) == pytest.approx(0.02)


def test_what_sensors_say_has_a_place_for_every_key():
    hands = batch(2)
    assert hands.press_force_n().shape == (2, 6, Guitar().n_frets)
    assert hands.sounding_fret().shape == (2, 6)
    assert hands.tip_m.shape == (2, 4, 3)
    assert np.all(hands.power_w() >= 0)
    assert not hands.press_force_n().any()
    assert not hands.sounding_fret().any()


@pytest.mark.parametrize(("field", "value"), [("qpos", np.nan), ("qvel", np.inf), ("qvel", 1e12)])
def test_a_broken_copy_becomes_finite_and_harms_no_other(field, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it is run
    hands, sound = batch(3), batch(3)
    ctrl = targets(hands, 4)
    getattr(hands, field)[1] = value
    for row in ctrl:
        hands.step(np.repeat(row, 3, axis=0))
        sound.step(np.repeat(row, 3, axis=0))
        assert np.isfinite(hands.qpos).all()
        assert np.isfinite(hands.qvel).all()
        assert np.isfinite(hands.tip_m).all()
    assert np.array_equal(hands.qpos[[0, 2]], sound.qpos[[0, 2]])
    assert np.array_equal(hands.tip_m[[0, 2]], sound.tip_m[[0, 2]])


@pytest.mark.parametrize("substeps", [1, 10])
@pytest.mark.parametrize("value", [np.nan, 1e12])
def test_a_broken_copy_is_counted(value, substeps, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    hands = batch(3, substeps=substeps, control_hz=300.0 / substeps)
    rest = np.zeros((3, hands.model.nu))
    hands.qvel[1] = value
    assert hands.step(rest).tolist() == [False, True, False]
    assert hands.n_failures == 1
    assert not hands.step(rest).any()
    assert hands.n_failures == 1


def test_a_joint_thrown_far_outside_its_range_is_a_failure_too():
    hands = batch(3)
    rest = np.zeros((3, hands.model.nu))
    joint = hands.model.joint("lh_MFJ3").qposadr[0]
    hands._widest[1, joint] = 0.5  # a joint limit that strong is not thrown far so easily
    hands.qpos[1, joint] = 1.2
    assert hands.step(rest).tolist() == [False, True, False]
    assert hands.n_failures == 1
    assert hands.qpos[1] == pytest.approx(hands.model.qpos0)
    assert not hands.qvel[1].any()
    assert not hands.step(rest).any()


@pytest.mark.parametrize(
    ("n_envs", "control_hz", "timestep_s"),
    [(0, 30.0, 1 / 300), (1, 30.0, 1 / 310), (1, 400.0, 1 / 300), (1, 30.0, 0.1)],
)
def test_rates_that_do_not_fit_are_refused(n_envs, control_hz, timestep_s):
    scene = SceneConfig(SCENE.guitar, "linkage", ("left",), timestep_s, visuals=False)
    with pytest.raises(RoboGuitaristError, match="whole steps in a tick"):
        HandBatch(scene, n_envs, control_hz)


def test_closing_twice_does_no_harm():
    hands = batch(2, n_threads=2)
    hands.step(np.zeros((2, hands.model.nu)))
    hands.close()
    hands.close()
