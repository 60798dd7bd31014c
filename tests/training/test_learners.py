from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("torch")

from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.performance import PerformConfig
from roboguitarist.tablature import Note, Tablature
from roboguitarist.training.evaluation import evaluator
from roboguitarist.training.learners import make
from roboguitarist.training.settings import (
    ALGORITHMS,
    PAPER_PPO,
    PAPER_TASK,
    TrainConfig,
    defaults,
)

TUNE = Tablature((Note(0.0, 3, 2, 0.8), Note(0.8, 3, 1, 0.8)))
TASK = replace(PAPER_TASK, substeps=10, max_ticks=60, lead_s=0.5, n_step_lookahead=1)
MARGIN = 0.1
"""By which reward per tick and F1 have to be better than those of who learned nothing."""


def reward_of(act) -> float:
    """Mean reward of a tick over the whole tune, played without noise of the learner's."""
    batch = FrettingBatch([TUNE], replace(TASK, random_start=False, max_ticks=0))
    seen, rewards, ended = batch.reset(), [], np.zeros(1, bool)
    while not ended.any():
        seen, reward, ended, _ = batch.step(act(seen))
        rewards.append(reward[0])
    return float(np.mean(rewards))


@pytest.mark.slow
def test_half_a_minute_of_learning_beats_chance_and_doing_nothing():
    ppo = replace(PAPER_PPO, steps=45_000, ticks=16, minibatch=256, hidden=64, learning_rate=2e-3)
    config = TrainConfig("batch-ppo", ppo, TASK, n_envs=32, n_threads=2)
    learner = make(config, {"tune": TUNE})
    untrained = learner.policy()  # holds the hand where it begins
    evaluate = evaluator({"tune": TUNE}, PerformConfig("tendon"))
    assert evaluate(untrained).scalars["tune/frame/f1"] == 0.0
    idle = reward_of(untrained.act)
    rng = np.random.default_rng(0)
    chance = reward_of(lambda seen: rng.uniform(-1, 1, (1, 20)))

    for _ in learner.learn():
        pass
    trained = learner.policy()
    assert reward_of(trained.act) > max(idle, chance) + MARGIN
    found = evaluate(trained)
    assert found.score == found.scalars["tune/frame/f1"] > MARGIN
    assert {"tune/note/f1", "tune/motion/jerk"} <= set(found.scalars)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_settings_are_what_they_were_saved_as(algorithm):
    config = defaults(algorithm)
    assert TrainConfig.of(config.as_dict()) == config


def test_the_papers_table_2_is_the_default_of_droq():
    config = defaults("droq")
    learner = config.learner
    assert config.n_envs == 4
    assert {
        "batch_size": 512, "dropout_rate": 0.01, "learning_starts": 50_000, "steps": 5_000_000,
        "seed": 42, "buffer_size": 1_000_000, "learning_rate": 3e-4, "discount": 0.84,
    }.items() <= vars(learner).items()  # fmt: skip
    assert (config.task.hand, config.task.mapping, config.task.freedom) == (
        "tendon", "reciprocal", False,
    )  # fmt: skip
