from dataclasses import replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from builders import tablatures
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import HANDS, METHODS, OBJECTIVES, UNPLAYABLE, Fingering
from roboguitarist.fingering import assign as assign_by
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature

steady = settings(deadline=None)
assign = partial(assign_by, method="search")

TICK_S = 1e-5


def chord(frets: str, onset_s: float = 0.0, duration_s: float = 1.0) -> tuple[Note, ...]:
    """Notes of a chord diagram such as x32010, from string 6 to string 1."""
    pairs = [(6 - place, fret) for place, fret in enumerate(frets) if fret != "x"]
    return tuple(Note(onset_s, string, int(fret), duration_s) for string, fret in pairs[::-1])


def line(*places: tuple[int, int], step_s: float = 0.25) -> Tablature:
    notes = (Note(k * step_s, s, fret, step_s) for k, (s, fret) in enumerate(places))
    return Tablature(tuple(notes))


def fingers(frets: str) -> str:
    """Left fingers of a chord diagram, in the same order."""
    left = iter(assign(Tablature(chord(frets))).left[::-1])
    return "".join("x" if fret == "x" else str(next(left)) for fret in frets)


@pytest.mark.parametrize(
    ("frets", "expected"),
    [
        ("x32010", "x32010"),
        ("xx0232", "xx0132"),
        ("022100", "023100"),
        ("x02220", "x01230"),
        ("x02210", "x02310"),
        ("xx0231", "xx0231"),
        ("133211", "134211"),
        ("x24432", "x13421"),
    ],
)
def test_common_chords_have_their_usual_fingers(frets: str, expected: str):
    assert fingers(frets) == expected


@steady
@given(tablatures())
def test_every_note_has_a_finger_or_a_reason(tablature: Tablature):
    fingering = assign(tablature)
    text = "\n".join(fingering.problems)
    for note, left in zip(tablature.notes, fingering.left, strict=True):
        assert (left == 0) == (note.fret == 0)
        if left == UNPLAYABLE:
            assert f"string {note.string} fret {note.fret}" in text


@steady
@given(tablatures())
def test_no_finger_is_in_two_places_before_it_is_released(tablature: Tablature):
    fingering = assign(tablature)
    stopped = [
        (note, left, barre, release_s)
        for note, left, barre, release_s in zip(
            tablature.notes, fingering.left, fingering.barre, fingering.release_s, strict=True
        )
        if left > 0
    ]
    for (a, left_a, barre_a, until_a), (b, left_b, barre_b, until_b) in combinations(stopped, 2):
        if left_a == left_b and a.onset_s < until_b - TICK_S and b.onset_s < until_a - TICK_S:
            assert barre_a
            assert barre_b
            assert a.fret == b.fret


@steady
@given(tablatures())
def test_fingers_that_are_down_do_not_cross_frets(tablature: Tablature):
    fingering = assign(tablature)
    for i, a in enumerate(tablature.notes):
        for j, b in enumerate(tablature.notes):
            together = a.onset_s <= b.onset_s < fingering.release_s[i] - TICK_S
            if together and 0 < fingering.left[i] < fingering.left[j]:
                assert a.fret <= b.fret


@steady
@given(tablatures())
def test_release_and_position_and_difficulty_make_sense(tablature: Tablature):
    fingering = assign(tablature)
    for k, note in enumerate(tablature.notes):
        assert note.onset_s < fingering.release_s[k] <= note.end_s + TICK_S
        assert tablature.capo < fingering.hold_position[k] <= Guitar().n_frets
        assert fingering.difficulty[k] >= 0
        if fingering.barre[k]:
            assert fingering.left[k] > 0


@steady
@given(tablatures(), st.sampled_from(sorted(HANDS)), st.sampled_from(OBJECTIVES))
def test_a_capo_moves_with_the_nut(tablature: Tablature, hand: str, objective: str):
    low = assign(tablature, Guitar(n_frets=24), hand=hand, objective=objective)
    capo = replace(tablature, capo=tablature.capo + 1)
    high = assign(capo, Guitar(n_frets=25), hand=hand, objective=objective)
    assert low.left.tolist() == high.left.tolist()
    assert (low.hold_position + 1).tolist() == high.hold_position.tolist()


@steady
@given(tablatures())
def test_its_own_marks_lead_to_the_same_fingers(tablature: Tablature):
    first = assign(tablature)
    again = assign(first.marked())
    assert again.left.tolist() == first.left.tolist()
    assert again.right.tolist() == first.right.tolist()


