import numpy as np
import pytest

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.env import FrettingEnv
from roboguitarist.tablature import Note, Tablature

stable_baselines3 = pytest.importorskip("stable_baselines3")

from stable_baselines3.common.env_checker import check_env  # noqa: E402

from roboguitarist.fretting.sb3 import FrettingVecEnv  # noqa: E402

TUNE = Tablature((Note(0.0, 3, 2, 0.2), Note(0.2, 2, 1, 0.2)))


@pytest.mark.parametrize("task", ["paper", "guided"])
def test_stable_baselines_accepts_the_environment(task):
    settings = {"task": task, "substeps": 16, "lead_s": 0.2}
    check_env(FrettingEnv(TUNE, **settings), warn=True)


def test_episodes_follow_each_other_in_one_step():
    envs = FrettingVecEnv(3, TUNE)
    first = envs.reset()
    length = int(envs.batch.bank.length[0])
    rest = np.zeros((3, 20), np.float32)
    for _ in range(length - 1):
        _, _, done, infos = envs.step(rest)
        assert not done.any()
        assert set(infos[0]) == {"key", "finger", "energy"}
    seen, reward, done, infos = envs.step_wait()
    assert done.all()
    assert infos[0]["TimeLimit.truncated"]
    assert np.array_equal(seen, first)
    assert not np.array_equal(infos[0]["terminal_observation"], first[0])
    assert reward.dtype == np.float32


def test_a_seed_repeats_the_episodes():
    drawn = []
    for _ in range(2):
        envs = FrettingVecEnv(8, [TUNE, "twinkle"], random_start=True)
        envs.seed(3)
        drawn.append(envs.reset())
    assert np.array_equal(*drawn)


def test_environments_share_their_attributes():
    envs = FrettingVecEnv(4, TUNE)
    assert envs.get_attr("num_envs") == [4] * 4
    assert envs.get_attr("num_envs", [0, 2]) == [4, 4]
    assert envs.env_is_wrapped(FrettingVecEnv, 1) == [False]
    with pytest.raises(RoboGuitaristError, match="all environments"):
        envs.set_attr("mark", 1, 0)
    envs.set_attr("mark", 1)
    assert envs.get_attr("mark") == [1] * 4


@pytest.mark.slow
def test_its_learners_learn_here():
    envs = FrettingVecEnv(8, TUNE, random_start=True)
    model = stable_baselines3.PPO("MlpPolicy", envs, n_steps=16, batch_size=64, n_epochs=1)
    model.learn(256)
    assert model.num_timesteps == 256
