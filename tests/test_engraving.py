import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from builders import tablatures
from roboguitarist.engraving import render, roman
from roboguitarist.fingering import UNPLAYABLE, assign
from roboguitarist.tablature import Bar, Note, Tablature, Technique, Tempo

STRING_LINE = re.compile(r"^(?:[A-G][#b]? ?) ?([|\-0-9x<>]+)$")


def string_lines(text: str) -> list[str]:
    return [match[1] for line in text.splitlines() if (match := STRING_LINE.match(line))]


def test_two_bars_and_a_chord():
    tablature = Tablature(
        (
            Note(0.0, 2, 1, 0.5),
            Note(0.5, 1, 3, 0.5),
            Note(1.0, 1, 5, 1.0),
            Note(2.0, 1, 0, 1.0),
            Note(2.0, 2, 1, 1.0),
            Note(2.0, 5, 3, 1.0),
        ),
        bars=(Bar(0.0, 9), Bar(2.0, 10)),
        tempi=(Tempo(0.0, 120.0), Tempo(1.0, 90.4)),
        title="Study",
    )
    head, system = render(assign(tablature, method="paper")).split("\n\n")
    assert head.splitlines()[:2] == [
        "Study",
        "tempo 90 to 120, tuning E A D G B E, fingering paper",
    ]
    assert system.splitlines() == [
        "   9            10",
        "     I     II      I",
        "                   a",
        "                   m",
        "     m  a  a       p",
        "E  |----3--5----|--0----|",
        "B  |-1----------|--1----|",
        "G  |------------|-------|",
        "D  |------------|-------|",
        "A  |------------|--3----|",
        "E  |------------|-------|",
        "     1  3  4       1",
        "                   3",
    ]


def test_the_difficulty_of_each_bar_is_the_sum_over_its_chords():
    notes = [Note(t, string, fret, 0.5) for t, string, fret in ((0, 1, 1), (0, 2, 5), (2.5, 1, 9))]
    fingering = assign(Tablature(tuple(notes), bars=(Bar(0.0, 9), Bar(2.0, 10))), method="search")
    low, _, high = fingering.difficulty
    last = render(fingering).split("\n\n")[-1]
    assert last == f"Difficulty of each bar: 9:{low:.1f} 10:{high:.1f}\n"


@given(tablatures(), st.integers(30, 120))
def test_the_frets_read_back(tablature: Tablature, width: int):
    bars = tuple(Bar(0.7 * k, k + 1) for k in range(1 + int(tablature.duration_s / 0.7)))
    lines = string_lines(render(assign(replace(tablature, bars=bars)), width))
    assert len(lines) % 6 == 0
    for string in range(1, 7):
        line = "".join(lines[string - 1 :: 6])
        asked = [note.fret for note in tablature.notes if note.string == string]
        assert [int(fret) for fret in re.findall(r"\d+", line)] == asked
        assert len(re.findall(r"\|+", line)) == len(bars) + 1


@given(tablatures(), st.integers(30, 120))
def test_no_line_is_too_long_and_strings_end_together(tablature: Tablature, width: int):
    text = render(assign(tablature), width)
    music = text.split("\n\nNot as asked:")[0].splitlines()
    assert max(len(line) for line in music[1:]) <= width
    lines = string_lines(text)
    for system in range(0, len(lines), 6):
        assert len({len(line) for line in lines[system : system + 6]}) == 1


@given(tablatures())
def test_the_problems_come_last(tablature: Tablature):
    fingering = assign(tablature)
    lines = render(fingering).splitlines()
    count = len(fingering.problems)
    assert count == 0 or lines[-count - 1 :] == ["Not as asked:", *fingering.problems]
    unplayable = (fingering.left == UNPLAYABLE).any()
    assert unplayable == any(re.fullmatch(r"[ \d?]*\?[ \d?]*", line) for line in lines)


def test_longer_notes_take_more_room():
    notes = [Note(onset, 1, 0, 0.1) for onset in (0.0, 0.5, 1.0, 1.5, 3.5, 3.75)]
    line = string_lines(render(assign(Tablature(tuple(notes)))))[0]
    widths = np.diff([place for place, letter in enumerate(line) if letter == "0"])
    assert widths.tolist() == [3, 3, 3, 7, 2]


def test_capo_barre_dead_notes_and_harmonics_are_shown():
    shape = zip(range(1, 7), (1, 1, 2, 3, 3, 1), strict=True)
    notes = [Note(0.0, string, fret, 1.0) for string, fret in shape]
    notes += [
        Note(1.0, 1, 0, 1.0, techniques=(Technique.DEAD,)),
        Note(2.0, 2, 12, 1.0, techniques=(Technique.HARMONIC,)),
    ]
    text = render(assign(Tablature(tuple(notes), capo=2)))
    assert "capo at fret 2" in text
    assert " C III " in text
    assert "x" in string_lines(text)[0]
    assert "<12>" in string_lines(text)[1]


def test_an_empty_piece_has_one_empty_bar():
    assert string_lines(render(assign(Tablature(())))) == ["|-|"] * 6


@pytest.mark.parametrize(
    ("number", "text"), [(1, "I"), (4, "IV"), (9, "IX"), (14, "XIV"), (20, "XX"), (24, "XXIV")]
)
def test_roman(number: int, text: str):
    assert roman(number) == text
