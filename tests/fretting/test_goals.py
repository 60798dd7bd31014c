from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from builders import perfect, tablatures
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering, assign
from roboguitarist.fretting.goals import NEVER_S, Goals, goals, key_centres, one_hot, simplified
from roboguitarist.fretting.presses import tip_height
from roboguitarist.guitar import Guitar
from roboguitarist.metrics import Score, frame
from roboguitarist.tablature import Note, Tablature

GUITAR = Guitar()
RATES = st.sampled_from([10.0, 30.0, 47.0])
LEADS = st.sampled_from([0.0, 0.25, 1.0])


def fingering_of(*notes: Note, **settings) -> Fingering:
    return assign(Tablature(tuple(sorted(notes, key=lambda note: note.place)), **settings))


def goals_of(*notes: Note, control_hz: float = 10.0, lead_s: float = 0.0, **settings) -> Goals:
    return goals(fingering_of(*notes, **settings), GUITAR, control_hz, lead_s)


@settings(max_examples=60, deadline=None)
@given(tablatures(), RATES, LEADS)
def test_whoever_holds_what_is_asked_gets_a_perfect_score(tablature, control_hz, lead_s):
    asked = goals(assign(tablature), GUITAR, control_hz, lead_s)
    cells = asked.fret[..., None] == np.arange(1, GUITAR.n_frets + 1)
    played = replace(perfect(tablature), time_s=asked.time_s, press_force_n=3.0 * cells)
    assert frame(played, tablature) == (Score(1.0, 1.0, 1.0) if cells.any() else None)


@settings(max_examples=60, deadline=None)
@given(tablatures(), RATES, LEADS)
def test_fingers_press_what_is_asked_and_nothing_else(tablature, control_hz, lead_s):
    fingering = assign(tablature)
    asked = goals(fingering, GUITAR, control_hz, lead_s)
    fits = asked.fret[:, :, None] == asked.finger_fret[:, None, :]
    assert fits.any(axis=1)[asked.finger_string > 0].all()
    if not fingering.problems:
        assert fits.any(axis=2)[asked.fret > 0].all()


@settings(max_examples=60, deadline=None)
@given(tablatures(), LEADS)
def test_what_comes_next_is_there_when_its_time_has_come(tablature, lead_s):
    asked = goals(assign(tablature), GUITAR, 30.0, lead_s)
    assert (asked.until_next_s > 0).all()
    assert ((asked.until_next_s == NEVER_S) == (asked.next_string == 0)).all()
    due = asked.until_next_s[:-1] < 1 / 30 - 1e-5
    for name in ("string", "fret", "point_m"):
        now, following = getattr(asked, f"finger_{name}"), getattr(asked, f"next_{name}")
        np.testing.assert_array_equal(now[1:][due], following[:-1][due])
    waiting = (asked.until_next_s[:-1] > 1 / 30 + 1e-5) & (asked.next_string[:-1] > 0)
    passed = asked.until_next_s[:-1] - asked.until_next_s[1:]
    np.testing.assert_allclose(passed[waiting], 1 / 30, atol=1e-5)


@settings(max_examples=30, deadline=None)
@given(tablatures(), RATES, st.integers(0, 4))
def test_both_forms_of_the_string_goal_say_the_same(tablature, control_hz, n_lookahead):
    asked = goals(assign(tablature), GUITAR, control_hz)
    fret = simplified(asked, n_lookahead)
    keys = one_hot(asked, n_lookahead, 20).reshape(*fret.shape, 20)
    assert fret.shape == (len(asked.fret), 6 * (n_lookahead + 1))
    np.testing.assert_array_equal(keys @ np.arange(1, 21), fret)
    np.testing.assert_array_equal(keys.sum(axis=-1), fret > 0)


def test_a_note_is_asked_from_its_onset_until_before_its_end():
    asked = goals_of(Note(0.2, 3, 2, 0.3), Note(0.7, 3, 0, 0.3))
    assert asked.time_s == pytest.approx(np.arange(10) / 10)
    assert asked.fret[:, 2].tolist() == [0, 0, 2, 2, 2, 0, 0, 0, 0, 0]
    assert not np.delete(asked.fret, 2, axis=1).any()


def test_ticks_before_the_start_ask_for_nothing_but_know_what_comes():
    asked = goals_of(Note(0.0, 3, 2, 0.5), lead_s=0.5)
    finger = int(np.flatnonzero(asked.finger_string[5])[0])
    assert asked.time_s[0] == -0.5
    assert asked.fret[:, 2].tolist() == [0] * 5 + [2] * 5
    assert asked.until_next_s[:5, finger] == pytest.approx([0.5, 0.4, 0.3, 0.2, 0.1])
    assert (asked.next_string[0, finger], asked.next_fret[0, finger]) == (3, 2)
    assert (asked.until_next_s[5:, finger] == NEVER_S).all()


def test_a_note_ends_where_its_string_is_played_again():
    asked = goals_of(Note(0.0, 3, 2, 1.0), Note(0.2, 3, 0, 0.2), Note(0.6, 3, 4, 0.4))
    assert asked.fret[:, 2].tolist() == [2, 2, 0, 0, 0, 0, 4, 4, 4, 4]
    assert (asked.finger_fret.max(axis=1) == asked.fret[:, 2]).all()


