"""A performance as one USDZ file, through MuJoCo's own exporter."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco

from roboguitarist import replay, storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.looks import CAMERAS
from roboguitarist.performance import Performance

FPS = 30


def write_usd(
    performance: Performance,
    path: str | Path,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write a performance as an animated scene in USDZ, 30 pictures a second, z up.

    Args:
        performance: What to show.
        path: File to write; it appears when it is complete.
        progress: Called with the share of the work that is done, from 0 to 1.

    Raises:
        RoboGuitaristError: If the libraries of the extra `usd` are missing, the performance does
            not fit its scene, or the file cannot be written.
    """
    try:
        from mujoco.usd.exporter import USDExporter  # noqa: PLC0415
        from pxr import UsdUtils  # noqa: PLC0415
    except ImportError as error:
        raise RoboGuitaristError(f"{error}; pip install 'roboguitarist[usd]'") from error
    model = replay.scene(performance)
    data = mujoco.MjData(model)
    postures = replay.postures(performance, replay.frame_times(performance, FPS))
    with tempfile.TemporaryDirectory() as folder:
        exporter: Any = USDExporter(
            model, output_directory="scene", output_directory_root=folder,
            camera_names=list(CAMERAS), light_intensity=2000, verbose=False,
        )  # fmt: skip
        for done, posture in enumerate(postures, start=1):
            data.qpos[:] = posture
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            exporter.update_scene(data)
            if progress:
                progress(0.9 * done / len(postures))
        exporter.stage.SetTimeCodesPerSecond(FPS)
        exporter.stage.SetFramesPerSecond(FPS)
        exporter.save_scene("usdc")
        (scene,) = Path(folder).glob("scene/frames/*.usdc")
        with storage.replacing(path) as temporary:
            package: Any = UsdUtils  # pxr's types know half of it
            package.CreateNewUsdzPackage(str(scene), str(temporary))
    if progress:
        progress(1.0)
