from itertools import pairwise

import pytest
from hypothesis import given, settings

from builders import tablatures
from roboguitarist.fingering.right import THUMB, by_string, right_hand
from roboguitarist.tablature import Note, Tablature, Technique

steady = settings(deadline=None)

P, I, M, A = range(4)  # noqa: E741 - the names of the fingers


def right(*events: tuple[float, tuple[int, ...]]) -> list[int]:
    """Fingers of strings, bass first, at each time."""
    notes = [Note(t, s, 0, 0.05) for t, strings in events for s in sorted(strings)]
    found = dict(zip(notes, right_hand(Tablature(tuple(notes)))[0].tolist(), strict=True))
    order = [(t, s) for t, strings in events for s in sorted(strings, reverse=True)]
    by_place = {(note.onset_s, note.string): finger for note, finger in found.items()}
    return [by_place[place] for place in order]


@pytest.mark.parametrize(
    ("strings", "expected"),
    [
        ((3, 2, 1), [I, M, A]),
        ((6, 3, 2, 1), [P, I, M, A]),
        ((5, 4), [P, I]),
        ((6, 5, 4, 3, 2, 1), [P, P, P, I, M, A]),
        ((5, 4, 2), [P, I, M]),
    ],
)
def test_chords(strings: tuple[int, ...], expected: list[int]):
    assert right((0.0, strings)) == expected


def test_slow_notes_follow_the_papers_rule():
    events = [(0.5 * k, (string,)) for k, string in enumerate((6, 5, 4, 3, 2, 1, 1, 1))]
    assert right(*events) == [P, P, P, I, M, A, A, A]


def test_fast_repeated_notes_alternate():
    for string in (1, 2, 3):
        fingers = right(*((0.125 * k, (string,)) for k in range(8)))
        assert all(a != b for a, b in pairwise(fingers))
        assert THUMB not in fingers


def test_a_fast_thumb_gets_help():
    fingers = right(*((0.08 * k, (string,)) for k, string in enumerate((5, 4, 5, 4))))
    assert all(a != b for a, b in pairwise(fingers))


@steady
@given(tablatures())
def test_no_finger_but_the_thumb_has_two_strings_at_once_and_none_cross(tablature: Tablature):
    fingers, _ = right_hand(tablature)
    chords: dict[float, list[tuple[int, int]]] = {}
    for note, finger in zip(tablature.notes, fingers, strict=True):
        chords.setdefault(note.onset_s, []).append((-note.string, int(finger)))
    for chord in chords.values():
        for (_, lower), (_, higher) in pairwise(sorted(chord)):
            assert lower < higher or lower == higher == THUMB


def test_marks_are_kept():
    notes = tuple(Note(0.1 * k, 1, 0, 0.1, right_finger=f) for k, f in enumerate("pimaapm"))
    assert right_hand(Tablature(notes))[0].tolist() == [P, I, M, A, A, P, M]


def strum(tablature: Tablature) -> list[int]:
    return right_hand(tablature)[1].tolist()


def test_four_strings_within_60_ms_are_a_strum():
    down = [Note(0.015 * (6 - s), s, 0, 1.0) for s in (6, 5, 4, 3)]
    up = [Note(1.0 + 0.015 * s, s, 0, 1.0) for s in (1, 2, 3, 4)]
    apart = [Note(2.0 + 0.03 * s, s, 0, 1.0) for s in (1, 2, 3, 4)]
    together = [Note(3.0, s, 0, 1.0) for s in (1, 2, 3)]
    assert strum(Tablature(tuple(down + up + apart + together))) == [1] * 4 + [-1] * 4 + [0] * 7
    assert strum(Tablature(tuple(Note(0.0, s, 0, 1.0) for s in (1, 2, 3, 4)))) == [1] * 4


def test_a_marked_strum_is_one():
    marked = (Technique.STRUM_UP,)
    notes = tuple(Note(0.0, s, 0, 1.0, techniques=marked) for s in (1, 2))
    assert strum(Tablature(notes)) == [-1, -1]


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
def test_the_papers_rule(
    strings: tuple[int, ...], marks: tuple[str | None, ...], expected: tuple[int, ...]
):
    notes = [
        Note(0.0, string, 0, 1.0, right_finger=mark)
        for string, mark in zip(strings, marks, strict=True)
    ]
    assert by_string(Tablature(tuple(notes[::-1])))[::-1].tolist() == list(expected)
