from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.scene import CONTACTS_PER_STRING, NAILS, SENSOR_WIDTH, SceneConfig, build
from roboguitarist.sensing import (
    DEAD,
    PRESS_THRESHOLD_N,
    Plucks,
    Stops,
    left_power,
    plucks,
    stops,
)

GUITAR = Guitar()
MODEL = build(SceneConfig(visuals=False))
HOLE_X, HOLE_R = GUITAR.sound_hole_x_m, GUITAR.sound_hole_radius_m
STEP_S = float(MODEL.opt.timestep)
FIRM, LIGHT = 2.0, 0.3
Touch = tuple[int, float]
"""Fret that is touched, and with how many newtons."""


def place(sensor: str) -> slice:
    found = MODEL.sensor(sensor)
    return slice(found.adr[0], found.adr[0] + found.dim[0])


def touching(touches: dict[int, list[Touch]]) -> np.ndarray:
    """Readings (1, nsensordata) while strings are touched."""
    data = np.zeros((1, MODEL.nsensordata))
    for string, contacts in touches.items():
        row = np.zeros((CONTACTS_PER_STRING, SENSOR_WIDTH))
        for index, (fret, force_n) in enumerate(sorted(contacts, key=lambda touch: -touch[1])):
            row[index] = (len(contacts), force_n, 0.4, -0.2, *GUITAR.press_point(string, fret))
        data[0, place(f"string_{string}")] = row.ravel()
    return data


def read(touches: dict[int, list[Touch]]) -> Stops:
    return stops(MODEL, touching(touches), GUITAR)


touch_lists = st.dictionaries(
    st.integers(1, 6),
    st.lists(
        st.tuples(st.integers(1, 20), st.floats(0.01, 20)),
        min_size=1,
        max_size=CONTACTS_PER_STRING,
    ),
)


def test_an_untouched_string_is_open():
    still = stops(MODEL, np.zeros((3, MODEL.nsensordata)), GUITAR)
    assert still.force_n.shape == (3, 6, GUITAR.n_frets)
    assert not still.force_n.any()
    np.testing.assert_array_equal(still.sounding_fret(), 0)
    np.testing.assert_array_equal(still.sounding_fret(capo=2), 2)


@given(touch_lists)
def test_forces_land_in_the_fret_spaces_that_were_touched(touches):
    expected, highest = np.zeros((1, 6, GUITAR.n_frets)), np.zeros((1, 6))
    for string, contacts in touches.items():
        for fret, force_n in contacts:
            expected[0, string - 1, fret - 1] += force_n
            highest[0, string - 1] = max(highest[0, string - 1], fret)
    found = read(touches)
    np.testing.assert_allclose(found.force_n, expected)
    np.testing.assert_array_equal(found.touched_fret, highest)


@given(touch_lists, st.integers(0, 5))
def test_sounding_frets_are_open_fretted_or_dead(touches, capo):
    sounding = read(touches).sounding_fret(capo)[0]
    for string in STRINGS.tolist():
        contacts = touches.get(string, [])
        force_n = {fret: sum(f for n, f in contacts if n == fret) for fret, _ in contacts}
        fretted = max((n for n, f in force_n.items() if f >= PRESS_THRESHOLD_N), default=0)
        stopped = max(fretted, capo)
        dead = any(fret > stopped for fret in force_n)
        assert sounding[string - 1] == (DEAD if dead else stopped)


@pytest.mark.parametrize(
    ("contacts", "capo", "sounding"),
    [
        ([(3, FIRM)], 0, 3),
        ([(3, PRESS_THRESHOLD_N)], 0, 3),
        ([(3, PRESS_THRESHOLD_N - 1e-6)], 0, DEAD),
        ([(3, 0.6), (3, 0.6)], 0, 3),  # one fingertip, two contacts
        ([(2, FIRM), (5, FIRM)], 0, 5),
        ([(2, LIGHT), (5, FIRM)], 0, 5),  # a light touch behind the stop is not heard
        ([(2, FIRM), (5, LIGHT)], 0, DEAD),
        ([(2, FIRM)], 2, 2),  # under the capo
        ([(1, LIGHT)], 2, 2),
        ([(3, LIGHT)], 2, DEAD),
        ([(4, FIRM)], 2, 4),
    ],
)
def test_cases_worked_by_hand(contacts, capo, sounding):
    frets = read({5: contacts}).sounding_fret(capo)
    assert frets.dtype == np.int8
    np.testing.assert_array_equal(frets, [[capo, capo, capo, capo, sounding, capo]])


def strokes(
    nails: dict[int, tuple[np.ndarray, np.ndarray]], samples: int
) -> tuple[np.ndarray, np.ndarray]:
    """Readings (S, nsensordata) and times (S,) while nails go straight from point to point."""
    time_s = 0.5 + STEP_S * np.arange(samples)
    data = np.zeros((samples, MODEL.nsensordata))
    share = np.linspace(0.0, 1.0, samples)[:, None]
    for finger, nail in enumerate(NAILS):
        aside = np.array([HOLE_X, 0.3, 0.05])
        start, end = nails.get(finger, (aside, aside))
        data[:, place(nail)] = start + share * (end - start)
    return data, time_s


