from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("sbx")

from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature
from roboguitarist.training import checkpoint
from roboguitarist.training.sbx_learner import CHUNK_TICKS, SbxLearner
from roboguitarist.training.settings import SbxConfig

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4)))
CHUNK = 2 * CHUNK_TICKS
CONFIG = SbxConfig(
    steps=3 * CHUNK, batch_size=8, buffer_size=200, learning_starts=CHUNK, hidden=16,
    gradient_steps=2, rollout_ticks=CHUNK_TICKS,
)  # fmt: skip
ALGORITHMS = ("droq", "crossq", "tqc", "ppo")  # sac is droq with a plainer critic


def learner(algorithm: str) -> SbxLearner:
    task = TaskConfig(hand="tendon", random_start=True, max_ticks=20)
    return SbxLearner(FrettingBatch([TUNE], task, 2), algorithm, CONFIG)


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_learner_exports_what_it_plays_and_goes_on_as_if_unbroken(algorithm, tmp_path):
    unbroken = learner(algorithm)
    learning = unbroken.learn()
    next(learning)
    next(learning)
    checkpoint.save(tmp_path / "a.pt", unbroken.state())
    seen = unbroken.batch.observe()
    mean, _ = unbroken.model.predict(seen, deterministic=True)
    assert unbroken.policy().act(seen) == pytest.approx(mean, abs=1e-5)
    assert unbroken.policy().task_config() == unbroken.batch.config

    restored = learner(algorithm)
    restored.restore(checkpoint.load(tmp_path / "a.pt"))
    assert restored.steps == 2 * CHUNK
    assert np.array_equal(restored.policy().weight_1, unbroken.policy().weight_1)
    before = np.random.get_state()  # noqa: NPY002 - both learners draw from the global one
    (there,) = unbroken.learn()
    np.random.set_state(before)  # noqa: NPY002
    (here,) = restored.learn()
    assert here.steps == there.steps == 3 * CHUNK
    assert replace(here, per_s=0) == replace(there, per_s=0)
    assert {"key", "finger", "energy"} <= set(here.terms)
    assert np.array_equal(restored.policy().weight_1, unbroken.policy().weight_1)