def test_frets_count_from_the_nut_with_a_capo():
    asked = goals_of(Note(0.0, 3, 2, 0.1), Note(0.0, 1, 0, 0.1), capo=3)
    assert asked.fret.tolist() == [[0, 0, 5, 0, 0, 0]]
    assert asked.finger_fret.max() == 5


def test_a_barre_is_the_goal_of_one_finger_and_six_strings():
    asked = goals_of(*(Note(0.0, string, 5, 0.1) for string in range(1, 7)))
    assert asked.fret.tolist() == [[5] * 6]
    assert asked.finger_string.tolist() == [[6, 0, 0, 0]]


def test_a_finger_stays_down_in_a_short_gap_that_is_not_asked():
    asked = goals_of(Note(0.0, 3, 2, 0.5), Note(0.52, 3, 2, 0.5), control_hz=100.0)
    assert asked.fret[50:52, 2].tolist() == [0, 0]
    assert (asked.finger_string[:100].max(axis=1) == 3).all()


def test_a_finger_aims_at_the_middle_of_its_key():
    asked = goals_of(Note(0.0, 5, 3, 0.1))
    active = asked.finger_string[0] > 0
    x, y, _ = GUITAR.press_point(5, 3, along=0.5)
    middle = [x, y, tip_height(GUITAR)]
    np.testing.assert_allclose(asked.finger_point_m[0, active], [middle], atol=1e-7)
    assert not asked.finger_point_m[0, ~active].any()


def test_key_centres_lie_in_their_fret_spaces():
    string, fret = np.meshgrid(np.arange(1, 7), np.arange(1, 21))
    point = key_centres(string, fret, GUITAR)
    np.testing.assert_array_equal(GUITAR.fret_at(point[..., 0]), fret)
    assert (np.diff(point[..., 1], axis=1) < 0).all()


def test_hand_position_is_that_of_the_last_note_begun():
    fingering = fingering_of(Note(0.3, 3, 2, 0.2), Note(0.6, 3, 9, 0.2))
    first, second = fingering.hold_position.tolist()
    asked = goals(fingering, GUITAR, 10.0)
    assert first != second
    assert asked.hold_position.tolist() == [first] * 6 + [second] * 2


def test_lookahead_goes_on_after_the_end_with_nothing():
    asked = goals_of(Note(0.0, 6, 1, 0.1), Note(0.1, 1, 3, 0.1))
    low, high, rest = [0, 0, 0, 0, 0, 1], [3, 0, 0, 0, 0, 0], [0] * 6
    assert simplified(asked, 0).tolist() == [low, high]
    assert simplified(asked, 2).tolist() == [low + high + rest, high + rest + rest]
    assert np.flatnonzero(one_hot(asked, 1, 20)[0]).tolist() == [5 * 20 + 0, 120 + 2]


def test_frets_beyond_the_neck_have_no_key():
    asked = goals_of(Note(0.0, 1, 12, 0.1))
    assert one_hot(asked, 0, 12).sum() == 1
    assert one_hot(asked, 0, 11).sum() == 0


def test_a_piece_without_notes_asks_for_nothing():
    asked = goals_of()
    assert len(asked.time_s) == 1
    assert not asked.fret.any()
    assert not asked.finger_string.any()
    assert (asked.until_next_s == NEVER_S).all()


def test_shapes_and_types_are_as_documented():
    asked = goals_of(Note(0.0, 3, 2, 0.5), Note(0.5, 1, 0, 0.5))
    found = {f.name: getattr(asked, f.name) for f in fields(asked) if f.name != "control_hz"}
    assert {name: (array.shape[1:], array.dtype.name) for name, array in found.items()} == {
        "time_s": ((), "float64"),
        "fret": ((6,), "int8"),
        "finger_string": ((4,), "int8"),
        "finger_span": ((4,), "int8"),
        "finger_fret": ((4,), "int8"),
        "finger_point_m": ((4, 3), "float32"),
        "next_string": ((4,), "int8"),
        "next_span": ((4,), "int8"),
        "next_fret": ((4,), "int8"),
        "next_point_m": ((4, 3), "float32"),
        "until_next_s": ((4,), "float32"),
        "hold_position": ((), "int8"),
    }
    assert {len(array) for array in found.values()} == {10}


def test_saved_is_loaded(tmp_path):
    asked = goals_of(Note(0.0, 3, 2, 0.5), Note(0.5, 1, 4, 0.5))
    asked.save(tmp_path / "goals.npz")
    loaded = Goals.load(tmp_path / "goals.npz")
    assert loaded.control_hz == 10.0
    for name, array in vars(asked).items():
        np.testing.assert_array_equal(getattr(loaded, name), array)


@pytest.mark.parametrize("settings", [{"control_hz": 0.0}, {"lead_s": -1.0}])
def test_impossible_times_are_refused(settings):
    with pytest.raises(RoboGuitaristError):
        goals_of(Note(0.0, 3, 2, 0.5), **settings)


def test_looking_back_is_refused():
    with pytest.raises(RoboGuitaristError, match="lookahead"):
        simplified(goals_of(Note(0.0, 3, 2, 0.5)), -1)
