import random
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from builders import tablatures
from roboguitarist.fingering import UNPLAYABLE, Fingering
from roboguitarist.fingering.paper import paper
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature


def assign(tablature: Tablature, guitar: Guitar | None = None) -> Fingering:
    return paper(tablature, guitar or Guitar())


def chord(frets: str, onset_s: float = 0.0, duration_s: float = 1.0) -> tuple[Note, ...]:
    """Notes of a chord diagram such as x32010, from string 6 to string 1."""
    pairs = [(6 - place, fret) for place, fret in enumerate(frets) if fret != "x"]
    return tuple(Note(onset_s, string, int(fret), duration_s) for string, fret in pairs[::-1])


def fingers(frets: str) -> str:
    """Left fingers of a chord diagram, in the same order."""
    left = iter(assign(Tablature(chord(frets))).left[::-1])
    return "".join("x" if fret == "x" else str(next(left)) for fret in frets)


@pytest.mark.parametrize(
    ("frets", "expected"),
    [
        ("320003", "320004"),  # G, in the paper's figure 2
        ("x02220", "x01230"),  # A, in the same figure
        ("x32010", "x32010"),
        ("xx0232", "xx0132"),
        ("022100", "023100"),
        ("x02210", "x02310"),
        ("xx0231", "xx0231"),
        ("x21202", "x21304"),
        ("133211", "134211"),
        ("x24432", "x13421"),
    ],
)
def test_common_chords_have_their_usual_fingers(frets: str, expected: str):
    assert fingers(frets) == expected


def test_more_than_four_stops_take_a_barre():
    fingering = assign(Tablature(chord("133211")))
    assert fingering.barre[::-1].tolist() == [True, False, False, False, True, True]
    assert not assign(Tablature(chord("xx3211"))).barre.any()
    assert not fingering.problems


def test_no_barre_lies_over_an_open_string():
    fingering = assign(Tablature(chord("222022")))
    assert not fingering.barre.any()
    assert fingering.problems == ("bar 1, beat 1: string 6 fret 2: all four fingers are in use",)


def lines(fingering: Fingering) -> int:
    return int((fingering.left == UNPLAYABLE).sum())


@given(tablatures())
def test_every_note_has_a_finger_or_a_reason(tablature: Tablature):
    fingering = assign(tablature)
    for note, left in zip(tablature.notes, fingering.left, strict=True):
        assert (left == 0) == (note.fret == 0)
    assert len(fingering.problems) == lines(fingering)


@given(tablatures())
def test_no_finger_is_in_two_places(tablature: Tablature):
    fingering = assign(tablature)
    stopped = [
        (note, left, barre)
        for note, left, barre in zip(tablature.notes, fingering.left, fingering.barre, strict=True)
        if left > 0
    ]
    for (a, left_a, barre_a), (b, left_b, _) in combinations(stopped, 2):
        together = a.onset_s < b.end_s - 1e-5 and b.onset_s < a.end_s - 1e-5
        if left_a == left_b and together:
            assert barre_a
            assert a.fret == b.fret
            assert a.onset_s == b.onset_s


@given(tablatures())
def test_fingers_of_one_onset_do_not_cross(tablature: Tablature):
    fingering = assign(tablature)
    for (i, a), (j, b) in permutations(enumerate(tablature.notes), 2):
        lefts = fingering.left[i], fingering.left[j]
        if a.onset_s == b.onset_s and 0 < lefts[0] < lefts[1]:
            assert (a.fret, -a.string) < (b.fret, -b.string)


@given(tablatures())
def test_fingers_in_use_are_within_reach(tablature: Tablature):
    fingering = assign(tablature)
    for i, note in enumerate(tablature.notes):
        position = fingering.hold_position[i]
        assert tablature.capo < position <= Guitar().n_frets
        for j, other in enumerate(tablature.notes[: i + 1]):
            if fingering.left[j] > 0 and other.end_s > note.onset_s + 1e-5:
                home = position + fingering.left[j] - 1
                assert abs(home - tablature.stopped_fret(other)) <= (0 if fingering.barre[j] else 2)


@given(st.lists(st.integers(5, 15), min_size=1, max_size=30))
def test_a_lone_note_takes_the_finger_over_its_fret(frets: list[int]):
    notes = tuple(Note(0.5 * k, 1 + k % 6, fret, 0.5) for k, fret in enumerate(frets))
    fingering = assign(Tablature(notes))
    assert (fingering.hold_position + fingering.left - 1).tolist() == frets
    shifts = np.diff(fingering.hold_position)
    for shift, before, fret in zip(shifts, fingering.hold_position[:-1], frets[1:], strict=True):
        assert abs(shift) == max(before - fret, fret - before - 3, 0)


@given(tablatures())
def test_one_fret_up_leaves_the_fingers_as_they_were(tablature: Tablature):
    low = assign(tablature, Guitar(n_frets=24))
    high = assign(replace(tablature, capo=tablature.capo + 1), Guitar(n_frets=25))
    assert low.left.tolist() == high.left.tolist()
    assert (low.hold_position + 1).tolist() == high.hold_position.tolist()


@given(tablatures())
def test_twice_the_same(tablature: Tablature):
    first, second = assign(tablature), assign(tablature)
    assert first.left.tobytes() == second.left.tobytes()
    assert first.problems == second.problems


