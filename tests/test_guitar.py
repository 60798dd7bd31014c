from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.guitar import PRESETS, STRINGS, Guitar, preset
from roboguitarist.plucking import PLUCK_X_M

SCALES = st.floats(0.3, 1.0)
GUITARS = st.builds(
    lambda base, scale, nut, fan: replace(
        base, scale_length_m=scale, nut_span_m=nut, saddle_span_m=nut + fan
    ),
    st.sampled_from(list(PRESETS.values())),
    SCALES,
    st.floats(0.03, 0.06),
    st.floats(0.001, 0.03),
)
every_preset = pytest.mark.parametrize("guitar", PRESETS.values(), ids=PRESETS)


@given(GUITARS)
def test_fret_12_halves_the_string_and_fret_0_is_the_nut(guitar):
    assert guitar.fret_x(12) == pytest.approx(guitar.scale_length_m / 2)
    assert guitar.fret_x(0) == 0.0


@given(GUITARS)
def test_each_fret_raises_the_pitch_by_a_semitone(guitar):
    sounding_m = guitar.scale_length_m - guitar.fret_x(np.arange(guitar.n_frets + 1))
    np.testing.assert_allclose(sounding_m[:-1] / sounding_m[1:], 2 ** (1 / 12), rtol=1e-12)


@given(GUITARS)
def test_frets_come_closer_towards_the_bridge(guitar):
    spaces = np.diff(guitar.fret_x(np.arange(guitar.n_frets + 1)))
    assert np.all(spaces > 0)
    assert np.all(np.diff(spaces) < 0)


@given(GUITARS, st.floats(0.001, 0.999))
def test_fret_at_inverts_press_point(guitar, along):
    for string in STRINGS:
        points = [guitar.press_point(string, n, along) for n in range(1, guitar.n_frets + 1)]
        x = np.array(points)[:, 0]
        np.testing.assert_array_equal(guitar.fret_at(x), np.arange(1, guitar.n_frets + 1))


@every_preset
def test_a_wire_stops_what_is_pressed_behind_it(guitar):
    wires = guitar.fret_x(np.arange(1, guitar.n_frets + 1))
    frets = np.arange(1, guitar.n_frets + 1)
    np.testing.assert_array_equal(guitar.fret_at(wires - 1e-9), frets)
    np.testing.assert_array_equal(guitar.fret_at(wires), frets)
    np.testing.assert_array_equal(guitar.fret_at(wires + 1e-9), frets + 1)


@every_preset
def test_beyond_the_nut_is_0_and_beyond_the_last_wire_one_more(guitar):
    assert guitar.fret_at(np.array(-0.01)) == 0
    assert guitar.fret_at(np.array(guitar.scale_length_m)) == guitar.n_frets + 1


@given(GUITARS, st.integers(1, 6), st.integers(1, 19), st.floats(0, 1))
def test_a_press_point_lies_on_its_string_in_its_space(guitar, string, fret, along):
    x, y, z = guitar.press_point(string, fret, along)
    assert guitar.fret_x(fret - 1) - 1e-12 <= x <= guitar.fret_x(fret) + 1e-12
    assert y == guitar.string_y(string, x)
    assert z == 0.0


@given(GUITARS)
def test_string_1_is_treble_and_strings_are_evenly_spaced_about_the_middle(guitar):
    for x, span in ((0.0, guitar.nut_span_m), (guitar.scale_length_m, guitar.saddle_span_m)):
        y = guitar.string_y(STRINGS, x)
        assert y[0] == pytest.approx(span / 2)
        np.testing.assert_allclose(y, -y[::-1], atol=1e-15)
        np.testing.assert_allclose(np.diff(y), -span / 5)


@given(GUITARS, st.floats(0, 1), st.floats(0.01, 1))
def test_strings_fan_out_in_straight_lines(guitar, start, step):
    first, second, third = (guitar.string_y(STRINGS, start + k * step) for k in range(3))
    assert np.all(np.abs(second) > np.abs(first))
    np.testing.assert_allclose(third - second, second - first, atol=1e-12)


@every_preset
def test_presets_hold_together(guitar):
    assert preset(guitar.name) is guitar
    end = guitar.fret_x(guitar.n_frets)
    hole = guitar.sound_hole_x_m + guitar.sound_hole_radius_m * np.array((-1, 1))
    assert guitar.body_x_m < end < guitar.scale_length_m
    assert end - 0.03 < hole[0] < hole[1] < guitar.scale_length_m
    assert guitar.action_m > guitar.string_radius_m
    assert guitar.sound_hole_radius_m > np.abs(PLUCK_X_M).max() + 0.004


def test_the_classical_guitar_keeps_its_dimensions():
    guitar = preset("classical")
    assert guitar == Guitar()
    wires = guitar.fret_x(np.array([1, 5, 7, 12, 20]))
    np.testing.assert_allclose(wires, [0.03648, 0.16305, 0.21618, 0.325, 0.44526], atol=5e-6)
    np.testing.assert_allclose(guitar.string_y(STRINGS)[:2], [0.0215, 0.0129])


def test_an_unknown_guitar_is_refused_with_the_names_there_are():
    with pytest.raises(RoboGuitaristError) as caught:
        preset("banjo")
    assert "'banjo'" in str(caught.value)
    assert all(name in str(caught.value) for name in PRESETS)
