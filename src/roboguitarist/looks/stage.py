"""Light, background and cameras."""

from __future__ import annotations

import mujoco
import numpy as np

from roboguitarist.guitar import Guitar
from roboguitarist.hands import PREFIX, Side
from roboguitarist.looks.shapes import looking

CAMERAS = ("front", "left", "right", "player")
"""`front`: as the audience sees it; `left` and `right`: close on that hand; `player`: over the
player's shoulder along the neck."""
_BASS_UP = np.array([0.0, -1.0, 0.0])
_HELD_RAD = np.radians(7)
"""The picture is turned by this much, so that the head of the guitar is held high."""


def add_stage(spec: mujoco.MjSpec, guitar: Guitar, sides: tuple[Side, ...]) -> None:
    """Add light, background and cameras; the left close-up moves with the left hand."""
    _add_light(spec)
    up = np.array([-np.sin(_HELD_RAD), -np.cos(_HELD_RAD), 0.0])
    middle = np.array([0.48 * guitar.scale_length_m, 0.035, 0.0])
    _add_camera(spec.worldbody, "front", middle + (-0.05, 0.13, 1.06), middle, up, 32)
    hole = np.array([guitar.sound_hole_x_m, -0.015, 0.01])
    _add_camera(spec.worldbody, "right", hole + (-0.12, 0.12, 0.34), hole, up, 36)
    shoulder = np.array([0.80, -0.30, 0.42])
    _add_camera(spec.worldbody, "player", shoulder, np.array([0.25, 0.0, 0.0]), _BASS_UP, 36)
    fingers = np.array([0.0, 0.025, 0.0])
    if "left" in sides:
        hand = spec.body(f"{PREFIX['left']}forearm")
        fingers = fingers - hand.pos
    else:
        hand = spec.worldbody
    _add_camera(hand, "left", fingers + (0.06, 0.02, 0.36), fingers, up, 36)


def _add_camera(
    body: mujoco.MjsBody,
    name: str,
    position: np.ndarray,
    target: np.ndarray,
    up: np.ndarray,
    fovy_deg: float,
) -> None:
    body.add_camera(name=name, pos=position, quat=looking(position, target, up), fovy=fovy_deg)


def _add_light(spec: mujoco.MjSpec) -> None:
    visual = spec.visual
    visual.headlight.ambient = (0.32, 0.32, 0.33)
    visual.headlight.diffuse = (0.22, 0.22, 0.22)
    visual.headlight.specular = (0.05, 0.05, 0.05)
    visual.global_.offwidth, visual.global_.offheight = 1920, 1080
    visual.quality.shadowsize = 4096
    visual.map.shadowclip = 0.6
    visual.map.znear, visual.map.zfar = 0.02, 20.0
    spec.stat.extent, spec.stat.center = 1.0, (0.33, 0.0, 0.0)
    for name, direction, strength, shadow in (
        ("key", (0.28, 0.42, -0.9), (0.55, 0.53, 0.50), True),
        ("fill", (-0.8, 0.15, -0.6), (0.20, 0.22, 0.25), False),
        ("rim", (0.0, 0.9, 0.25), (0.22, 0.20, 0.18), False),
    ):
        spec.worldbody.add_light(
            name=name,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            dir=direction,
            pos=-1.5 * np.array(direction),
            diffuse=strength,
            specular=tuple(0.6 * value for value in strength),
            castshadow=shadow,
        )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=(0.90, 0.89, 0.87),
        rgb2=(0.66, 0.66, 0.66),
        width=256,
        height=256,
    )
