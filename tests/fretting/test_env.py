import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from roboguitarist import pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.env import FrettingEnv, FrettingVectorEnv
from roboguitarist.registration import ids
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4), Note(0.8, 1, 0, 0.2)))


def rollout(env: FrettingVectorEnv, steps: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    seen, rewards = [env.reset(seed=seed)[0]], []
    for _ in range(steps):
        action = rng.uniform(-1, 1, (env.num_envs, 20)).astype(np.float32)
        observation, reward, _, _, _ = env.step(action)
        seen.append(observation)
        rewards.append(reward)
    return np.array(seen), np.array(rewards)


@pytest.mark.parametrize("hand", ["linkage", "tendon"])
@pytest.mark.filterwarnings("ignore:.*not within the observation space.*")
def test_gymnasium_accepts_the_environment(hand):
    check_env(FrettingEnv(TUNE, hand=hand), skip_render_check=True)


def test_names_are_known_to_gymnasium():
    env = gym.make("RoboGuitarist/Fretting-v0", score=TUNE)
    assert env.reset(seed=0)[0].shape == env.observation_space.shape
    assert ids()["RoboGuitarist/LongLongAgo-v0"] == "long-long-ago"
    assert set(ids()) <= set(gym.registry)
    assert len(ids()) == len(pieces.names()) + 1


def test_gymnasium_makes_vectors_of_it():
    envs = gym.make_vec("RoboGuitarist/Fretting-v0", num_envs=3, score=TUNE)
    seen, _ = envs.reset(seed=1)
    assert seen.shape == envs.observation_space.shape == (3, len(seen[0]))


def test_threads_and_batch_size_change_nothing():
    alone, many = FrettingVectorEnv(1, TUNE), FrettingVectorEnv(4, TUNE, n_threads=2)
    alone.reset(seed=0)
    many.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(20):
        action = rng.uniform(-1, 1, (1, 20)).astype(np.float32)
        one, reward, *_ = alone.step(action)
        four, rewards, *_ = many.step(np.repeat(action, 4, axis=0))
        assert np.array_equal(np.repeat(one, 4, axis=0), four)
        assert np.array_equal(np.repeat(reward, 4), rewards)


def test_a_seed_repeats_everything():
    env = FrettingVectorEnv(3, [TUNE, "twinkle"], random_start=True)
    first, again, other = (rollout(env, 30, seed) for seed in (5, 5, 6))
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[0], other[0])


def test_the_end_of_the_piece_truncates_and_a_new_episode_follows():
    env = FrettingVectorEnv(2, TUNE)
    env.reset(seed=0)
    length = int(env.batch.bank.length[0])
    rest = np.zeros((2, 20), np.float32)
    for tick in range(length):
        _, _, terminated, truncated, _ = env.step(rest)
        assert not terminated.any()
        assert truncated.all() == (tick == length - 1)
    _, reward, _, truncated, _ = env.step(rest)
    assert not truncated.any()
    assert not reward.any()
    assert (env.batch.tick == 0).all()


def test_reward_terms_are_in_range_and_add_up():
    env = FrettingVectorEnv(8, TUNE, random_start=True)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(30):
        _, reward, _, _, terms = env.step(rng.uniform(-1, 1, (8, 20)).astype(np.float32))
        assert np.all((terms["key"] >= 0) & (terms["key"] <= 1))
        assert np.all((terms["finger"] >= 0) & (terms["finger"] <= 1))
        assert np.all(terms["energy"] <= 0)
        total = 0.5 * terms["key"] + 0.5 * terms["finger"] + terms["energy"]
        started = reward != 0
        assert reward[started] == pytest.approx(total[started])


def test_observations_are_not_shared_between_steps():
    env = FrettingEnv(TUNE)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    env.step(env.action_space.sample())
    assert np.array_equal(first, kept)


def test_pressing_is_seen_and_paid():
    # The planner's posture for the note, held by its own targets.
    from roboguitarist.fingering import assign  # noqa: PLC0415
    from roboguitarist.fretting.planner import plan  # noqa: PLC0415

    env = FrettingVectorEnv(1, TUNE)
    env.reset(seed=0)
    batch = env.batch
    planned = plan(assign(TUNE))
    start = np.searchsorted(planned.time_s, -batch.config.lead_s)
    batch.hands.put(np.array([0]), planned.qpos[start][None])
    key = []
    for tick in range(20):
        now = start + round(tick * 240 / batch.config.control_hz)
        batch.hands.step(planned.ctrl[now][None])
        batch.tick += 1
        key.append(float(batch.task.reward(batch.hands, batch.at, np.zeros((1, 20)))[1]["key"][0]))
    assert max(key) > 0.95
    pressed = batch.observe()[0][27 : 27 + 120]
    assert pressed.sum() == 1


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"colour": 1}, "n_step_lookahead"), ({"control_hz": 0}, "Hz"), ({"guitar": "lute"}, "lute")],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(RoboGuitaristError, match=message):
        FrettingEnv(TUNE, **settings)


def test_hands_differ_where_they_are_to_and_only_there():
    same = FrettingVectorEnv(3, "twinkle")
    varied = FrettingVectorEnv(3, "twinkle", vary_friction=0.3, vary_gain=0.2)
    for envs, differ in ((same, False), (varied, True)):
        envs.reset(seed=0)
        action = np.tile(np.linspace(-1, 1, envs.batch.n_actions, dtype=np.float32), (3, 1))
        for _ in range(5):
            envs.step(action)
        assert (np.ptp(envs.batch.hands.qpos, axis=0).max() > 1e-3) == differ
        envs.close()
    with pytest.raises(RoboGuitaristError, match="friction"):
        FrettingVectorEnv(1, "twinkle", vary_friction=1.5)