def across(
    string: float, x: float, z: float = -0.001, half: float = 0.004
) -> tuple[np.ndarray, np.ndarray]:
    """A way across a string from the bass to the treble side, in the middle over the string."""
    y = float(GUITAR.string_y(np.array(string), x))
    return np.array([x, y - half, z]), np.array([x, y + half, z])


def heard(nails: dict[int, tuple[np.ndarray, np.ndarray]], samples: int = 20) -> Plucks:
    return plucks(MODEL, *strokes(nails, samples), GUITAR)


@given(
    string=st.integers(1, 6),
    finger=st.integers(0, 3),
    x_share=st.floats(-0.99, 0.99),
    back=st.booleans(),
    share=st.floats(0.05, 0.95),
    samples=st.integers(3, 40),
)
def test_a_stroke_plucks_its_string_once(*, string, finger, x_share, back, share, samples):
    x = HOLE_X + x_share * HOLE_R
    start, end = across(string, x)
    shift = (0.5 - share) * (end - start)  # so that it crosses at that share of the way
    way = (end + shift, start + shift) if back else (start + shift, end + shift)
    found = heard({finger: way}, samples)
    length_s = STEP_S * (samples - 1)
    expected_s = 0.5 + length_s * (1 - share if back else share)
    assert (found.string.tolist(), found.finger.tolist()) == ([string], [finger])
    assert found.time_s[0] == pytest.approx(expected_s, abs=1e-9)
    assert found.speed_m_s[0] == pytest.approx(0.008 / length_s)
    assert found.x_m[0] == pytest.approx(x)
    after_s = 0.5 + STEP_S * found.step[0]
    assert after_s - STEP_S - 1e-9 <= found.time_s[0] <= after_s + 1e-9


@given(st.integers(1, 6), st.floats(1e-6, 0.02), st.floats(1e-6, 0.1), st.booleans())
def test_nothing_is_plucked_over_a_string_or_beside_the_sound_hole(string, z, aside, towards_neck):
    x = HOLE_X + (HOLE_R + aside) * (-1 if towards_neck else 1)
    assert heard({1: across(string, HOLE_X, z)}).time_s.size == 0
    assert heard({1: across(string, x)}).time_s.size == 0


def test_height_counts_at_the_crossing_only():
    start, end = across(3, HOLE_X, 0.0)
    start[2], end[2] = 0.004, -0.006  # already below the string in the middle of the way
    assert heard({1: (start, end)}).string.tolist() == [3]
    start[2], end[2] = 0.006, -0.004
    assert heard({1: (start, end)}).string.tolist() == []


def test_a_sweep_plucks_all_strings_in_their_order():
    start, end = across(6, HOLE_X)[0], across(1, HOLE_X)[1]
    down, up = heard({0: (start, end)}, 200), heard({0: (end, start)}, 200)
    assert down.string.tolist() == [6, 5, 4, 3, 2, 1]
    assert up.string.tolist() == [1, 2, 3, 4, 5, 6]
    for found in (down, up):
        assert np.all(np.diff(found.time_s) > 0)


def test_plucks_of_several_fingers_come_in_order_of_time():
    late, early = across(1, HOLE_X, half=0.004), across(6, HOLE_X, half=0.004)
    early = (early[0] + (0, 0.003, 0), early[1] + (0, 0.003, 0))
    found = heard({0: early, 3: late, 1: across(3, HOLE_X, z=0.01)})
    assert found.string.tolist() == [6, 1]
    assert found.finger.tolist() == [0, 3]
    assert found.string.dtype == found.finger.dtype == np.int8


def test_a_nail_that_stays_where_it_is_plucks_nothing():
    point = across(4, HOLE_X)[0]
    assert heard({1: (point, point)}).time_s.size == 0


@given(st.floats(-5, 5), st.floats(-5, 5))
def test_power_adds_up_whatever_its_sign(force, velocity):
    data = np.zeros((2, MODEL.nsensordata))
    for actuator in ("lh_A_FFJ3", "lh_A_forearm_x"):
        data[1, place(f"{actuator}_force")] = force
        data[1, place(f"{actuator}_velocity")] = velocity
    np.testing.assert_allclose(left_power(MODEL, data), [0.0, 2 * abs(force * velocity)])


def test_power_is_that_of_the_actuators_in_physics():
    data = mujoco.MjData(MODEL)
    data.ctrl[:] = 0.3 * MODEL.actuator_ctrlrange[:, 1]
    mujoco.mj_step(MODEL, data, nstep=20)
    mujoco.mj_forward(MODEL, data)
    expected = np.abs(data.actuator_force * data.actuator_velocity)[:23].sum()
    assert left_power(MODEL, data.sensordata[None])[0] == pytest.approx(expected)
    assert expected > 0.1