def test_a_note_that_touches_the_next_frees_its_finger():
    notes = tuple(Note(round(k / 3, 6), 2, 1, round(1 / 3, 6)) for k in range(6))
    moved = tuple(replace(note, string=2 + k % 2) for k, note in enumerate(notes))
    assert assign(Tablature(notes)).left.tolist() == [1] * 6
    assert assign(Tablature(moved)).left.tolist() == [1] * 6


def test_a_busy_finger_leaves_the_note_to_the_next_nearest():
    notes = (Note(0.0, 2, 1, 2.0), Note(0.5, 1, 1, 0.5), Note(1.0, 3, 2, 0.5))
    assert assign(Tablature(notes)).left.tolist() == [1, 2, 2]


def test_a_new_note_on_a_string_ends_the_old_one():
    notes = (Note(0.0, 2, 1, 8.0), Note(1.0, 2, 3, 1.0), Note(2.0, 2, 1, 1.0))
    assert assign(Tablature(notes)).left.tolist() == [1, 3, 1]


def test_a_fifth_held_note_is_reported():
    held = chord("x43219")[1:]
    notes = (*held, Note(0.5, 6, 4, 0.5, bar=1, beat=2.0))
    fingering = assign(Tablature(notes))
    assert fingering.left.tolist() == [1, 2, 3, 4, UNPLAYABLE]
    assert fingering.problems == ("bar 1, beat 2: string 6 fret 4: all four fingers are in use",)


def test_held_notes_hold_the_hand_back():
    notes = (Note(0.0, 6, 1, 4.0), Note(1.0, 1, 9, 1.0))
    (line,) = assign(Tablature(notes)).problems
    assert line == "bar 1, beat 1: string 1 fret 9: out of reach of a hand that holds fret 1"


def test_frets_that_are_not_there_and_strings_asked_twice_are_reported():
    notes = (Note(0.0, 1, 3, 1.0), Note(0.0, 1, 5, 1.0), Note(0.0, 2, 21, 1.0))
    fingering = assign(Tablature(notes))
    assert (fingering.left[[0, 2]] == UNPLAYABLE).all()
    assert "another note" in fingering.problems[0]
    assert "the guitar has 20 frets" in fingering.problems[1]


@given(st.lists(st.integers(1, 4), min_size=1, max_size=4), st.permutations(range(1, 7)))
def test_a_chord_costs_as_little_as_any_that_does_not_cross(frets: list[int], strings: list[int]):
    stops = sorted(zip(frets, [-string for string in strings], strict=False))
    notes = [Note(0.0, -string, fret, 1.0) for fret, string in stops]
    tablature = Tablature(tuple(sorted(notes, key=lambda note: note.place)))
    costs = [
        [abs(finger - fret) for finger, (fret, _) in zip(chosen, stops, strict=True)]
        for chosen in combinations((1, 2, 3, 4), len(stops))
    ]
    easy = [sum(cost) for cost in costs if max(cost) <= 1]
    fingering = assign(tablature)
    if easy:
        paired = zip(fingering.left, tablature.notes, strict=True)
        assert sum(abs(left - note.fret) for left, note in paired) == min(easy)


def test_a_capo_is_the_nut():
    fingering = assign(Tablature(chord("x32010"), capo=3))
    assert fingering.left[::-1].tolist() == [3, 2, 0, 1, 0]
    assert set(fingering.hold_position) == {4}


def test_left_marks_are_kept_if_they_can_be():
    marked = (
        replace(chord("xxxx1x")[0], left_finger=2),
        replace(chord("xxx2xx", 0.5)[0], left_finger=2),
    )
    fingering = assign(Tablature(marked))
    assert fingering.left.tolist() == [2, 3]
    assert fingering.problems == (
        "bar 1, beat 1: string 3 fret 2: marked for finger 2, played by finger 3",
    )


def test_a_finger_marked_on_two_strings_of_a_fret_is_a_barre():
    notes = tuple(replace(note, left_finger=1) for note in chord("xxxx22"))
    fingering = assign(Tablature(notes))
    assert fingering.left.tolist() == [1, 1]
    assert fingering.barre.all()


@pytest.mark.parametrize(
    ("strings", "marks", "expected"),
    [
        ((6, 5, 4, 3, 2, 1), (None,) * 6, (0, 0, 0, 1, 2, 3)),
        ((1,), ("m",), (2,)),
        ((1,), ("p",), (3,)),
        ((5,), ("i",), (0,)),
        ((2, 1), ("i", "m"), (1, 2)),
        ((2, 1), ("m", "m"), (2, 3)),
        ((2, 1), ("a", "m"), (2, 3)),
        ((1,), ("c",), (3,)),
    ],
)
def test_right_fingers(
    strings: tuple[int, ...], marks: tuple[str | None, ...], expected: tuple[int, ...]
):
    notes = [
        Note(0.0, string, 0, 1.0, right_finger=mark)
        for string, mark in zip(strings, marks, strict=True)
    ]
    assert assign(Tablature(tuple(notes[::-1]))).right[::-1].tolist() == list(expected)


def test_an_empty_piece_has_no_fingers():
    fingering = assign(Tablature(()))
    assert fingering.left.shape == fingering.right.shape == (0,)


def test_a_long_score_ends_in_good_time():
    generator = random.Random(0)
    notes = []
    for onset in range(600):
        for string in sorted(generator.sample(range(1, 7), generator.choice([1, 1, 2, 3, 4, 6]))):
            notes.append(Note(0.2 * onset, string, generator.randint(0, 6), 0.4))
    assert assign(Tablature(tuple(notes))).left.shape == (len(notes),)
