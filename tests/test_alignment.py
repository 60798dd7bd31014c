from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from builders import idle, perfect, tablatures, with_pluck, without_plucks
from roboguitarist.alignment import Cause, match, misses
from roboguitarist.performance import DEAD
from roboguitarist.tablature import Note, Tablature

ONE = Tablature((Note(1.0, 3, 2, 1.0, bar=2, beat=1.5),), capo=1)


@given(tablatures())
def test_a_perfect_performance_matches_note_for_note(tablature: Tablature):
    pluck = match(perfect(tablature), tablature)
    assert pluck.tolist() == list(range(len(tablature.notes)))
    assert misses(perfect(tablature)) == ()


@given(tablatures())
def test_an_idle_performance_misses_every_note(tablature: Tablature):
    missed = misses(idle(tablature))
    assert [miss.note for miss in missed] == list(tablature.notes)
    assert {miss.cause for miss in missed} <= {Cause.NOT_PLUCKED}


@given(tablatures(min_notes=1), st.data())
def test_exactly_the_notes_left_out_are_missed(tablature: Tablature, data: st.DataObject):
    count = len(tablature.notes)
    drop = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    missed = misses(without_plucks(perfect(tablature), drop))
    # A finger that would have lifted is never asked to hold on, so the others stay right.
    assert [miss.index for miss in missed] == np.flatnonzero(drop).tolist()


@given(
    st.lists(st.integers(0, 30), min_size=1, max_size=4, unique=True),
    st.lists(st.integers(0, 30), min_size=1, max_size=4, unique=True),
)
def test_the_matching_is_the_best_of_all(onsets: list[int], plucks: list[int]):
    """Crowded repeats of one open string, against trying every assignment."""
    notes = tuple(Note(tick / 100, 1, 0, 0.01) for tick in sorted(onsets))
    tablature = Tablature(notes)
    played = idle(tablature)
    for tick in plucks:
        played = with_pluck(played, tick / 100, 1, 0)
    matched = match(played, tablature)
    error = np.abs(np.array(sorted(onsets))[:, None] - np.array(sorted(plucks)))
    size = max(error.shape)
    padded = np.full((size, size), 1000)
    padded[: error.shape[0], : error.shape[1]] = np.where(error <= 5, error, 1000)
    best = min(sum(padded[range(size), order]) for order in map(list, permutations(range(size))))
    rows = np.flatnonzero(matched >= 0)
    assert len(set(matched[rows])) == rows.size
    assert error[rows, matched[rows]].sum() + 1000 * (size - rows.size) == best


def test_one_pluck_does_not_serve_two_notes():
    tablature = Tablature((Note(0.0, 1, 0, 0.04), Note(0.04, 1, 0, 0.5)))
    played = with_pluck(idle(tablature), 0.02, 1, 0)
    assert sorted(match(played, tablature)) == [-1, 0]


@pytest.mark.parametrize(
    ("time_s", "fret", "cause", "text"),
    [
        (1.08, 3, Cause.LATE, "bar 2, beat 1.5: string 3 fret 2: plucked 80 ms too late"),
        (0.9, 3, Cause.EARLY, "bar 2, beat 1.5: string 3 fret 2: plucked 100 ms too early"),
        (1.0, 2, Cause.WRONG_FRET, "bar 2, beat 1.5: string 3 fret 2: sounded fret 1"),
        (1.0, DEAD, Cause.DEAD, "bar 2, beat 1.5: string 3 fret 2: touched but not pressed, so"),
        (1.5, 3, Cause.NOT_PLUCKED, "bar 2, beat 1.5: string 3 fret 2: not plucked"),
    ],
)
def test_a_miss_says_why(time_s: float, fret: int, cause: Cause, text: str):
    silent = without_plucks(perfect(ONE), np.array([True]))
    (miss,) = misses(with_pluck(silent, time_s, 3, fret))
    assert miss.cause == cause
    assert str(miss).startswith(text)
    assert (miss.pluck is None) == (cause == Cause.NOT_PLUCKED)


def test_a_note_let_go_too_soon_says_how_soon():
    played = perfect(ONE, control_hz=100)
    force_n = played.press_force_n.copy()
    force_n[played.time_s >= 1.3 - 1e-6] = 0
    (miss,) = misses(replace(played, press_force_n=force_n))
    assert miss.cause == Cause.NOT_HELD
    assert miss.detail == "held for 30% of its length"


def test_no_pluck_is_blamed_twice():
    tablature = Tablature((Note(0.0, 3, 0, 0.2), Note(0.2, 3, 0, 0.2)))
    played = with_pluck(idle(tablature), 0.2, 3, 5)
    assert [miss.cause for miss in misses(played)] == [Cause.NOT_PLUCKED, Cause.WRONG_FRET]
