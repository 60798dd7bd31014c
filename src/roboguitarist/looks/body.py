"""The guitar's body: top with sound hole and rosette, sides, back, bridge."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

from roboguitarist.guitar import Guitar
from roboguitarist.looks.neck import BOARD_M
from roboguitarist.looks.shapes import Mesh, add_box, add_disc, add_geom, add_mesh, lid, skin

DEPTH_M = 0.095
BRIDGE_SHARE = 0.67
"""The bridge stands two thirds down the body, which gives the body's length."""
POINTS = 144
# Half of the outline from the neck to the end: place along the body, half width, both in
# body lengths. Bouts and waist are those of a full-sized classical guitar.
_OUTLINE = (
    (0.0, 0.0), (0.003, 0.10), (0.035, 0.205), (0.11, 0.27), (0.21, 0.288), (0.32, 0.262),
    (0.43, 0.243), (0.54, 0.277), (0.65, 0.342), (0.76, 0.376), (0.87, 0.345), (0.955, 0.235),
    (0.993, 0.105), (1.0, 0.0),
)  # fmt: skip
# Inner and outer radius in radii of the sound hole.
_ROSETTE = {"ebony": (1.06, 1.10), "rosewood": (1.12, 1.30), "binding": (1.32, 1.36)}


def body_length(guitar: Guitar) -> float:
    """Length of the body in metres."""
    return (guitar.scale_length_m - guitar.body_x_m) / BRIDGE_SHARE


def top_z(guitar: Guitar) -> float:
    """Height of the body's top, on which the fretboard lies, in metres."""
    return -guitar.action_m - BOARD_M


def outline(guitar: Guitar, points: int = POINTS) -> np.ndarray:
    """Outline (points, 2) of the body in x and y, at even angles around the sound hole.

    Every point of the outline can be seen from there, which makes the top a simple ring.
    """
    half = np.array(_OUTLINE)
    closed = np.concatenate([half, half[-2::-1] * (1, -1)]) * body_length(guitar)
    length = np.cumsum([0, *np.hypot(*np.diff(closed, axis=0).T)])
    fine = CubicSpline(length, closed, bc_type="periodic")(np.linspace(0, length[-1], 2000)[:-1])
    fine[:, 0] += guitar.body_x_m
    from_hole = fine - (guitar.sound_hole_x_m, 0)
    angle = np.mod(np.arctan2(from_hole[:, 1], from_hole[:, 0]), 2 * np.pi)
    order = np.argsort(angle)
    radius = np.hypot(*from_hole.T)[order]
    even = np.linspace(0, 2 * np.pi, points, endpoint=False)
    distance = np.interp(even, angle[order], radius, period=2 * np.pi)
    return _circle(guitar, even, distance)


def _circle(guitar: Guitar, angle: np.ndarray, radius: np.ndarray | float) -> np.ndarray:
    """Points (n, 2) around the centre of the sound hole."""
    x = guitar.sound_hole_x_m + radius * np.cos(angle)
    return np.column_stack([x, radius * np.sin(angle)])


def add_body(spec: mujoco.MjSpec, guitar: Guitar) -> None:
    """Add the body to the world."""
    edge, z = outline(guitar), top_z(guitar)
    inside = (guitar.sound_hole_x_m, 0) + 0.975 * (edge - (guitar.sound_hole_x_m, 0))
    angle = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    radius = guitar.sound_hole_radius_m
    rim = skin(np.stack([_at(edge, z - DEPTH_M), _at(edge, z)]))
    floor = lid(_at(edge[::-1], z - DEPTH_M))
    parts = {
        "top": ("spruce", _band(inside, _circle(guitar, angle, radius), z)),
        "edge": ("binding", _band(edge, inside, z)),
        "sides": ("rosewood", rim),
        "back": ("rosewood", floor),
    }
    for index, (material, (inner, outer)) in enumerate(_ROSETTE.items()):
        ring = _band(
            _circle(guitar, angle, outer * radius), _circle(guitar, angle, inner * radius), z
        )
        ring.vertices[:, 2] += 0.0004
        parts[f"rosette_{index}"] = (material, ring)
    world = spec.worldbody
    for name, (material, mesh) in parts.items():
        add_geom(world, f"body_{name}", material, meshname=add_mesh(spec, f"body_{name}", mesh))
    centre = (guitar.sound_hole_x_m, 0, z - 0.03)
    add_disc(world, "body_inside", "dark", centre=centre, radius=2.2 * radius, half_height=0.001)
    _add_bridge(world, guitar)


def _at(points: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), z)])


def _band(outer: np.ndarray, inner: np.ndarray, z: float) -> Mesh:
    """Flat ring that faces the audience."""
    return skin(np.stack([_at(outer, z), _at(inner, z)]))


def _add_bridge(world: mujoco.MjsBody, guitar: Guitar) -> None:
    x, z, span = guitar.scale_length_m, top_z(guitar), guitar.saddle_span_m
    wing_y = 0.5 * span + 0.037
    add_box(
        world,
        "bridge_wings",
        "rosewood",
        centre=(x + 0.004, 0, z + 0.002),
        half_size=(0.014, wing_y, 0.002),
    )
    half = (0.013, 0.5 * span + 0.011, 0.003)
    add_box(world, "bridge", "rosewood", centre=(x + 0.004, 0, z + 0.003), half_size=half)
    tie = (0.005, 0.5 * span + 0.009, 0.0035)
    add_box(world, "bridge_tie_block", "ebony", centre=(x + 0.0125, 0, z + 0.0045), half_size=tie)
    top = -guitar.string_radius_m
    saddle = (0.0015, 0.5 * span + 0.006, 0.5 * (top - z))
    add_box(world, "saddle", "bone", centre=(x, 0, 0.5 * (top + z)), half_size=saddle)
