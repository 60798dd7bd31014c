from __future__ import annotations

from itertools import product

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.guitar import PRESETS, Guitar
from roboguitarist.hands import TIP_RADIUS_M, VARIANTS
from roboguitarist.scene import NAILS, PAD_M, SceneConfig, build, build_spec
from roboguitarist.sensing import Stops, stops

GUITAR = Guitar()
ALL_STRINGS = range(1, 7)
FRETS = range(1, GUITAR.n_frets + 1)
KINDS = {"body": "body", "jnt": "joint", "geom": "geom", "u": "actuator", "sensor": "sensor",
         "site": "site", "tendon": "tendon", "eq": "equality", "cam": "camera"}  # fmt: skip
SIDES = [(), ("left",), ("right",), ("left", "right")]


@pytest.fixture(scope="module")
def scene() -> mujoco.MjModel:
    return build(SceneConfig(visuals=False))


def settled(model: mujoco.MjModel, qpos: np.ndarray) -> mujoco.MjData:
    """The scene with the hands in a posture and every servo at its target."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    data.ctrl[:] = data.actuator_length
    return data


@pytest.mark.parametrize("hand", VARIANTS)
@pytest.mark.parametrize("guitar", PRESETS.values(), ids=PRESETS)
@pytest.mark.parametrize("sides", SIDES, ids="-".join)
def test_every_combination_compiles_with_what_was_asked(guitar, hand, sides):
    model = build(SceneConfig(guitar, hand, sides, visuals=False))
    left, right = "left" in sides, "right" in sides
    assert (model.nq, model.nu) == (27 * left + 24 * right, 23 * left + 20 * right)
    assert model.neq == (4 * len(sides) if hand == "linkage" else 0)
    assert model.nsensor == 6 + 50 * left + 4 * right


def test_sizes(scene):
    assert (scene.nq, scene.nv, scene.nu, scene.nbody, scene.ngeom) == (51, 51, 43, 51, 31)
    assert (scene.nsensordata, scene.ntendon) == (6 * 4 * 7 + 46 + 2 * 4 * 3, 8)
    assert scene.opt.timestep == 1 / 480


@pytest.mark.parametrize("visuals", [False, True])
@pytest.mark.parametrize("hand", VARIANTS)
def test_everything_is_named(hand, visuals):
    model = build(SceneConfig(hand=hand, visuals=visuals))
    for kind, accessor in KINDS.items():
        count = getattr(model, f"n{kind}")
        names = {getattr(model, accessor)(index).name for index in range(count)}
        assert "" not in names, kind
        assert len(names) == count, kind
    assert model.ncam >= 2 * visuals


def test_left_joints_come_first_and_slides_first_of_all(scene):
    names = [scene.joint(index).name for index in range(scene.njnt)]
    assert names[:3] == ["lh_forearm_x", "lh_forearm_y", "lh_forearm_z"]
    assert [name[:3] for name in names] == ["lh_"] * 27 + ["rh_"] * 24
    assert all(scene.actuator(index).name.startswith("lh_A_") for index in range(23))


def test_strings_lie_where_the_guitar_says_and_gravity_pulls_to_the_treble_side(scene):
    np.testing.assert_allclose(scene.opt.gravity, (0, 9.81, 0))
    for string in ALL_STRINGS:
        geom = scene.geom(f"string_{string}")
        middle = GUITAR.scale_length_m / 2
        y = float(GUITAR.string_y(string, middle))
        np.testing.assert_allclose(geom.pos, (middle, y, 0), atol=1e-15)
        assert geom.size[0] == GUITAR.string_radius_m
    board = scene.geom("fretboard")
    assert board.pos[2] + board.size[2] == pytest.approx(-GUITAR.action_m - PAD_M)


@pytest.mark.parametrize("hand", VARIANTS)
def test_nothing_touches_at_rest(hand):
    model = build(SceneConfig(hand=hand, visuals=False))
    data = settled(model, model.qpos0)
    assert data.ncon == 0
    np.testing.assert_array_equal(data.sensordata[: 6 * 4 * 7], 0)


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(VARIANTS), st.floats(0, 1), st.floats(0.05, 0.4))
def test_a_pose_is_held_by_the_servos(hand, slide, share):
    model = build(SceneConfig(hand=hand, visuals=False))
    low, high = model.jnt_range.T
    qpos = model.qpos0.copy()
    bends = [model.joint(i).name.endswith(("J1", "J2", "J3")) for i in range(model.njnt)]
    qpos[bends] = np.maximum(low, share * high)[bends]
    qpos[:3] = low[0] + slide * (high - low)[0], slide * high[1], 0.05  # clear of the strings
    data = settled(model, qpos)
    assert data.ncon == 0
    mujoco.mj_step(model, data, nstep=480)
    np.testing.assert_allclose(data.qpos, qpos, rtol=0, atol=1e-3)


class Probes:
    """One ball over each string, pushed down with known forces."""

    def __init__(self, guitar: Guitar = GUITAR) -> None:
        spec = build_spec(SceneConfig(guitar, sides=(), visuals=False))
        for string in ALL_STRINGS:
            body = spec.worldbody.add_body(name=f"ball_{string}", pos=(0, 0, 0.1))
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0, 0, 1), damping=20)
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=(TIP_RADIUS_M, 0, 0),
                contype=2,
                conaffinity=1,
                mass=0.05,
                solref=(0.005, 1),
            )
        self.guitar, self.model = guitar, spec.compile()

    def press(self, points: dict[int, np.ndarray], force_n: dict[int, float]) -> Stops:
        """What the sensors read once balls rest on strings at points with forces."""
        data = mujoco.MjData(self.model)
        for string in ALL_STRINGS:
            place = points.get(string, np.zeros(3)) + np.array([0, 0, TIP_RADIUS_M + 0.0009])
            self.model.body(f"ball_{string}").pos = place
        data.qfrc_applied[:] = [-force_n.get(string, 0.0) for string in ALL_STRINGS]
        mujoco.mj_step(self.model, data, nstep=240)
        mujoco.mj_forward(self.model, data)
        return stops(self.model, data.sensordata[None], self.guitar)


@pytest.fixture(scope="module")
def probes() -> Probes:
    return Probes()


@pytest.mark.parametrize("string", ALL_STRINGS)
@pytest.mark.parametrize("force_n", [0.3, 1.0, 5.0])
def test_a_press_at_every_fret_is_read_as_that_fret_with_its_force(probes, string, force_n):
    for fret in FRETS:
        read = probes.press({string: GUITAR.press_point(string, fret)}, {string: force_n})
        assert read.touched_fret[0, string - 1] == fret
        assert read.force_n[0, string - 1, fret - 1] == pytest.approx(force_n, rel=0.02)
        assert read.force_n.sum() == pytest.approx(force_n, rel=0.02)


@pytest.mark.parametrize("side", [-1, 1])
def test_every_wire_divides_its_frets(probes, side):
    for fret in FRETS[:-1]:
        point = GUITAR.press_point(3, fret, 1.0)
        point[0] += side * 2e-4
        read = probes.press({3: point}, {3: 2.0})
        assert read.touched_fret[0, 2] == (fret if side < 0 else fret + 1)


@settings(max_examples=25, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(ALL_STRINGS),
        st.tuples(st.sampled_from(FRETS), st.floats(0.3, 10.0)),
        min_size=1,
    )
)
def test_strings_are_read_independently(probes, presses):
    points = {string: GUITAR.press_point(string, fret) for string, (fret, _) in presses.items()}
    read = probes.press(points, {string: force for string, (_, force) in presses.items()})
    expected = np.zeros_like(read.force_n)
    for string, (fret, force) in presses.items():
        expected[0, string - 1, fret - 1] = force
    np.testing.assert_allclose(read.force_n, expected, rtol=0.02, atol=1e-9)


def test_a_string_with_more_contacts_than_its_sensor_holds_reports_the_firmest(probes):
    force_n = {ball: 0.5 * ball for ball in ALL_STRINGS}
    read = probes.press({ball: GUITAR.press_point(3, 2 * ball) for ball in ALL_STRINGS}, force_n)
    expected = [0.0, 0.0, 1.5, 2.0, 2.5, 3.0]
    np.testing.assert_allclose(read.force_n[0, 2, 1:12:2], expected, rtol=0.02)


def test_a_finger_laid_flat_presses_every_string():
    spec = build_spec(SceneConfig(sides=(), visuals=False))
    x = float(GUITAR.press_point(1, 5)[0])
    body = spec.worldbody.add_body(pos=(x, 0, TIP_RADIUS_M + GUITAR.string_radius_m))
    body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0, 0, 1), damping=20)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=(0, -0.03, 0, 0, 0.03, 0),
        size=(TIP_RADIUS_M, 0, 0),
        contype=2,
        conaffinity=1,
        mass=0.05,
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qfrc_applied[:] = -12.0
    mujoco.mj_step(model, data, nstep=480)
    read = stops(model, data.sensordata[None], GUITAR)
    np.testing.assert_array_equal(read.sounding_fret(), 5)
    assert read.force_n.sum() == pytest.approx(12.0, rel=0.02)


@pytest.mark.parametrize("guitar", PRESETS.values(), ids=PRESETS)
def test_every_guitar_reads_its_own_frets(guitar):
    probes = Probes(guitar)
    for string, fret in product((1, 6), (1, 7, guitar.n_frets)):
        read = probes.press({string: guitar.press_point(string, fret)}, {string: 1.5})
        assert read.force_n[0, string - 1, fret - 1] == pytest.approx(1.5, rel=0.02)


@pytest.mark.parametrize("hand", VARIANTS)
def test_nothing_explodes_under_random_controls(hand):
    model, rng = build(SceneConfig(hand=hand, visuals=False)), np.random.default_rng(0)
    data, pressed_n = mujoco.MjData(model), 0.0
    for _ in range(600):
        data.ctrl[:] = rng.uniform(*model.actuator_ctrlrange.T)
        mujoco.mj_step(model, data, nstep=16)
        pressed_n = max(pressed_n, np.abs(data.sensordata[: 6 * 4 * 7]).max())
        assert np.isfinite(data.qpos).all()
        assert np.abs(data.qvel).max() < 200
    assert data.time == pytest.approx(20)
    assert not any(warning.number for warning in data.warning)
    assert pressed_n > 1.0


def test_right_fingertips_pass_through_the_strings_and_left_ones_do_not(scene):
    types, masks = scene.geom_contype, scene.geom_conaffinity
    string = scene.geom("string_1").id

    def meet(first: int, second: int) -> bool:
        return bool(types[first] & masks[second] or types[second] & masks[first])

    left, right = scene.geom("lh_ffdistal").id, scene.geom("rh_ffdistal").id
    assert meet(left, string)
    assert not meet(right, string)
    assert meet(left, scene.geom("lh_mfdistal").id)
    assert meet(right, scene.geom("rh_mfdistal").id)
    assert not meet(left, right)


def test_nail_sensors_read_the_nails(scene):
    data = settled(scene, scene.qpos0)
    for nail in NAILS:
        np.testing.assert_array_equal(data.sensor(nail).data, data.site(nail).xpos)
