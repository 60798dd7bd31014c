"""Pictures of the scene, drawn through OpenGL without a window."""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from roboguitarist.video.errors import UnavailableError

_LIBRARY = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}
_INSTALL = "install OpenGL for drawing without a window (Debian: libegl1 and libgl1-mesa-dri)"
MAX_GEOMS = 2000


@dataclass(frozen=True)
class View:
    """A camera and where its picture goes: left, top, width, height in pixels."""

    camera: str
    rect: tuple[int, int, int, int]


@dataclass(frozen=True)
class Blur:
    """A translucent ellipsoid in the world.

    Attributes:
        centre: (3,) in metres.
        half_size: Half its lengths along its own axes, in metres.
        turn: (3, 3) rotation from its axes to the world's.
        rgba: Colour, 0 to 1.
    """

    centre: np.ndarray
    half_size: tuple[float, float, float]
    turn: np.ndarray
    rgba: tuple[float, float, float, float]


def backend() -> str:
    """How to reach OpenGL: `MUJOCO_GL` if it is set, else what this machine has.

    Raises:
        UnavailableError: If a headless Linux machine has neither EGL nor OSMesa.
    """
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen in ("egl", "osmesa", "glfw", "cgl"):
        return chosen
    if sys.platform != "linux":
        return "cgl" if sys.platform == "darwin" else "glfw"
    for name, library in _LIBRARY.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return name
    if os.environ.get("DISPLAY"):
        return "glfw"
    raise UnavailableError(f"no OpenGL library found; {_INSTALL}")


def open_context(width: int, height: int) -> Any:
    """An OpenGL context, made current.

    MuJoCo's own choice is made when it is first imported, which may be long before a picture is
    wanted; this one is made now.

    Raises:
        UnavailableError: If this machine cannot; the message says what to install.
    """
    name = backend()
    try:
        context = importlib.import_module(f"mujoco.{name}").GLContext(width, height)
        context.make_current()
    except Exception as error:  # PyOpenGL and the drivers raise all kinds of errors
        raise UnavailableError(f"OpenGL does not start ({name}: {error}); {_INSTALL}") from error
    return context


class Canvas:
    """Draws a model in given postures, until it is closed.

    Args:
        model: A model with visuals.
        size: Width and height in pixels.
        high: With shadows and smooth edges.

    Raises:
        UnavailableError: If this machine cannot draw.
    """

    def __init__(self, model: mujoco.MjModel, size: tuple[int, int], high: bool = False) -> None:
        self.size = size
        self._model, self._data = model, mujoco.MjData(model)
        visual: Any = model.vis
        visual.global_.offwidth, visual.global_.offheight = size
        visual.quality.offsamples = 4 if high else 0
        if not high:
            visual.quality.shadowsize = 0
        self._context = open_context(*size)
        try:
            self._drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except mujoco.FatalError as error:  # such as a window system without a display
            raise UnavailableError(f"OpenGL does not draw ({error}); {_INSTALL}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        self._scene = mujoco.MjvScene(model, MAX_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = high
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._option = mujoco.MjvOption()
        self._pixels = np.empty((size[1], size[0], 3), np.uint8)

    def draw(
        self, qpos: np.ndarray, views: Sequence[View], blurs: Sequence[Blur] = ()
    ) -> np.ndarray:
        """A picture (height, width, 3) uint8 of a posture (nq,); later views cover earlier ones."""
        model, data = self._model, self._data
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        self._context.make_current()
        for view in views:
            camera = mujoco.MjvCamera()
            camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
            camera.fixedcamid = model.camera(view.camera).id
            mujoco.mjv_updateScene(
                model, data, self._option, None, camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene
            )
            for blur in blurs:
                self._add(blur)
            mujoco.mjr_render(self._rect(view.rect), self._scene, self._drawing)
        whole = mujoco.MjrRect(0, 0, *self.size)
        mujoco.mjr_readPixels(self._pixels, None, whole, self._drawing)
        return self._pixels[::-1].copy()

    def _add(self, blur: Blur) -> None:
        scene = self._scene
        mujoco.mjv_initGeom(
            scene.geoms[scene.ngeom],
            mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            np.array(blur.half_size),
            blur.centre,
            blur.turn.ravel(),
            np.array(blur.rgba, np.float32),
        )
        scene.ngeom += 1

    def _rect(self, rect: tuple[int, int, int, int]) -> mujoco.MjrRect:
        left, top, width, height = rect
        return mujoco.MjrRect(left, self.size[1] - top - height, width, height)

    def close(self) -> None:
        """Give the graphics memory back."""
        self._context.make_current()
        self._drawing.free()
        self._context.free()
