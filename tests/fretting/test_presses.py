from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings

from builders import tablatures
from roboguitarist.fingering import assign
from roboguitarist.fretting.presses import TIP_GAP_M, Press, find_presses, press_point, tip_height
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature

GUITAR = Guitar()


def presses_of(*notes: Note, **settings) -> list[Press]:
    ordered = tuple(sorted(notes, key=lambda note: note.place))
    rows = find_presses(assign(Tablature(ordered, **settings)), GUITAR)
    return sorted((press for row in rows for press in row), key=lambda press: press.start_s)


def test_open_strings_need_no_finger():
    assert presses_of(Note(0.0, 1, 0, 1.0), Note(1.0, 6, 0, 1.0)) == []


def test_one_note_is_one_press():
    (press,) = presses_of(Note(0.5, 3, 2, 1.0))
    assert (press.string, press.fret, press.start_s, press.end_s) == (3, 2, 0.5, 1.5)


def test_repeated_notes_on_one_place_are_held():
    (press,) = presses_of(Note(0.0, 3, 2, 0.5), Note(0.5, 3, 2, 0.5), Note(1.03, 3, 2, 0.5))
    assert (press.start_s, press.end_s) == (0.0, 1.53)


def test_a_rest_lets_the_finger_go():
    assert len(presses_of(Note(0.0, 3, 2, 0.5), Note(1.0, 3, 2, 0.5))) == 2


def test_a_note_ends_where_its_string_is_played_again():
    first, _ = presses_of(Note(0.0, 3, 2, 2.0), Note(0.5, 3, 4, 1.0))
    assert first.end_s == 0.5
    (only,) = presses_of(Note(0.0, 3, 2, 2.0), Note(0.5, 3, 0, 1.0))
    assert only.end_s == 0.5


def test_frets_count_from_the_nut_with_a_capo():
    (press,) = presses_of(Note(0.0, 3, 2, 1.0), capo=3)
    assert press.fret == 5


def test_a_barre_is_one_press_over_all_its_strings():
    notes = [Note(0.0, string, 5, 1.0) for string in (1, 2, 3, 4, 5)]
    barre = presses_of(*notes)
    assert [(press.string, press.barre_to) for press in barre if press.finger == 1] == [(5, 1)]


def test_fingertips_of_one_fret_are_set_apart_and_stay_in_it():
    # A major: three fingertips of 13 mm side by side in a fret space of 34 mm.
    frets = {4: 2, 3: 2, 2: 2, 1: 0}
    chord = presses_of(*(Note(0.0, string, fret, 1.0) for string, fret in frets.items()))
    low, high = GUITAR.fret_x(1), GUITAR.fret_x(2)
    assert all(low < press.x_m < high for press in chord)
    by_finger = sorted(chord, key=lambda press: press.finger)
    points = [press_point(press, GUITAR)[:2] for press in by_finger]
    gaps = [np.linalg.norm(b - a) for a, b in pairwise(points)]
    assert min(gaps) > 0.8 * TIP_GAP_M
    assert [press.x_m for press in by_finger] == sorted(press.x_m for press in chord)


def test_fingertip_touches_the_string_it_is_over():
    (press,) = presses_of(Note(0.0, 6, 3, 1.0))
    x, y, z = press_point(press, GUITAR)
    assert y == pytest.approx(float(GUITAR.string_y(6, x)))
    assert z == tip_height(GUITAR)


@settings(max_examples=40, deadline=None)
@given(tablatures())
def test_every_finger_is_in_one_place_at_a_time(tablature):
    for finger, row in enumerate(find_presses(assign(tablature), GUITAR), start=1):
        assert all(press.finger == finger for press in row)
        assert all(a.end_s <= b.start_s + 1e-9 for a, b in pairwise(row))
        assert all(int(GUITAR.fret_at(np.array(press.x_m))) == press.fret for press in row)
