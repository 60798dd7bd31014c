from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import TabError
from roboguitarist.formats import unrolling
from roboguitarist.formats.unrolling import unroll
from roboguitarist.formats.written import WrittenBar, WrittenNote, WrittenPart, WrittenScore
from roboguitarist.tablature import Technique, validate


def note(bar, offset, length, pitch=None, **values):
    return WrittenNote(bar, Fraction(offset), Fraction(length), pitch, **values)


def play(bars, *notes, **part):
    written = WrittenPart("Guitar", notes, **part)
    return unroll(WrittenScore(tuple(bars), (written,)), written)


def heard(tablature):
    return [(n.onset_s, n.duration_s, tablature.pitch(n)) for n in tablature.notes]


TWO_BARS = (WrittenBar(1), WrittenBar(2))


@st.composite
def scores(draw):
    n_bars = draw(st.integers(1, 4))
    bars = [
        WrittenBar(
            k + 1,
            Fraction(draw(st.integers(1, 6))),
            tempi=tuple(
                (Fraction(0), Fraction(draw(st.integers(40, 200))))
                for _ in range(draw(st.integers(0, 1)))
            ),
            repeat_start=draw(st.booleans()),
            repeat_times=draw(st.sampled_from([0, 0, 2])),
        )
        for k in range(n_bars)
    ]
    notes = [
        note(
            draw(st.integers(0, n_bars - 1)),
            draw(st.fractions(0, 5, max_denominator=12)),
            draw(st.fractions(Fraction(1, 12), 4, max_denominator=12)),
            draw(st.integers(28, 90)),
            voice=draw(st.integers(1, 2)),
            tied=draw(st.booleans()),
        )
        for _ in range(draw(st.integers(0, 8)))
    ]
    return bars, sorted(notes, key=lambda n: n.bar)


@given(scores())
def test_whatever_is_written_becomes_a_valid_tablature(written):
    bars, notes = written
    tablature = play(bars, *notes)
    assert validate(tablature) == tablature
    assert {bar.number for bar in tablature.bars} == {bar.number for bar in bars}
    assert all(round(n.onset_s, 6) == n.onset_s for n in tablature.notes)
    missing = "left out" in " ".join(tablature.warnings)
    assert missing or bool(tablature.notes) == bool(notes)


def test_a_repeat_plays_the_same_written_bar_again():
    bars = WrittenBar(1, repeat_times=2), WrittenBar(2)
    tablature = play(bars, note(0, 1, 1, 64), note(1, 0, 4, 62))
    assert [bar.number for bar in tablature.bars] == [1, 1, 2]
    assert [(n.bar, n.beat, n.onset_s) for n in tablature.notes] == [
        (1, 2, 0.5),
        (1, 2, 2.5),
        (2, 1, 4.0),
    ]


def test_a_tie_over_the_bar_line_is_one_note():
    tablature = play(TWO_BARS, note(0, 2, 2, 60), note(1, 0, 2, 60, tied=True))
    assert heard(tablature) == [(1.0, 2.0, 60)]


def test_a_chain_of_ties_is_one_note():
    notes = [note(0, k, 1, 60, tied=k > 0) for k in range(4)]
    assert heard(play(TWO_BARS, *notes)) == [(0.0, 2.0, 60)]


def test_a_tie_keeps_the_place_of_its_first_note():
    first = note(0, 2, 2, 60, string=3, fret=5)
    tablature = play(TWO_BARS, first, note(1, 0, 2, 60, tied=True))
    assert [(n.string, n.fret) for n in tablature.notes] == [(3, 5)]


def test_a_tie_from_nowhere_is_a_note():
    assert len(play(TWO_BARS, note(0, 0, 1, 60), note(1, 0, 2, 60, tied=True)).notes) == 2


def test_a_tie_into_both_endings_holds_in_both():
    bars = (
        WrittenBar(1, repeat_start=True),
        WrittenBar(2, repeat_times=2, endings=frozenset({1})),
        WrittenBar(3, endings=frozenset({2})),
    )
    notes = note(0, 0, 4, 60), note(1, 0, 2, 60, tied=True), note(2, 0, 4, 60, tied=True)
    assert heard(play(bars, *notes)) == [(0.0, 3.0, 60), (4.0, 4.0, 60)]


def test_two_voices_on_one_pitch_are_one_note():
    long = note(0, 0, 4, 52, voice=2, left_finger=2)
    short = note(0, 0, 1, 52, voice=1, techniques=(Technique.STACCATO,))
    (only,) = play(TWO_BARS, short, long).notes
    assert (only.duration_s, only.left_finger) == (2.0, 2)
    assert only.techniques == (Technique.STACCATO,)


