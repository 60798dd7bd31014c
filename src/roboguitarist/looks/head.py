"""The guitar's head: slotted, six rollers, six pegs."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from roboguitarist.guitar import Guitar
from roboguitarist.looks.neck import BOARD_M
from roboguitarist.looks.shapes import (
    ALONG_Y,
    Mesh,
    add_box,
    add_disc,
    add_ellipsoid,
    add_geom,
    add_mesh,
    add_rod,
    solid,
)

LENGTH_M, THICKNESS_M = 0.185, 0.018
TILT_RAD = np.radians(12)
"""The head leans back, so that the strings press on the nut."""
ROLLERS_M = (0.045, 0.085, 0.125)
"""Distance of the rollers from the nut; strings 1 and 6 go to the nearest, 3 and 4 to the last."""
SLOT_Y_M = 0.0165


def _pose(guitar: Guitar) -> tuple[np.ndarray, Rotation]:
    """Where the head starts, and how its frame (towards the tip, treble side, out) is turned."""
    origin = np.array([-0.004, 0, -guitar.action_m - BOARD_M + 0.004])
    tilt = Rotation.from_euler("y", -TILT_RAD)
    return origin, tilt


def head_point(guitar: Guitar, from_nut: float, y: float, z: float = 0.0) -> np.ndarray:
    """A point (3,) given along the head, across it and over its face, in metres."""
    origin, tilt = _pose(guitar)
    return origin + tilt.apply((-from_nut, y, z))


def roller(guitar: Guitar, string: int) -> np.ndarray:
    """Where a string (1 to 6) ends on its roller, in metres."""
    place = ROLLERS_M[string - 1 if string <= 3 else 6 - string]
    side = 1 if string <= 3 else -1
    return head_point(guitar, place, side * (SLOT_Y_M - 0.003 + 0.002 * abs(3.5 - string)), 0.0035)


def add_head(spec: mujoco.MjSpec, guitar: Guitar) -> None:
    """Add the head to the world."""
    world, (_, tilt) = spec.worldbody, _pose(guitar)
    add_geom(world, "head", "mahogany", meshname=add_mesh(spec, "head", _slab(guitar, 0.0, 1.0)))
    veneer = add_mesh(spec, "head_veneer", _slab(guitar, 0.0008, 0.06))
    add_geom(world, "head_veneer", "rosewood", meshname=veneer)
    quat = tilt.as_quat(scalar_first=True)
    for side, name in ((1, "treble"), (-1, "bass")):
        slot = head_point(guitar, 0.085, side * SLOT_Y_M, 0.0006)
        add_box(
            world,
            f"head_slot_{name}",
            "dark",
            centre=slot,
            half_size=(0.056, 0.0075, 0.0006),
            quat=quat,
        )
        plate = head_point(guitar, 0.085, side * 0.0385, -0.009)
        add_box(
            world,
            f"head_plate_{name}",
            "brass",
            centre=plate,
            half_size=(0.055, 0.0012, 0.006),
            quat=quat,
        )
    for string in range(1, 7):
        _add_peg(world, guitar, string, quat)


def _slab(guitar: Guitar, over: float, share: float) -> Mesh:
    """The head's outline, from `over` its face down by a share of its thickness."""
    start = float(guitar.string_y(1, 0.0)) + 0.004
    half = [(0.0, start), (0.018, 0.031), (0.03, 0.036), (0.15, 0.038), (0.165, 0.034)]
    half += [(0.172, 0.02), (LENGTH_M - 0.006, 0.012), (LENGTH_M, 0.0)]
    edge = [*half, *((along, -y) for along, y in half[-2::-1])]
    return solid(
        np.array([
            [head_point(guitar, along, y, z) for along, y in edge]
            for z in (over - share * THICKNESS_M, over)
        ])
    )  # fmt: skip


def _add_peg(world: mujoco.MjsBody, guitar: Guitar, string: int, quat: np.ndarray) -> None:
    side, place = (1 if string <= 3 else -1), ROLLERS_M[string - 1 if string <= 3 else 6 - string]
    inner, outer = (head_point(guitar, place, side * y, -0.0005) for y in (0.008, 0.026))
    add_rod(world, f"roller_{string}", "bone", start=inner, end=outer, radius=0.0042)
    shaft = head_point(guitar, place + 0.006, side * 0.047, -0.009)
    add_disc(
        world,
        f"peg_shaft_{string}",
        "brass",
        centre=shaft,
        radius=0.0022,
        half_height=0.010,
        quat=ALONG_Y,
    )
    button = head_point(guitar, place + 0.006, side * 0.060, -0.009)
    add_ellipsoid(
        world, f"peg_{string}", "pearl", centre=button, half_size=(0.0075, 0.006, 0.0035), quat=quat
    )
