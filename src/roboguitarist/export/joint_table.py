"""The joints' paths as a table in CSV."""

from __future__ import annotations

import csv
from pathlib import Path

import mujoco

from roboguitarist import replay, storage
from roboguitarist.performance import Performance

_UNIT = {int(mujoco.mjtJoint.mjJNT_SLIDE): "m", int(mujoco.mjtJoint.mjJNT_HINGE): "rad"}


def write_joints(performance: Performance, path: str | Path) -> None:
    """Write a line per control tick: the time in seconds and every joint of both hands.

    The header has the joints' names in the model with their units, such as `lh_FFJ3_rad`.

    Args:
        performance: What was done.
        path: File to write; it appears when it is complete.

    Raises:
        RoboGuitaristError: If the performance does not fit its scene, or the file cannot be
            written.
    """
    model = replay.scene(performance)
    joints = (model.joint(index) for index in range(model.njnt))
    header = ["time_s", *(f"{joint.name}_{_UNIT[int(joint.type[0])]}" for joint in joints)]
    with storage.replacing(path) as temporary, temporary.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(header)
        for time_s, qpos in zip(performance.time_s, performance.qpos, strict=True):
            table.writerow([f"{time_s:.6f}", *(f"{value:.6f}" for value in qpos)])