def test_the_same_pitch_twice_in_a_chord_takes_two_strings():
    tablature = play(TWO_BARS, note(0, 0, 1, 64), note(0, 0, 1, 64))
    assert {n.string for n in tablature.notes} == {1, 2}


def test_two_notes_on_one_string_are_moved_apart_and_said():
    tablature = play(TWO_BARS, note(0, 0, 1, string=2, fret=1), note(0, 0, 1, string=2, fret=5))
    assert sorted(tablature.pitch(n) for n in tablature.notes) == [60, 64]
    assert {n.string for n in tablature.notes} == {2, 3}
    assert tablature.warnings == ("bar 1, beat 1: two notes on string 2, one is moved",)


def test_what_cannot_be_placed_is_said_with_bar_and_beat():
    tablature = play(TWO_BARS, note(1, 1, 1, 40), note(1, 1, 1, 41))
    assert len(tablature.notes) == 1
    (warning,) = tablature.warnings
    assert warning.startswith("bar 2, beat 2: pitch 4")


def test_a_pitch_out_of_range_is_folded_and_said():
    tablature = play(TWO_BARS, note(0, 0, 1, 35), note(0, 2, 1, 90))
    assert [tablature.pitch(n) for n in tablature.notes] == [47, 78]
    assert len(tablature.warnings) == 2


def test_a_warning_of_a_repeated_bar_comes_once():
    bars = (WrittenBar(1, repeat_times=5),)
    assert len(play(bars, note(0, 0, 1, 30)).warnings) == 1


def test_warnings_are_not_endless(monkeypatch):
    monkeypatch.setattr(unrolling, "MAX_WARNINGS", 3)
    tablature = play(TWO_BARS, *(note(0, k, 1, 30) for k in range(4)))
    assert len(tablature.warnings) == 4
    assert tablature.warnings[-1] == "and 1 more of this kind"


def test_a_grace_note_before_the_first_beat_delays_the_piece():
    grace = note(0, Fraction(-1, 8), Fraction(1, 8), 62, techniques=(Technique.GRACE,))
    tablature = play(TWO_BARS, grace, note(0, 0, 1, 64), note(1, 0, 1, 60))
    assert [n.onset_s for n in tablature.notes] == [0.0, 0.0625, 2.0625]
    assert [bar.onset_s for bar in tablature.bars] == [0.0625, 2.0625]
    assert tablature.tempi[0].onset_s == 0


def test_a_grace_note_ends_what_sounds_on_its_string():
    long = note(0, 0, 4, string=1, fret=0)
    grace = note(
        0, Fraction(15, 8), Fraction(1, 8), string=1, fret=3, techniques=(Technique.GRACE,)
    )
    tablature = play(TWO_BARS, long, grace, note(0, 2, 2, string=1, fret=5))
    assert [n.duration_s for n in tablature.notes] == [0.9375, 0.0625, 1.0]


def test_capo_and_tuning_sound():
    drop_d = (64, 59, 55, 50, 45, 38)
    tablature = play(TWO_BARS, note(0, 0, 1, string=6, fret=2), tuning=drop_d, capo=3)
    assert heard(tablature) == [(0.0, 0.5, 43)]
    assert (tablature.capo, tablature.tuning) == (3, drop_d)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"string": 1, "fret": 37}, "part Guitar, bar 2, beat 3: fret 37 (0 to 24)"),
        ({"string": 1, "fret": -1}, "fret -1"),
        ({"string": 7, "fret": 1}, "string 7 (1 to 6)"),
        ({"string": 0, "fret": 1}, "string 0"),
    ],
)
def test_an_impossible_place_is_refused(bad, message):
    with pytest.raises(TabError) as caught:
        play(TWO_BARS, note(1, 2, 1, 64, **bad))
    assert message in str(caught.value)


def test_absurd_lengths_are_refused(monkeypatch):
    with pytest.raises(TabError, match="four hours"):
        play([replace(TWO_BARS[0], length=Fraction(30_000)), TWO_BARS[1]], note(0, 0, 1, 60))
    monkeypatch.setattr(unrolling, "MAX_PLAYED_NOTES", 3)
    with pytest.raises(TabError, match="more than 3 notes"):
        play([WrittenBar(1, repeat_times=4)], note(0, 0, 1, 60))
