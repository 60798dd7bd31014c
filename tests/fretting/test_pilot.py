from dataclasses import replace

import numpy as np
import pytest

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import assign
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.pilot import Pilot
from roboguitarist.fretting.policy import Policy, settings_of
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


# Where the policy begins later than the stage, the hand has settled a little by then.
@pytest.mark.parametrize(("lead_s", "settled"), [(0.5, 0.15), (1.0, 5e-3)])
def test_on_stage_a_policy_of_the_papers_task_moves_the_hand_as_in_training(lead_s, settled):
    config = TaskConfig(hand="tendon", substeps=16, lead_s=lead_s, n_step_lookahead=3)
    batch = FrettingBatch([TUNE], config)
    policy = replace(
        some_policy(batch.observation_size, batch.n_actions, 1.0, "tendon"),
        task="paper", squashed=True, activation="relu", settings=settings_of(config),
    )  # fmt: skip
    performance = perform(assign(TUNE), PerformConfig("tendon", controller="policy", policy=policy))
    seen = batch.reset()
    first = round((1.0 - lead_s) * performance.control_hz)
    for tick in range(12):
        seen, *_ = batch.step(policy.act(seen))
        there = performance.qpos[first + tick, : performance.left_nq]
        assert batch.hands.qpos[0] == pytest.approx(there, abs=settled)


def test_a_policy_that_fits_no_plan_is_refused():
    policy = replace(some_policy(4, 20, 1.0), task="paper", control_hz=27.0)
    scene = SceneConfig(visuals=False)
    with pytest.raises(RoboGuitaristError, match="27 Hz"):
        Pilot(policy, assign(TUNE), scene, build(scene))
