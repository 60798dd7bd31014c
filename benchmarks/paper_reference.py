"""What the runs are compared with: the planner in physics, and its joint paths without physics."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import mujoco
import numpy as np

from roboguitarist import formats, metrics, pieces
from roboguitarist.fingering import assign
from roboguitarist.fretting.planner import plan
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.presses import tip_height
from roboguitarist.hands import Variant
from roboguitarist.performance import Performance, PerformConfig, perform, scene_config
from roboguitarist.scene import LEFT_TIPS

TOUCH_M = 0.001
"""A fingertip that near to its height on the string counts as pressing, when nothing is forced."""


def reference(piece: str, hand: Variant = "tendon") -> dict[str, Any]:
    """Metrics of the planner with physics, and `frame` of its joint paths without.

    The latter stands where the paper compares itself with Handrix (ElKoura and Singh 2003), which
    is kinematic too: it says what the fingering allows, and physics costs.
    """
    config = PerformConfig(hand)
    fingering = assign(formats.load(pieces.path(piece)))
    planned = perform(fingering, config)
    ideal = kinematic(planned, fingering, config)
    frame = metrics.frame(ideal, ideal.tablature)
    return {
        "planner": metrics.evaluate(planned).as_dict(),
        "kinematic": {"frame": None if frame is None else asdict(frame)},
    }


def kinematic(planned: Performance, fingering: Any, config: PerformConfig) -> Performance:
    """The performance as it would be if the joints were exactly where the planner wants them."""
    scene = scene_config(config)
    guitar, model, path = scene.guitar, left_alone(scene), plan(fingering, scene)
    data = mujoco.MjData(model)
    force_n = np.zeros_like(planned.press_force_n)
    for tick, time_s in enumerate(planned.time_s):
        data.qpos[:] = path.qpos[min(np.searchsorted(path.time_s, time_s), len(path.qpos) - 1)]
        mujoco.mj_kinematics(model, data)
        for tip in LEFT_TIPS:
            x, y, z = data.site(tip).xpos
            strings = guitar.string_y(np.arange(1, 7), x)
            string = int(np.argmin(np.abs(strings - y)))
            fret = int(guitar.fret_at(x))
            if z <= tip_height(guitar) + TOUCH_M and 1 <= fret <= force_n.shape[2]:
                force_n[tick, string, fret - 1] = 2.0
    return replace(planned, press_force_n=force_n)
