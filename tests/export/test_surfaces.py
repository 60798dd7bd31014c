import mujoco
import numpy as np
import pytest

from roboguitarist.export.surfaces import Surface, joined, surface
from roboguitarist.looks import VISUAL_GROUP
from roboguitarist.scene import build

SIZE = (0.02, 0.03, 0.04)
KIND = mujoco.mjtGeom
VOLUMES = {
    KIND.mjGEOM_SPHERE: 4 / 3 * np.pi * 0.02**3,
    KIND.mjGEOM_CAPSULE: 4 / 3 * np.pi * 0.02**3 + np.pi * 0.02**2 * 0.06,
    KIND.mjGEOM_ELLIPSOID: 4 / 3 * np.pi * np.prod(SIZE),
    KIND.mjGEOM_CYLINDER: np.pi * 0.02**2 * 0.06,
    KIND.mjGEOM_BOX: 8 * np.prod(SIZE),
}


def volume(shape: Surface) -> float:
    """Volume inside a closed surface; negative if its faces point inwards."""
    a, b, c = (shape.points[shape.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def one_geom(kind):
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=kind, size=SIZE, pos=(1, 2, 3), quat=(0.5, 0.5, -0.5, 0.5))
    return surface(spec.compile(), 0)


@pytest.mark.parametrize("kind", VOLUMES)
def test_a_shape_has_the_volume_of_its_kind(kind):
    shape = one_geom(kind)
    assert volume(shape) == pytest.approx(VOLUMES[kind], rel=0.06)
    assert volume(shape) <= VOLUMES[kind] * 1.0001


@pytest.mark.parametrize("kind", VOLUMES)
def test_normals_have_length_one_and_point_where_the_faces_do(kind):
    shape = one_geom(kind)
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-9)
    a, b, c = (shape.points[shape.faces[:, k]] for k in range(3))
    out = np.cross(b - a, c - a)
    for corner in range(3):
        assert (np.einsum("ij,ij->i", out, shape.normals[shape.faces[:, corner]]) > 0).all()


def test_what_is_not_drawn_is_an_error():
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=KIND.mjGEOM_PLANE, size=(1, 1, 1))
    with pytest.raises(ValueError, match="PLANE"):
        surface(spec.compile(), 0)


def test_every_geom_that_is_seen_has_a_surface_where_mujoco_has_it():
    model = build()
    seen = np.flatnonzero(model.geom_group == VISUAL_GROUP)
    assert len(seen) > 100
    for geom in seen:
        shape = surface(model, int(geom))
        assert np.isfinite(shape.points).all()
        assert shape.faces.max() < len(shape.points)
        centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        local = (shape.points - model.geom_pos[geom]) @ turn.reshape(3, 3)
        assert (np.abs(local - centre) <= half + 1e-6).all()
        assert np.abs(local - centre).max() > 0.9 * half.max()


def test_joined_surfaces_keep_their_faces():
    box, ball = one_geom(KIND.mjGEOM_BOX), one_geom(KIND.mjGEOM_SPHERE)
    both = joined([box, ball])
    assert volume(both) == pytest.approx(volume(box) + volume(ball))
