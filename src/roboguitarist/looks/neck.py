"""The guitar's neck: rounded back with its heel, fretboard, frets, inlays, nut."""

from __future__ import annotations

import mujoco
import numpy as np

from roboguitarist.guitar import Guitar
from roboguitarist.looks.shapes import (
    Mesh,
    add_box,
    add_disc,
    add_geom,
    add_mesh,
    add_rod,
    lid,
    merged,
    skin,
)

BOARD_M = 0.006
"""Thickness of the fretboard."""
MARGIN_M = 0.004
"""Fretboard beside the outer strings."""
NECK_M = 0.0145
"""Thickness of the neck behind the fretboard."""
HEEL_M, HEEL_LENGTH_M = 0.085, 0.055
INLAY_FRETS = (3, 5, 7, 9, 12, 15, 17, 19)


def half_width(guitar: Guitar, x: np.ndarray | float) -> np.ndarray:
    """Half the width of the fretboard at `x` in metres."""
    return np.asarray(guitar.string_y(1, x)) + MARGIN_M


def add_neck(spec: mujoco.MjSpec, guitar: Guitar) -> None:
    """Add the neck to the world."""
    world = spec.worldbody
    for name, material, mesh in (
        ("neck", "mahogany", _neck(guitar)),
        ("neck_board", "fingerboard", _board(guitar)),
    ):
        add_geom(world, name, material, meshname=add_mesh(spec, name, mesh))
    _add_frets(world, guitar)
    z = -guitar.action_m
    top = -guitar.string_radius_m
    half = (0.0025, float(half_width(guitar, 0.0)), 0.5 * (top - z + BOARD_M))
    add_box(world, "nut", "bone", centre=(-0.0025, 0, 0.5 * (top + z - BOARD_M)), half_size=half)


def neck_depth(guitar: Guitar, x: np.ndarray) -> np.ndarray:
    """Thickness of the neck behind the fretboard, growing into the heel, in metres."""
    into_heel = np.clip((x - guitar.body_x_m + HEEL_LENGTH_M) / HEEL_LENGTH_M, 0, 1)
    return NECK_M + 0.003 * x / guitar.body_x_m + (HEEL_M - NECK_M) * into_heel**2.5


def _neck(guitar: Guitar) -> Mesh:
    """Half ellipses from the head to the body, the last ones the heel."""
    heel = guitar.body_x_m - HEEL_LENGTH_M
    x = np.concatenate([np.linspace(-0.006, heel, 8)[:-1], np.linspace(heel, guitar.body_x_m, 12)])
    angle = np.linspace(0, np.pi, 25)
    width, depth = half_width(guitar, x)[:, None], neck_depth(guitar, x)[:, None]
    deep = np.sin(angle) ** 0.8 * depth
    # The heel narrows towards its foot.
    narrow = 1 - 0.45 * np.clip(deep / HEEL_M, 0, 1) * (depth > 2 * NECK_M)
    y = width * np.cos(angle) * narrow
    z = -guitar.action_m - BOARD_M - deep
    rings = np.stack(np.broadcast_arrays(x[:, None], y, z), axis=-1)[:, ::-1]
    return merged(skin(rings), lid(rings[0, ::-1]))


def _board(guitar: Guitar) -> Mesh:
    """A flat board from the nut to past the last fret."""
    end = min(
        float(guitar.fret_x(guitar.n_frets)) + 0.004,
        guitar.sound_hole_x_m - guitar.sound_hole_radius_m - 0.002,
    )
    top, bottom = -guitar.action_m, -guitar.action_m - BOARD_M
    near, far = float(half_width(guitar, 0.0)), float(half_width(guitar, end))
    corners = np.array([(0, -near), (end, -far), (end, far), (0, near)])
    floor, face = (np.column_stack([corners, np.full(4, z)]) for z in (bottom, top))
    sides = [
        lid(np.stack([floor[i], floor[j], face[j], face[i]]))
        for i, j in zip(range(4), (1, 2, 3, 0), strict=True)
    ]
    return merged(lid(face), *sides)


def _add_frets(world: mujoco.MjsBody, guitar: Guitar) -> None:
    z = -guitar.action_m
    for fret in range(1, guitar.n_frets + 1):
        x = float(guitar.fret_x(fret))
        half = float(half_width(guitar, x)) - 0.0005
        add_rod(
            world, f"fret_{fret}", "nickel", start=(x, -half, z), end=(x, half, z), radius=0.0009
        )
    for fret in INLAY_FRETS:
        if fret > guitar.n_frets:
            break
        x = 0.5 * float(guitar.fret_x(fret - 1) + guitar.fret_x(fret))
        aside = 0.3 * float(half_width(guitar, x)) if fret == 12 else 0.0
        for side in sorted({-aside, aside}):
            name = f"inlay_{fret}_{'bass' if side < 0 else 'treble'}"
            add_disc(world, name, "pearl", centre=(x, side, z), radius=0.003, half_height=0.0002)
