import numpy as np
import pytest

from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature

torch = pytest.importorskip("torch")

from roboguitarist.fretting.branching import Branching, BranchingConfig  # noqa: E402
from roboguitarist.training import checkpoint  # noqa: E402

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4)))
CONFIG = BranchingConfig(steps=300, copies=4, ticks=8, minibatch=64, hidden=16)


def learner(config: BranchingConfig = CONFIG) -> Branching:
    task = TaskConfig("guided", substeps=10, lead_s=0.5, random_start=True)
    return Branching(FrettingBatch([TUNE], task, 8), config)


def test_a_seed_repeats_the_learning():
    first, second = learner(), learner()
    reports = list(first.learn()), list(second.learn())
    assert [p.reward for p in reports[0]] == [p.reward for p in reports[1]]
    assert np.array_equal(first.policy().weight_2, second.policy().weight_2)
    assert reports[0][-1].steps >= CONFIG.steps


def test_offsets_are_opposite_pairs_and_the_leader_has_none():
    offsets = learner()._offsets(0.2).unflatten(0, (2, 4))
    assert not offsets[:, :2].any()
    assert torch.equal(offsets[:, 2], -offsets[:, 3])
    assert not torch.equal(offsets[0, 2], offsets[1, 2])


def test_after_a_window_all_are_where_their_leader_is():
    branching = learner()
    next(iter(branching.learn()))
    qpos = branching.batch.hands.qpos
    assert np.array_equal(qpos, qpos[branching.leaders])
    assert not np.array_equal(qpos[0], qpos[4])
    seen = branching.batch.observe()
    assert np.array_equal(seen, seen[branching.leaders])


def test_advantages_by_hand():
    branching = learner(BranchingConfig(copies=4, discount=0.5))
    reward = torch.tensor([[1.0, 3.0, 1.0, 3.0], [4.0, 0.0, 0.0, 0.0]])[..., None].repeat(1, 2, 5)
    ended = torch.zeros((2, 8), dtype=torch.bool)
    out = branching._advantages(reward, ended)[..., 0]
    # Sums are 3, 3, 1, 3 and 4, 0, 0, 0; of each row and group the mean is taken off.
    expected = torch.tensor([[0.5, 0.5, -1.5, 0.5], [3.0, -1.0, -1.0, -1.0]]).repeat(1, 2)
    assert torch.allclose(out, expected / expected.std(), atol=1e-5)
    cut = branching._advantages(reward, ~ended)[0, :4, 0]
    assert torch.allclose(cut / cut[0], torch.tensor([1.0, -1.0, 1.0, -1.0]))


def test_a_restored_learner_goes_on_as_the_unbroken_one(tmp_path):
    unbroken, other = learner(), learner()
    going = unbroken.learn()
    next(going)
    checkpoint.save(tmp_path / "a.pt", unbroken.state())
    other.restore(checkpoint.load(tmp_path / "a.pt"))
    assert [p.reward for p in other.learn()] == [p.reward for p in going]
    assert np.array_equal(other.policy().weight_1, unbroken.policy().weight_1)
