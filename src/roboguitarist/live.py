"""A performance in MuJoCo's own viewer, at the pace at which it was played."""

from __future__ import annotations

import os
import sys
import time

import mujoco

from roboguitarist import replay
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.performance import Performance


def has_screen() -> bool:
    """Whether windows can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def show(performance: Performance) -> None:
    """Open a window and play a performance in it, over and over, until it is closed.

    Raises:
        RoboGuitaristError: If the performance does not fit its scene, or there is no screen.
    """
    if not has_screen():  # without one, MuJoCo's viewer ends the whole process
        raise RoboGuitaristError("no window for the live view (there is no screen)")
    model = replay.scene(performance)
    data = mujoco.MjData(model)
    times_s = replay.frame_times(performance, 60.0)
    postures = replay.postures(performance, times_s)
    try:
        from mujoco import viewer  # noqa: PLC0415 - it wants a screen

        window = viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except Exception as error:  # GLFW and the drivers raise all kinds of errors
        raise RoboGuitaristError(f"no window for the live view ({error})") from error
    with window:
        window.opt.geomgroup[3] = 0
        while window.is_running():
            start_s = time.perf_counter()
            for due_s, posture in zip(times_s - times_s[0], postures, strict=True):
                if not window.is_running():
                    break
                data.qpos[:] = posture
                mujoco.mj_kinematics(model, data)
                window.sync()
                time.sleep(max(0.0, start_s + due_s - time.perf_counter()))
