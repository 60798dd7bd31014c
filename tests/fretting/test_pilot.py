import numpy as np
import pytest

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import assign
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.pilot import Pilot
from roboguitarist.fretting.policy import Policy
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.performance import PerformConfig, perform
from roboguitarist.scene import SceneConfig, build
from roboguitarist.tablature import Note, Tablature

TUNE = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4), Note(0.8, 1, 0, 0.2)))


def some_policy(size: int, acted: int, scale: float, hand: str = "linkage") -> Policy:
    rng = np.random.default_rng(0)

    def weights(*shape: int) -> np.ndarray:
        return rng.normal(0.0, 0.1, shape).astype(np.float32)

    return Policy(
        np.zeros(size, np.float32), np.ones(size, np.float32), weights(8, size), weights(8),
        weights(8, 8), weights(8), scale * weights(acted, 8), scale * weights(acted),
        "guided", hand, 30.0,
    )  # fmt: skip


@pytest.fixture(scope="module")
def batch() -> FrettingBatch:
    made = FrettingBatch([TUNE], TaskConfig("guided", substeps=16, lead_s=1.0))
    made.reset()
    return made


def test_a_policy_that_corrects_nothing_plays_as_the_planner_does(batch):
    idle = some_policy(batch.observation_size, batch.n_actions, 0.0)
    corrected = perform(assign(TUNE), PerformConfig(controller="policy", policy=idle))
    planned = perform(assign(TUNE), PerformConfig(controller="planner"))
    # The environment keeps the plan in single precision.
    assert corrected.qpos == pytest.approx(planned.qpos, abs=1e-3)
    assert np.array_equal(corrected.pluck_fret, planned.pluck_fret)


def test_on_stage_a_policy_moves_the_hand_as_in_training(batch):
    policy = some_policy(batch.observation_size, batch.n_actions, 1.0)
    performance = perform(assign(TUNE), PerformConfig(controller="policy", policy=policy))
    seen = batch.reset()
    for tick in range(20):
        seen, *_ = batch.step(policy.act(seen))
        there = performance.qpos[tick, : performance.left_nq]
        assert batch.hands.qpos[0] == pytest.approx(there, abs=2e-3)


def test_a_policy_for_another_hand_is_refused(batch):
    policy = some_policy(batch.observation_size, batch.n_actions, 1.0, "tendon")
    fingering, scene = assign(TUNE), SceneConfig(visuals=False)
    with pytest.raises(RoboGuitaristError, match="'tendon'"):
        Pilot(policy, fingering, scene, build(scene))
