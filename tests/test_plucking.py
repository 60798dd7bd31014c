from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist import plucking
from roboguitarist.fingering import assign
from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.hands import VARIANTS, Variant
from roboguitarist.performance import simulate
from roboguitarist.plan import HandPlan
from roboguitarist.plucking import DEPTH_M, THUMB, Stroke, find_strokes, thumb_directions, tip_path
from roboguitarist.scene import SceneConfig, build
from roboguitarist.sensing import Plucks, plucks
from roboguitarist.tablature import Note, Tablature

GUITAR = Guitar()
STRINGS_Y = GUITAR.string_y(STRINGS, GUITAR.sound_hole_x_m)
FINE_S = 0.0005


def tablature(*notes: tuple[float, int], marks: str = "") -> Tablature:
    """Open strings from (onset, string), with marked right fingers if any."""
    fingers = marks or [None] * len(notes)
    made = [
        Note(onset, string, 0, 0.3, right_finger=mark)
        for (onset, string), mark in zip(notes, fingers, strict=True)
    ]
    return Tablature(tuple(sorted(made, key=lambda note: note.place)))


def in_turn(gap_s: float, strings: list[int]) -> list[tuple[float, int]]:
    return [(round(gap_s * index, 6), string) for index, string in enumerate(strings)]


def strokes_of(finger: int, gap_s: float, *strings: tuple[int, ...]) -> tuple[Stroke, ...]:
    return tuple(Stroke(finger, 0.5 + gap_s * k, crossed) for k, crossed in enumerate(strings))


def drawn(finger: int, played: list[tuple[float, tuple[int, ...]]]) -> tuple[Stroke, ...]:
    """Strokes from (gap before, strings)."""
    times = 0.5 + np.cumsum([gap for gap, _ in played])
    return tuple(
        Stroke(finger, time, strings)
        for time, (_, strings) in zip(times.tolist(), played, strict=True)
    )


def crossings(path: np.ndarray, time_s: np.ndarray) -> list[tuple[float, int, float]]:
    """Times, strings and depths at which a path (T, 3) crosses strings below their axes."""
    offset = path[:, 1, None] - GUITAR.string_y(STRINGS, path[:, 0, None])
    step, string = np.nonzero((offset[:-1] < 0) != (offset[1:] < 0))
    share = offset[step, string] / (offset[step, string] - offset[step + 1, string])
    z = path[step, 2] + share * (path[step + 1, 2] - path[step, 2])
    time = time_s[step] + share * (time_s[step + 1] - time_s[step])
    crossed = zip(time.tolist(), string.tolist(), z.tolist(), strict=True)
    return [(t, s + 1, h) for t, s, h in crossed if h < 0]


def test_strokes_gather_what_one_finger_plays_at_once():
    fingering = assign(tablature((0.0, 6), (0.0, 5), (0.0, 1), (0.5, 4), (0.5, 3), (0.5, 2)))
    thumb, index, middle, ring = find_strokes(fingering)
    assert thumb == (Stroke(0, 0.0, (6, 5)), Stroke(0, 0.5, (4,)))
    assert (index, middle) == ((Stroke(1, 0.5, (3,)),), (Stroke(2, 0.5, (2,)),))
    assert ring == (Stroke(3, 0.0, (1,)),)


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(1, 6)), unique=True, max_size=20))
def test_every_note_belongs_to_one_stroke_of_its_finger(grid):
    fingering = assign(tablature(*((0.1 * tick, string) for tick, string in grid)))
    strokes = [stroke for finger in find_strokes(fingering) for stroke in finger]
    played = [(round(s.time_s, 6), string, s.finger) for s in strokes for string in s.strings]
    notes = zip(fingering.tablature.notes, fingering.right.tolist(), strict=True)
    assert sorted(played) == sorted((round(n.onset_s, 6), n.string, right) for n, right in notes)
    for finger in find_strokes(fingering):
        assert np.all(np.diff([stroke.time_s for stroke in finger]) > 0)


def test_the_thumb_goes_down_where_it_has_time():
    strokes = strokes_of(THUMB, 0.6, (6,), (4,), (5,), (5, 4), (6, 5), (6,), (6,))
    assert thumb_directions(strokes, STRINGS_Y) == [True] * 7
    assert thumb_directions((), STRINGS_Y) == []


def test_the_thumb_alternates_on_one_string_where_it_has_none():
    down = thumb_directions(strokes_of(THUMB, 0.06, *[(5,)] * 7), STRINGS_Y)
    assert down == [True, False, True, False, True, False, True]


