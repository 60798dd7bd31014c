"""Looking at a policy: it plays whole pieces with both hands, without chance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from roboguitarist import metrics, plucking
from roboguitarist.fingering import assign
from roboguitarist.fretting import planner
from roboguitarist.fretting.policy import Policy
from roboguitarist.performance import PerformConfig, perform, scene_config
from roboguitarist.plan import HandPlan
from roboguitarist.tablature import Tablature
from roboguitarist.training.loop import Evaluation


def evaluator(
    tablatures: Mapping[str, Tablature], config: PerformConfig, metric: str = "frame"
) -> Callable[[Policy], Evaluation]:
    """What plays tablatures with a policy and measures it as `roboguitarist play` does.

    The score is the mean F1 of one metric over the tablatures.

    Args:
        tablatures: What is played, by name.
        config: How; its policy is left open.
        metric: `frame`, `frame_free`, `note` or `onset`.
    """
    fingerings = {name: assign(tablature) for name, tablature in tablatures.items()}
    scene = scene_config(config)
    right = {name: plucking.plan(one, scene) for name, one in fingerings.items()}
    left: dict[str, HandPlan] = {}

    def evaluate(policy: Policy) -> Evaluation:
        if policy.task == "guided" and not left:
            left.update({name: planner.plan(one, scene) for name, one in fingerings.items()})
        playing = replace(config, controller="policy", policy=policy)
        scalars: dict[str, float] = {}
        for name, fingering in fingerings.items():
            performance = perform(fingering, playing, left=left.get(name), right=right[name])
            scalars |= _flat(metrics.evaluate(performance).as_dict(), name)
        scores = [scalars.get(f"{name}/{metric}/f1", 0.0) for name in fingerings]
        return Evaluation(float(np.mean(scores)), scalars)

    return evaluate


def _flat(item: Mapping[str, Any], path: str) -> dict[str, float]:
    """Numbers in nested dictionaries by their path; what is not measured is left out."""
    out: dict[str, float] = {}
    for key, value in item.items():
        if isinstance(value, Mapping):
            out |= _flat(value, f"{path}/{key}")
        elif value is not None:
            out[f"{path}/{key}"] = float(value)
    return out
