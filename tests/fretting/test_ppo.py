import copy

import numpy as np
import pytest

from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

torch = pytest.importorskip("torch")

from roboguitarist.fretting.ppo import PPO, PPOConfig  # noqa: E402

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4)))
CONFIG = PPOConfig(steps=16 * 8 * 3, ticks=8, minibatch=64, hidden=16, warm_up=0)


def learner(config: PPOConfig = CONFIG) -> PPO:
    task = TaskConfig("guided", substeps=16, lead_s=1.0, random_start=True)
    return PPO(FrettingBatch([TUNE], task, 16), config)


def test_a_seed_repeats_the_learning():
    first, second = learner(), learner()
    reports = list(first.learn()), list(second.learn())
    assert [p.reward for p in reports[0]] == [p.reward for p in reports[1]]
    assert np.array_equal(first.policy().weight_2, second.policy().weight_2)
    assert reports[0][-1].steps == CONFIG.steps


def test_the_exported_policy_is_the_mean_of_the_learner():
    ppo = learner()
    list(ppo.learn())
    seen = ppo.batch.reset()
    with torch.no_grad():
        mean = ppo.actor(ppo._seen(seen)).clamp(-1, 1).numpy()
    assert ppo.policy().act(seen) == pytest.approx(mean, abs=1e-5)


def test_a_restored_learner_has_the_same_weights_and_goes_on():
    ppo = learner()
    next(iter(ppo.learn()))
    other = learner()
    other.restore(ppo.state())
    assert np.array_equal(ppo.policy().weight_1, other.policy().weight_1)
    assert [p.steps for p in other.learn()] == [256, 384]


def test_a_restored_learner_goes_on_as_the_unbroken_one():
    unbroken, restored = learner(), learner()
    learning = unbroken.learn()
    next(learning)
    restored.restore(copy.deepcopy(unbroken.state()))
    assert [p.reward for p in restored.learn()] == [p.reward for p in learning]
    assert np.array_equal(restored.policy().weight_1, unbroken.policy().weight_1)


def test_advantages_by_hand():
    ppo = learner(PPOConfig(discount=0.5, trace=0.5))
    value = torch.tensor([[[1.0]], [[2.0]]])
    following, reward = torch.tensor([[[2.0]], [[4.0]]]), torch.tensor([[[2.0]], [[2.0]]])
    going, cut = torch.tensor([[False], [False]]), torch.tensor([[True], [False]])
    # Surprises are .5 * 2 + .5 * 2 - 1 = 1 and .5 * 2 + .5 * 4 - 2 = 1.
    assert ppo._advantages(value, following, reward, going).flatten().tolist() == [1.25, 1.0]
    assert ppo._advantages(value, following, reward, cut).flatten().tolist() == [1.0, 1.0]


def test_the_actor_waits_for_the_critic():
    ppo = learner(PPOConfig(steps=16 * 8 * 2, ticks=8, minibatch=64, hidden=16, warm_up=1))
    before, critic = ppo.policy().weight_1, next(ppo.critic.parameters()).detach().clone()
    going = ppo.learn()
    next(going)
    assert np.array_equal(ppo.policy().weight_1, before)
    assert not torch.equal(next(ppo.critic.parameters()), critic)
    next(going)
    assert not np.array_equal(ppo.policy().weight_1, before)
