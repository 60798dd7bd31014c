from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.guitar import PRESETS, Guitar
from roboguitarist.hands import VARIANTS
from roboguitarist.looks import CAMERAS, COLLISION_GROUP, VISUAL_GROUP
from roboguitarist.looks.body import body_length, outline
from roboguitarist.looks.materials import FINGER_RGB, wood
from roboguitarist.looks.neck import half_width
from roboguitarist.looks.shapes import Mesh, looking, rounded, solid, tapered_capsule
from roboguitarist.scene import SceneConfig, build


@pytest.fixture(scope="module")
def seen() -> mujoco.MjModel:
    return build(SceneConfig(visuals=True))


@pytest.fixture(scope="module")
def bare() -> mujoco.MjModel:
    return build(SceneConfig(visuals=False))


def test_masses_and_sizes_do_not_change(seen, bare):
    assert (seen.nq, seen.nv, seen.nu, seen.nbody) == (bare.nq, bare.nv, bare.nu, bare.nbody)
    assert seen.nsensordata == bare.nsensordata
    for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat", "dof_damping", "qpos0"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(bare, name))


@pytest.mark.parametrize("hand", VARIANTS)
def test_the_simulation_is_the_same_to_the_last_bit(hand):
    ends = []
    for visuals in (False, True):
        model = build(SceneConfig(hand=hand, visuals=visuals))
        data = mujoco.MjData(model)
        contacts = 0
        for step in range(240):
            # The left hand closes on the strings, so that contacts count too.
            share = min(1.0, step / 120)
            data.ctrl[:] = share * 0.5 * model.actuator_ctrlrange[:, 1]
            mujoco.mj_step(model, data)
            contacts += data.ncon
        ends.append((data.qpos.copy(), data.sensordata.copy(), contacts))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_array_equal(ends[0][1], ends[1][1])
    assert ends[0][2] == ends[1][2] > 0


def test_what_is_seen_touches_nothing_and_what_touches_is_not_seen(seen, bare):
    touches = (seen.geom_contype != 0) | (seen.geom_conaffinity != 0)
    assert touches.sum() == bare.ngeom
    assert set(seen.geom_group[touches]) == {COLLISION_GROUP}
    assert set(seen.geom_group[~touches]) == {VISUAL_GROUP}
    assert (~touches).sum() > 150


def test_everything_is_named(seen):
    for kind in ("geom", "mesh", "mat", "tex", "light", "cam", "body", "site"):
        count = getattr(seen, f"n{kind}")
        names = {getattr(seen, kind)(index).name for index in range(count)}
        assert "" not in names, kind
        assert len(names) == count, kind


@pytest.mark.parametrize("sides", [("left", "right"), ("left",), ("right",), ()])
def test_cameras_are_there_whichever_hands_are(sides):
    model = build(SceneConfig(sides=sides))
    assert {model.camera(index).name for index in range(model.ncam)} == set(CAMERAS)


@pytest.mark.parametrize("guitar", PRESETS.values(), ids=PRESETS)
def test_every_preset_has_its_frets_where_they_sound(guitar):
    model = build(SceneConfig(guitar, visuals=True))
    wires = [model.geom(f"fret_{fret}").pos[0] for fret in range(1, guitar.n_frets + 1)]
    np.testing.assert_allclose(wires, guitar.fret_x(np.arange(1, guitar.n_frets + 1)), atol=1e-9)


@pytest.mark.parametrize(("link", "radius"), [("proximal", 9e-3), ("middle", 9e-3)])
def test_fingers_look_as_thick_as_they_are(seen, link, radius):
    mesh = seen.mesh(f"lh_{link}")
    first, count = mesh.vertadr[0], mesh.vertnum[0]
    widths = np.sort(np.ptp(seen.mesh_vert[first : first + count], axis=0))
    np.testing.assert_allclose(widths[:2] / 2, radius, atol=0.5e-3)


def test_the_front_camera_sees_the_bass_side_up_and_the_head_on_the_right(seen):
    data = mujoco.MjData(seen)
    mujoco.mj_forward(seen, data)
    right, up, back = data.camera("front").xmat.reshape(3, 3).T
    assert up @ (0, -1, 0) > 0.9
    assert right @ (-1, 0, 0) > 0.9
    assert back @ (0, 0, 1) > 0.9


@given(
    st.floats(0.5, 0.7),
    st.floats(0.46, 0.56),
    st.floats(0.03, 0.05),
)
def test_the_body_is_symmetric_and_holds_its_sound_hole(scale_m, neck_share, radius_m):
    body_x = neck_share * scale_m
    guitar = replace(Guitar(), scale_length_m=scale_m, body_x_m=body_x)
    hole_x = body_x + 0.34 * body_length(guitar)
    guitar = replace(guitar, sound_hole_x_m=hole_x, sound_hole_radius_m=radius_m)
    edge = outline(guitar)
    mirrored = np.concatenate([edge[:1], edge[:0:-1]]) * (1, -1)
    np.testing.assert_allclose(edge, mirrored, atol=1e-3)
    assert np.hypot(*(edge - (hole_x, 0)).T).min() > radius_m
    assert np.ptp(edge[:, 0]) == pytest.approx(body_length(guitar), rel=0.01)
    assert edge[:, 0].max() > guitar.scale_length_m


@given(st.floats(0, 0.4))
def test_strings_lie_on_the_fretboard(x):
    guitar = Guitar()
    assert 0 < guitar.string_y(1, x) < half_width(guitar, x)


def _volume(mesh: Mesh) -> float:
    """Volume inside a closed mesh, positive if its faces look outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@given(st.floats(0.005, 0.02), st.floats(0.01, 0.1))
def test_a_capsule_has_the_volume_of_a_capsule(radius, length):
    expected = np.pi * radius**2 * (length + 4 / 3 * radius)
    found = _volume(tapered_capsule(0.003, 0.003 + length, radius, radius))
    assert found == pytest.approx(expected, rel=0.05)


def test_solids_look_outwards():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    rings = np.stack([np.column_stack([square, np.full(4, z)]) for z in (0.0, 2.0)])
    assert _volume(solid(rings)) == pytest.approx(2.0)
    rows = [(0, 0, 0, 0, 0), (1, 0, 0, 1, 1), (2, 0, 0, 1, 1), (3, 0, 0, 0, 0)]
    assert _volume(rounded(rows)) == pytest.approx(np.pi * (1 + 4 / 3), rel=0.05)


def test_a_camera_looks_at_its_target():
    quat = looking(np.array([1.0, 0, 0]), np.zeros(3), np.array([0.0, 0, 1]))
    frame = np.zeros(9)
    mujoco.mju_quat2Mat(frame, quat)
    np.testing.assert_allclose(frame.reshape(3, 3)[:, 2], (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(frame.reshape(3, 3)[:, 1], (0, 0, 1), atol=1e-12)


def test_grain_keeps_the_colour_and_every_finger_has_its_own():
    image = wood((0.5, 0.25, 0.1), 0.2, 50)
    np.testing.assert_allclose(image.mean(axis=(0, 1)) / 255, (0.5, 0.25, 0.1), atol=0.03)
    assert image.std() > 1
    assert len(set(FINGER_RGB.values())) == 5