def test_the_thumb_sweeps_from_string_to_string():
    fast = strokes_of(THUMB, 0.06, (6,), (5,), (4,))
    assert thumb_directions(fast, STRINGS_Y) == [True] * 3
    assert thumb_directions(strokes_of(THUMB, 0.06, (4,), (5,), (6,)), STRINGS_Y) == [False] * 3


def effort(strokes: tuple[Stroke, ...], down: tuple[bool, ...]) -> float:
    """Squared speeds of the ways between strokes, and what up-strokes cost."""
    total, places = 0.0, []
    for stroke, is_down in zip(strokes, down, strict=True):
        strings = stroke.strings if is_down else stroke.strings[::-1]
        sign = 1 if is_down else -1
        start = STRINGS_Y[strings[0] - 1] - sign * plucking.THUMB_REACH_M
        places.append((start, STRINGS_Y[strings[-1] - 1] + sign * plucking.THUMB_REACH_M))
        total += 0.0 if is_down else plucking.UP_STROKE_COST * len(strings) ** 2
    for index in range(1, len(strokes)):
        way = sorted((places[index - 1][1], places[index][0]))
        hops = sum(way[0] < y < way[1] for y in STRINGS_Y)
        gap_s = strokes[index].time_s - strokes[index - 1].time_s
        total += ((way[1] - way[0] + plucking.HOP_M * hops) / gap_s) ** 2
    return total


bass = st.sampled_from([(6,), (5,), (4,), (6, 5), (5, 4), (6, 4), (6, 5, 4)])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(0.03, 0.5), bass), min_size=1, max_size=7))
def test_the_thumbs_directions_are_the_best_of_all(played):
    strokes = drawn(THUMB, played)
    chosen = thumb_directions(strokes, STRINGS_Y)
    choices = product((True, False), repeat=len(strokes))
    best = min(effort(strokes, down) for down in choices)
    assert effort(strokes, tuple(chosen)) == pytest.approx(best, abs=1e-9)


def path_of(finger: int, strokes: tuple[Stroke, ...]) -> tuple[np.ndarray, np.ndarray]:
    time_s = np.arange(-0.5, strokes[-1].time_s + 0.7, FINE_S)
    return tip_path(finger, strokes, time_s, GUITAR), time_s


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 3),
    st.lists(st.tuples(st.floats(0.06, 1.0), st.integers(1, 3)), min_size=1, max_size=6),
)
def test_a_finger_crosses_each_string_asked_once_and_in_time(finger, played):
    strokes = drawn(finger, [(gap, (string,)) for gap, string in played])
    times = [stroke.time_s for stroke in strokes]
    found = crossings(*path_of(finger, strokes))
    assert [string for _, string, _ in found] == [stroke.strings[0] for stroke in strokes]
    np.testing.assert_allclose([time for time, _, _ in found], times, rtol=0, atol=1e-3)
    np.testing.assert_allclose([depth for _, _, depth in found], -DEPTH_M, atol=2e-4)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.floats(0.06, 1.0), bass), min_size=1, max_size=6))
def test_the_thumb_crosses_each_string_asked_once_and_nearly_in_time(played):
    strokes = drawn(THUMB, played)
    found = crossings(*path_of(THUMB, strokes))
    asked = [string for stroke in strokes for string in stroke.strings]
    assert sorted(string for _, string, _ in found) == sorted(asked)
    for stroke in strokes:
        reach_s = 1e-3 + plucking.SWEEP_S * (stroke.strings[0] - stroke.strings[-1]) / 2
        near = {s for t, s, _ in found if abs(t - stroke.time_s) <= reach_s}
        assert set(stroke.strings) <= near


@pytest.mark.parametrize("finger", range(4))
def test_the_tips_stay_in_the_sound_hole_and_smooth(finger):
    strings = ((4 - finger,),) if finger else ((6,), (5, 4), (6, 4), (4,))
    path, time_s = path_of(finger, strokes_of(finger, 0.15, *strings * 4))
    along = path[:, 0] - GUITAR.sound_hole_x_m
    assert np.all(np.abs(along) < GUITAR.sound_hole_radius_m)
    assert np.ptp(along) == 0
    speed = np.linalg.norm(np.diff(path, axis=0), axis=1) / FINE_S
    assert speed.max() < 2.0
    assert speed[time_s[1:] < 0.3].max() < 0.05


