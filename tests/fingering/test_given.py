from roboguitarist.fingering.given import SOON_S, moments, recurrences
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature


def test_a_place_comes_again_if_no_other_fret_of_its_string_comes_first():
    events = [(0.0, 1, 5), (0.1, 2, 5), (0.2, 1, 5), (0.3, 1, 7), (0.4, 1, 5), (0.5, 2, 5)]
    assert recurrences(events) == [0.2, 0.5, 0.0, 0.0, 0.0, 0.0]


def test_and_if_it_comes_soon():
    assert recurrences([(0.0, 1, 5), (SOON_S + 0.1, 1, 5)]) == [0.0, 0.0]


def test_a_chord_is_one_moment_and_what_the_guitar_lacks_is_left_out():
    notes = (
        Note(0.0, 1, 3, 1.0, left_finger=4),
        Note(0.0, 2, 0, 2.0),
        Note(0.0, 3, 21, 1.0),
        Note(0.5, 1, 5, 1.0),
    )
    first, second = moments(Tablature(notes, capo=1), Guitar())
    assert first.notes == (0, 1)
    assert first.end_s == (0.5, 2.0)
    assert list(first.forms) == [(((1, 4), (2, 0)), (4, 0))]
    assert len(second.forms) == 4
