"""The surfaces of a model's geoms as triangles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from roboguitarist.looks.shapes import TEXTURE_M

AROUND, ACROSS = 20, 10
"""Corners of a round shape around its axis, and steps from pole to pole."""


@dataclass(frozen=True)
class Surface:
    """Triangles with a normal at each corner.

    Attributes:
        points: (n, 3) in metres.
        normals: (n, 3) of length 1.
        texture: (n, 2) places in the texture.
        faces: (k, 3) indices, counter-clockwise seen from outside.
    """

    points: np.ndarray
    normals: np.ndarray
    texture: np.ndarray
    faces: np.ndarray


def joined(surfaces: list[Surface]) -> Surface:
    """Several surfaces as one."""
    offsets = np.cumsum([0, *(len(surface.points) for surface in surfaces[:-1])])
    return Surface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.texture for surface in surfaces]),
        np.concatenate([s.faces + k for s, k in zip(surfaces, offsets, strict=True)]),
    )


def surface(model: mujoco.MjModel, geom: int) -> Surface:
    """The surface of a geom in the frame of its body.

    Raises:
        ValueError: If it is of a kind that this package does not draw, such as a plane.
    """
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        own = _mesh(model, int(model.geom_dataid[geom]))
    elif kind in _SHAPES:
        own = _SHAPES[kind](model.geom_size[geom])
    else:
        raise ValueError(f"no surface for {kind.name}")
    turn = Rotation.from_quat(model.geom_quat[geom], scalar_first=True)
    points = turn.apply(own.points) + model.geom_pos[geom]
    on_wood = kind != mujoco.mjtGeom.mjGEOM_MESH
    texture = points[:, :2] / TEXTURE_M if on_wood else own.texture
    return Surface(points, turn.apply(own.normals), texture, own.faces)


def _mesh(model: mujoco.MjModel, mesh: int) -> Surface:
    """A mesh whose corners have one normal and one place in the texture each."""

    def rows(name: str, start: str, count: str) -> np.ndarray:
        first = getattr(model, start)[mesh]
        return getattr(model, name)[first : first + getattr(model, count)[mesh]]

    faces, normals, texture = (
        rows(name, "mesh_faceadr", "mesh_facenum")
        for name in ("mesh_face", "mesh_facenormal", "mesh_facetexcoord")
    )
    corners = np.stack([faces, normals, texture], axis=-1).reshape(-1, 3)
    unique, index = np.unique(corners, axis=0, return_inverse=True)
    return Surface(
        rows("mesh_vert", "mesh_vertadr", "mesh_vertnum")[unique[:, 0]],
        rows("mesh_normal", "mesh_normaladr", "mesh_normalnum")[unique[:, 1]],
        rows("mesh_texcoord", "mesh_texcoordadr", "mesh_texcoordnum")[unique[:, 2]],
        index.reshape(-1, 3),
    )


def _lathe(profile: np.ndarray, normals: np.ndarray) -> Surface:
    """A curve (m, 2) of radius and height turned around the z axis, with its normals alike."""
    angle = np.linspace(0, 2 * np.pi, AROUND + 1)
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def turned(curve: np.ndarray) -> np.ndarray:
        flat = curve[:, :1, None] * turn
        return np.concatenate(
            [flat, np.broadcast_to(curve[:, 1:, None], (*flat.shape[:2], 1))], axis=-1
        ).reshape(-1, 3)

    low = np.arange(len(profile) - 1)[:, None] * (AROUND + 1) + np.arange(AROUND)
    high = low + AROUND + 1
    lower = np.stack([low, low + 1, high + 1], axis=-1)
    upper = np.stack([low, high + 1, high], axis=-1)
    points = turned(profile)
    faces = np.concatenate([lower, upper]).reshape(-1, 3)
    return Surface(points, turned(normals), np.zeros((len(points), 2)), _with_area(points, faces))


def _with_area(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The faces that are no lines or points, as those at a pole are."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-14]


def _arc(start: float, end: float) -> np.ndarray:
    """Points (ACROSS + 1, 2) of a unit circle between two angles above its equator."""
    angle = np.linspace(start, end, ACROSS + 1)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _ellipsoid(size: np.ndarray) -> Surface:
    ball = _arc(-np.pi / 2, np.pi / 2)
    unit = _lathe(ball, ball)
    normals = unit.normals / size
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Surface(unit.points * size, normals, unit.texture, unit.faces)


def _sphere(size: np.ndarray) -> Surface:
    return _ellipsoid(np.full(3, size[0]))


def _capsule(size: np.ndarray) -> Surface:
    radius, half = size[0], size[1]
    ends = _arc(-np.pi / 2, 0), _arc(0, np.pi / 2)
    profile = np.concatenate([radius * ends[0] - [0, half], radius * ends[1] + [0, half]])
    return _lathe(profile, np.concatenate(ends))


def _cylinder(size: np.ndarray) -> Surface:
    radius, half = size[0], size[1]
    profile = np.array([(0, -half), (radius, -half), (radius, -half), (radius, half),
                        (radius, half), (0, half)])  # fmt: skip
    normals = np.array([(0, -1), (0, -1), (1, 0), (1, 0), (0, 1), (0, 1)], float)
    return _lathe(profile, normals)


def _box(size: np.ndarray) -> Surface:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    points, normals = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.empty((4, 3))
            corners[:, axis] = sign
            corners[:, [(axis + 1) % 3, (axis + 2) % 3]] = square[:: int(sign)]
            points.append(corners * size)
            normals.append(np.tile(sign * np.eye(3)[axis], (4, 1)))
    faces = (np.arange(6)[:, None, None] * 4 + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
    return Surface(np.concatenate(points), np.concatenate(normals), np.zeros((24, 2)), faces)


_SHAPES: dict[mujoco.mjtGeom, Callable[[np.ndarray], Surface]] = {
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
}