def test_a_finger_returns_over_the_strings_on_an_ellipse():
    path, _ = path_of(1, strokes_of(1, 0.5, (3,)))
    y, z = (path[:, k] - (path[:, k].min() + path[:, k].max()) / 2 for k in (1, 2))
    cos, sin = np.cos(plucking.TILT_RAD), np.sin(plucking.TILT_RAD)
    a, b = plucking.ELLIPSE_M
    on_axes = (y * cos + z * sin) / a, (-y * sin + z * cos) / b
    np.testing.assert_allclose(on_axes[0] ** 2 + on_axes[1] ** 2, 1, atol=2e-3)


@pytest.mark.parametrize("finger", range(4))
def test_a_finger_without_notes_waits_above_its_string(finger):
    path = tip_path(finger, (), np.arange(0.0, 1.0, 0.1), GUITAR)
    assert np.ptp(path, axis=0).max() == 0 < path[0, 2] - 0.002


def played(fingering_of: Tablature, hand: Variant = "linkage") -> tuple[Plucks, np.ndarray]:
    """Plucks of the right hand while the left rests, and the fingers that were asked."""
    fingering, scene = assign(fingering_of), SceneConfig(hand=hand, visuals=False)
    right, model = plucking.plan(fingering, scene), build(scene)
    count = len(right.time_s)
    qpos, ctrl = np.zeros((count, 27)), np.zeros((count, 23))
    qpos[:, 2] = ctrl[:, 2] = 0.05
    recording = simulate(model, HandPlan(right.time_s, qpos, ctrl), right)
    return plucks(model, recording.sensordata, recording.time_s, GUITAR), fingering.right


CASES = {
    "all six strings": tablature(*in_turn(0.3, [6, 5, 4, 3, 2, 1, 2, 3, 4, 5, 6])),
    "arpeggio at 60 ms": tablature(*in_turn(0.06, [6, 3, 2, 1, 2, 3] * 4)),
    "fingers repeat at 60 ms": tablature(*in_turn(0.06, [1] * 10)),
    "thumb repeats at 60 ms": tablature(*in_turn(0.06, [5] * 10)),
    "i and m in turn on one string": tablature(*in_turn(0.12, [1] * 12), marks="im" * 6),
    "i and m from string to string": tablature(
        *in_turn(0.12, [3, 3, 2, 2, 1, 1, 1, 2, 3]), marks="imimimimi"
    ),
    "chords": tablature(*((0.5 * k, s) for k in range(5) for s in (4 + k % 3, 3, 2, 1))),
}


@pytest.mark.parametrize("hand", VARIANTS)
@pytest.mark.parametrize("piece", CASES.values(), ids=CASES)
def test_every_note_is_plucked_once_by_its_finger_and_in_time(piece, hand):
    found, fingers = played(piece, hand)
    asked = sorted((n.string, n.onset_s, f) for n, f in zip(piece.notes, fingers, strict=True))
    heard = sorted(
        zip(found.string.tolist(), found.time_s.tolist(), found.finger.tolist(), strict=True)
    )
    assert [(s, f) for s, _, f in heard] == [(s, f) for s, _, f in asked]
    error_ms = 1e3 * np.abs(np.array([t for _, t, _ in heard]) - [t for _, t, _ in asked])
    assert np.median(error_ms) <= 10
    assert np.percentile(error_ms, 95) <= 25


@pytest.mark.parametrize("pair", [(6, 5), (5, 4)])
def test_two_bass_strings_at_once_are_both_plucked(pair):
    piece = tablature(*((0.5 * k, s) for k in range(5) for s in pair))
    found, _ = played(piece)
    assert found.string.tolist() == list(pair) * 5
    np.testing.assert_allclose(found.time_s, np.repeat(0.5 * np.arange(5), 2), rtol=0, atol=0.02)


@pytest.mark.parametrize("case", ["all six strings", "arpeggio at 60 ms", "chords"])
def test_a_plan_keeps_to_the_ranges_of_joints_and_servos(case):
    plan = plucking.plan(assign(CASES[case]), SceneConfig(visuals=False))
    model = plucking.right_hand(SceneConfig())
    low, high = model.jnt_range.T
    # Between two solutions of the inverse kinematics the spline may overshoot a little.
    assert np.all((low - 0.02 <= plan.qpos) & (plan.qpos <= high + 0.02))
    low, high = model.actuator_ctrlrange.T
    assert np.all((low <= plan.ctrl) & (plan.ctrl <= high))
    assert np.abs(np.diff(plan.qpos[:100], axis=0)).max() < 1e-3


def test_onsets_that_rounding_parts_are_one_stroke():
    for onset in (0.002999, 0.502, 1.000999):
        fingering = assign(tablature((onset, 6), (onset + 1e-6, 5)))
        assert [stroke.strings for stroke in find_strokes(fingering)[0]] == [(6, 5)]
