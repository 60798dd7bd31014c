"""Meshes of simple rounded shapes, and the geoms that show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

VISUAL_GROUP, COLLISION_GROUP = 2, 3
"""Geom groups of what is seen and of what touches; MuJoCo draws the first of them by default."""
ALONG_X = (0.70710678, 0.0, 0.70710678, 0.0)
"""Orientation that turns a cylinder from z to x."""
ALONG_Y = (0.70710678, -0.70710678, 0.0, 0.0)
TEXTURE_M = 0.25
"""Length that one copy of a wood's grain covers."""


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh.

    Attributes:
        vertices: (n, 3) in metres.
        faces: (k, 3) indices, counter-clockwise seen from outside.
    """

    vertices: np.ndarray
    faces: np.ndarray


def merged(*meshes: Mesh) -> Mesh:
    """Several meshes as one."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([m.faces + k for m, k in zip(meshes, offsets, strict=True)]),
    )


def skin(rings: np.ndarray) -> Mesh:
    """Surface over closed rings (n, m, 3), each joined to the next.

    The outside is where a ring's points run counter-clockwise as seen looking back from the
    next ring.
    """
    n, m, _ = rings.shape
    first = np.arange(n - 1)[:, None] * m + np.arange(m)
    second = np.arange(n - 1)[:, None] * m + np.roll(np.arange(m), -1)
    lower = np.stack([first, second, second + m], axis=-1)
    upper = np.stack([first, second + m, first + m], axis=-1)
    return Mesh(rings.reshape(-1, 3), np.concatenate([lower, upper]).reshape(-1, 3))


def lid(ring: np.ndarray) -> Mesh:
    """A closed ring (m, 3) filled from its centre, facing where it runs counter-clockwise."""
    m = len(ring)
    around = np.arange(m)
    faces = np.stack([np.full(m, m), around, np.roll(around, -1)], axis=-1)
    return Mesh(np.concatenate([ring, ring.mean(axis=0, keepdims=True)]), faces)


def solid(rings: np.ndarray) -> Mesh:
    """As `skin`, closed at both ends, with sharp edges there."""
    return merged(skin(rings), lid(rings[0, ::-1]), lid(rings[-1]))


def ellipses(
    sections: Sequence[Sequence[float]], power: float = 2.0, points: int = 28
) -> np.ndarray:
    """Rings (n, points, 3) across the z axis, as for `skin`.

    Args:
        sections: Rows of z, centre x, centre y, half width in x, half depth in y, in metres.
        power: 2 for ellipses, more for rounder rectangles.
        points: Points on each ring.
    """
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    across = np.sign(cos) * np.abs(cos) ** (2 / power)
    deep = np.sign(sin) * np.abs(sin) ** (2 / power)
    z, x, y, half_x, half_y = (np.array(column)[:, None] for column in zip(*sections, strict=True))
    rings = np.broadcast_arrays(x + half_x * across, y + half_y * deep, z + 0 * angle)
    return np.stack(rings, axis=-1)


def rounded(sections: Sequence[Sequence[float]], power: float = 2.0, points: int = 28) -> Mesh:
    """A solid like `ellipses` whose first and last ring are drawn to domes."""
    table = np.array(sections, float)
    start, end = (_dome(table[0], table[1]), _dome(table[-1], table[-2])[::-1])
    return skin(ellipses([*start, *table[1:-1], *end], power, points))


def _dome(edge: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """Rows from the pole at `edge` to `inner`, a quarter of an ellipse."""
    angle = np.linspace(0.02, np.pi / 2, 6)[:, None]
    rows = inner + (edge - inner) * np.cos(angle)
    rows[:, 3:] = inner[3:] * np.sin(angle)
    return rows


def tapered_capsule(start: float, end: float, start_radius: float, end_radius: float) -> Mesh:
    """Around the z axis, spheres of those radii with their centres at `start` and `end`."""
    rows = [
        (start - start_radius, 0, 0, 0, 0),
        (start, 0, 0, start_radius, start_radius),
        (end, 0, 0, end_radius, end_radius),
        (end + end_radius, 0, 0, 0, 0),
    ]
    return rounded(rows, points=20)


def add_mesh(spec: mujoco.MjSpec, name: str, mesh: Mesh) -> str:
    """Add a mesh under that name, with a grain along its x; returns the name."""
    spec.add_mesh(
        name=name,
        uservert=mesh.vertices.ravel(),
        userface=mesh.faces.ravel(),
        usertexcoord=(mesh.vertices[:, :2] / TEXTURE_M).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    return name


def add_geom(
    body: mujoco.MjsBody,
    name: str,
    material: str,
    kind: mujoco.mjtGeom = mujoco.mjtGeom.mjGEOM_MESH,
    **attributes: Any,
) -> None:
    """Add a geom that is seen only: it weighs nothing and touches nothing."""
    body.add_geom(
        name=name,
        type=kind,
        material=material,
        contype=0,
        conaffinity=0,
        mass=0,
        group=VISUAL_GROUP,
        **attributes,
    )


def add_disc(
    body: mujoco.MjsBody,
    name: str,
    material: str,
    *,
    centre: ArrayLike,
    radius: float,
    half_height: float,
    quat: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> None:
    """A cylinder, upright unless turned by `quat`."""
    kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, (radius, half_height, 0)
    add_geom(body, name, material, kind, pos=centre, size=size, quat=quat)


def add_rod(
    body: mujoco.MjsBody,
    name: str,
    material: str,
    *,
    start: ArrayLike,
    end: ArrayLike,
    radius: float,
) -> None:
    """A capsule between two points."""
    kind, size = mujoco.mjtGeom.mjGEOM_CAPSULE, (radius, 0, 0)
    add_geom(body, name, material, kind, fromto=np.concatenate([start, end]), size=size)


def add_box(
    body: mujoco.MjsBody,
    name: str,
    material: str,
    *,
    centre: ArrayLike,
    half_size: ArrayLike,
    quat: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> None:
    """A box."""
    kind = mujoco.mjtGeom.mjGEOM_BOX
    add_geom(body, name, material, kind, pos=centre, size=half_size, quat=quat)


def add_ellipsoid(
    body: mujoco.MjsBody,
    name: str,
    material: str,
    *,
    centre: ArrayLike,
    half_size: ArrayLike,
    quat: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> None:
    """An ellipsoid."""
    kind = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    add_geom(body, name, material, kind, pos=centre, size=half_size, quat=quat)


def looking(position: np.ndarray, target: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Orientation (w, x, y, z) of a camera at `position` that looks at `target`."""
    back = (position - target) / np.linalg.norm(position - target)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    frame = np.column_stack([right, np.cross(back, right), back])
    return Rotation.from_matrix(frame).as_quat(scalar_first=True)