@steady
@given(tablatures())
def test_twice_the_same(tablature: Tablature):
    first, second = assign(tablature), assign(tablature)
    assert first.left.tobytes() == second.left.tobytes()
    assert first.problems == second.problems


def test_marks_are_kept():
    tablature = line((1, 5), (1, 7), (2, 5))
    for finger in (1, 2, 3, 4):
        marked = [replace(tablature.notes[0], left_finger=finger), *tablature.notes[1:]]
        fingering = assign(replace(tablature, notes=tuple(marked)))
        assert fingering.left[0] == finger
        assert not fingering.problems


def test_a_mark_that_no_hand_can_keep_is_reported():
    notes = (
        Note(0.0, 1, 5, 1.0, left_finger=1),
        Note(0.0, 2, 8, 1.0, left_finger=1),
    )
    fingering = assign(Tablature(notes))
    assert len(set(fingering.left.tolist())) == 2
    assert len(fingering.problems) == 1
    assert "marked for finger 1" in fingering.problems[0]


def test_a_finger_marked_on_two_strings_of_a_fret_is_a_barre():
    notes = tuple(replace(note, left_finger=3) for note in chord("xx55xx"))
    fingering = assign(Tablature(notes))
    assert fingering.left.tolist() == [3, 3]
    assert fingering.barre.all()


def test_the_least_loss_is_proposed():
    fingering = assign(Tablature(chord("x12345")))
    assert (fingering.left == UNPLAYABLE).sum() == 1
    (problem,) = fingering.problems
    assert "all four fingers are in use, leave this note out" in problem
    wide = assign(Tablature((Note(0.0, 1, 1, 1.0), Note(0.0, 2, 12, 1.0))))
    assert "out of reach" in wide.problems[0]


def test_a_held_note_is_let_go_for_one_out_of_reach():
    notes = (Note(0.0, 6, 1, 4.0), Note(1.0, 1, 9, 1.0))
    fingering = assign(Tablature(notes))
    assert fingering.release_s.tolist() == [1.0, 2.0]
    assert fingering.problems == (
        "bar 1, beat 1: string 6 fret 1: let go after 25% of its length"
        " for bar 1, beat 1: string 1 fret 9",
    )


def test_an_index_finger_that_holds_can_be_laid_flat():
    notes = (Note(0.0, 5, 3, 2.0, left_finger=1), Note(0.5, 1, 3, 0.5, left_finger=1))
    fingering = assign(Tablature(notes))
    assert fingering.barre.all()
    assert fingering.release_s.tolist() == [2.0, 1.0]
    between = Note(0.25, 3, 0, 1.0)
    muted = assign(Tablature((notes[0], between, notes[1])))
    assert not muted.barre.any()
    assert muted.release_s[0] == 0.5


def test_the_hand_stays_for_a_scale_in_one_position():
    fingering = assign(line((2, 5), (2, 6), (2, 8), (1, 5), (1, 7), (1, 8)))
    assert fingering.left.tolist() == [1, 2, 4, 1, 3, 4]
    assert set(fingering.hold_position) == {5}


def test_frets_that_are_not_there_and_strings_asked_twice_are_reported():
    notes = (Note(0.0, 1, 3, 1.0), Note(0.0, 1, 5, 1.0), Note(0.0, 2, 21, 1.0))
    fingering = assign(Tablature(notes))
    assert (fingering.left[[0, 2]] == UNPLAYABLE).all()
    assert "another note" in fingering.problems[0]
    assert "the guitar has 20 frets" in fingering.problems[1]


def test_an_unknown_name_lists_the_known():
    for name, known in (("method", METHODS), ("hand", HANDS), ("objective", OBJECTIVES)):
        wrong: dict[str, Any] = {name: "viterbi"}
        with pytest.raises(RoboGuitaristError, match=rf"no .*{name} 'viterbi'") as caught:
            assign_by(Tablature(()), **wrong)
        assert all(word in str(caught.value) for word in known)


@pytest.mark.parametrize("method", METHODS)
def test_save_and_load(tmp_path: Path, method: str):
    fingering = assign_by(Tablature(chord("222022")), method=method)
    fingering.save(tmp_path / "f.npz")
    loaded = Fingering.load(tmp_path / "f.npz")
    assert loaded.tablature == fingering.tablature
    assert loaded.problems == fingering.problems
    assert loaded.method == method
    for name in ("left", "right", "barre", "hold_position", "release_s", "strum", "difficulty"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(fingering, name))
        assert getattr(loaded, name).dtype == getattr(fingering, name).dtype


def test_an_empty_piece_has_no_fingers():
    fingering = assign(Tablature(()))
    assert fingering.left.shape == fingering.right.shape == (0,)
