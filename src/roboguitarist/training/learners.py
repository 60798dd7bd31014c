"""From settings to a learner."""

from __future__ import annotations

from collections.abc import Mapping

from roboguitarist.fretting.branching import Branching, BranchingConfig
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.learner import Learner
from roboguitarist.fretting.ppo import PPO, PPOConfig
from roboguitarist.tablature import Tablature
from roboguitarist.training.practice import planned
from roboguitarist.training.settings import TrainConfig


def make(config: TrainConfig, tablatures: Mapping[str, Tablature]) -> Learner:
    """The learner of a run, with its environments.

    Raises:
        RoboGuitaristError: If a setting makes no sense, or sbx is needed and not installed.
    """
    several = list(tablatures.values())
    plans = planned(several, config.task) if config.exercises else None
    batch = FrettingBatch(several, config.task, config.n_envs, config.n_threads, plans)
    if isinstance(config.learner, PPOConfig):
        return PPO(batch, config.learner)
    if isinstance(config.learner, BranchingConfig):
        return Branching(batch, config.learner)
    from roboguitarist.training.sbx_learner import SbxLearner  # noqa: PLC0415 - slow to import

    return SbxLearner(batch, config.algorithm, config.learner)
