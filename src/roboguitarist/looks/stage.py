"""Light, background and cameras."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from roboguitarist.guitar import Guitar
from roboguitarist.hands import PREFIX, Side
from roboguitarist.looks.shapes import looking

CAMERAS = ("front", "left", "right", "player")
"""`front`: as the audience sees it; `left` and `right`: close on that hand; `player`: over the
player's shoulder along the neck."""
HELD_RAD = np.radians(7)
"""The picture is turned by this much, so that the head of the guitar is held high."""


def add_stage(spec: mujoco.MjSpec, guitar: Guitar, sides: tuple[Side, ...]) -> None:
    """Add light, background and cameras; the left close-up moves with the left hand."""
    _add_light(spec)
    middle = (0.48 * guitar.scale_length_m, 0.012, 0.0)
    _add_camera(spec.worldbody, Shot("front", middle, (-0.05, 0.13, 1.06), 32))
    hole = (guitar.sound_hole_x_m, -0.015, 0.01)
    _add_camera(spec.worldbody, Shot("right", hole, (-0.12, 0.12, 0.34), 36))
    neck = (0.48 * guitar.scale_length_m, 0.02, 0.0)
    _add_camera(spec.worldbody, Shot("player", neck, (0.49, -0.32, 0.42), 34, held_rad=0.0))
    hand, x, y, z = spec.worldbody, -0.005, 0.005, 0.0
    if "left" in sides:
        hand = spec.body(f"{PREFIX['left']}forearm")
        x, y, z = np.array([x, y, z]) - hand.pos
    _add_camera(hand, Shot("left", (x, y, z), (0.06, 0.02, 0.36), 31))


@dataclass(frozen=True)
class Shot:
    """A camera.

    Attributes:
        name: One of `CAMERAS`.
        target: Point in the middle of the picture, in metres.
        offset: Way from there to the camera, in metres.
        fovy_deg: Angle between the picture's lower and upper edge.
        held_rad: How far the head of the guitar is held up.
    """

    name: str
    target: tuple[float, float, float]
    offset: tuple[float, float, float]
    fovy_deg: float
    held_rad: float = HELD_RAD


def _add_camera(body: mujoco.MjsBody, shot: Shot) -> None:
    target = np.array(shot.target)
    position = target + shot.offset
    up = np.array([-np.sin(shot.held_rad), -np.cos(shot.held_rad), 0.0])
    quat = looking(position, target, up)
    body.add_camera(name=shot.name, pos=position, quat=quat, fovy=shot.fovy_deg)


def _add_light(spec: mujoco.MjSpec) -> None:
    visual = spec.visual
    visual.headlight.ambient = (0.32, 0.32, 0.33)
    visual.headlight.diffuse = (0.22, 0.22, 0.22)
    visual.headlight.specular = (0.05, 0.05, 0.05)
    visual.global_.offwidth, visual.global_.offheight = 1920, 1080
    visual.quality.shadowsize = 4096
    visual.quality.numslices, visual.quality.numstacks = 16, 8
    visual.map.shadowclip = 0.6
    visual.map.znear, visual.map.zfar = 0.02, 20.0
    spec.stat.extent, spec.stat.center = 1.0, (0.33, 0.0, 0.0)
    for name, direction, strength, shadow in (
        ("key", (0.28, 0.42, -0.9), (0.50, 0.485, 0.46), True),
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
        rgb2=(0.78, 0.77, 0.75),
        width=256,
        height=256,
    )
