"""The repertoire: what every piece keeps to, and how each tune begins."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import groupby, pairwise
from xml.etree.ElementTree import Element

import pytest
from defusedxml.ElementTree import parse
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist import formats, pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.pieces import Piece
from roboguitarist.tablature import STANDARD_TUNING, Note, Tablature

PAPER_NAMES = (
    "twinkle",
    "scales-practice",
    "long-long-ago",
    "fur-elise",
    "happy-birthday",
    "farewell",
    "red-river-valley",
    "chord-transition",
)
NOTES_PER_SECOND = dict(zip(PAPER_NAMES, (0.9, 1.0, 2.7, 3.5, 1.7, 2.5, 2.6, 1.4), strict=True))
STEPS = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")
OPENINGS = {
    "twinkle": "C4 C4 G4 G4 A4 A4 G4 F4 F4 E4 E4 D4 D4 C4",
    "scales-practice": "C3 D3 E3 F3 G3 A3 B3 C4 B3 A3 G3 F3 E3 D3 C3 G2 A2 B2 C3 D3 E3 F#3 G3",
    "long-long-ago": "A3 A3 B3 C#4 C#4 D4 E4 F#4 E4 C#4 E4 D4 C#4 B3 D4 C#4 B3 A3",
    "fur-elise": "E4 D#4 E4 D#4 E4 B3 D4 C4 A3 C3 E3 A3 B3 E3 G#3 B3 C4 E3 E4 D#4",
    "happy-birthday": "G3 G3 A3 G3 C4 B3 G3 G3 A3 G3 D4 C4 G3 G3 G4 E4 C4 B3 A3 F4 F4 E4 C4 D4 C4",
    "farewell": "D3 G3 G3 G3 B3 A3 G3 A3 B3 G3 G3 B3 D4 E4 E4 D4 B3 B3 G3 A3 G3 A3 B3 G3 E3",
    "red-river-valley": "G3 C4 E4 E4 E4 E4 D4 E4 D4 C4 G3 C4 E4 C4 E4 G4 F4 E4 D4",
    "chord-transition": "E4 E4 F4 F4 E4 E4 E4 F4",
}
"""Highest notes of the first voice, in scientific pitch."""
RHYTHMS = {
    "twinkle": "1 1 1 1 1 1 2",
    "scales-practice": "1 1 1 1 1 1 1 1",
    "long-long-ago": "1 1/2 1/2 1 1/2 1/2 1 1/2 1/2 2",
    "fur-elise": "1/4 1/4 1/4 1/4 1/4 1/4 1/4 1/4 1/2 1/4 1/4 1/4 1/2",
    "happy-birthday": "1/2 1/2 1 1 1 2 1/2 1/2",
    "farewell": "1 3/2 1/2 1 1 3/2 1/2 1 1 3/2 1/2 1 1 3",
    "red-river-valley": "1/2 1/2 1 1/2 1/2 1 1/2 1/2 1 2 1/2 1/2",
    "chord-transition": "2 2 2 2",
}
"""Lengths of the same notes in quarter notes."""


@pytest.fixture(params=pieces.PIECES, ids=pieces.names())
def piece(request: pytest.FixtureRequest) -> Piece:
    return request.param


@pytest.fixture
def tablature(piece: Piece) -> Tablature:
    return formats.load(pieces.path(piece.name))


def _chords(tablature: Tablature) -> list[list[Note]]:
    return [list(group) for _, group in groupby(tablature.notes, key=lambda note: note.onset_s)]


def _melody(tablature: Tablature) -> list[Note]:
    first = [[note for note in chord if note.voice == 1] for chord in _chords(tablature)]
    return [max(chord, key=tablature.pitch) for chord in first if chord]


def test_the_papers_eight_come_first():
    assert pieces.names()[:8] == PAPER_NAMES
    assert len(set(pieces.names())) == len(pieces.PIECES)


def test_the_table_says_what_the_file_says(piece: Piece, tablature: Tablature):
    described = (piece.title, piece.composer, piece.source, piece.grade)
    assert all(described)
    assert described == (tablature.title, tablature.composer, tablature.source, tablature.grade)
    assert not tablature.warnings


def test_is_for_a_beginner(tablature: Tablature):
    assert 20 <= len(tablature.notes) <= 300
    assert 14 <= tablature.duration_s <= 90
    assert {note.fret for note in tablature.notes} <= set(range(6))
    assert (tablature.tuning, tablature.capo) == (STANDARD_TUNING, 0)


@pytest.mark.parametrize(("name", "density"), NOTES_PER_SECOND.items(), ids=PAPER_NAMES)
def test_is_about_as_fast_as_the_papers(name: str, density: float):
    tablature = formats.load(pieces.path(name))
    assert len(tablature.notes) / tablature.duration_s == pytest.approx(density, rel=0.1)


def test_a_string_ends_before_it_sounds_again(tablature: Tablature):
    for string in range(1, 7):
        notes = [note for note in tablature.notes if note.string == string]
        assert all(a.end_s <= b.onset_s + 2e-6 for a, b in pairwise(notes))


def test_four_fingers_reach_every_moment_without_barre(tablature: Tablature):
    for chord in _chords(tablature):
        now = chord[0].onset_s + 1e-5
        held = [n.fret for n in tablature.notes if n.fret and n.onset_s <= now < n.end_s]
        assert len(held) <= 4
        assert max(held, default=0) - min(held, default=0) <= 3


def test_each_plucking_finger_has_one_note(tablature: Tablature):
    for chord in _chords(tablature):
        strings = [note.string for note in chord]
        assert len(set(strings)) == len(strings) <= 4
        assert sum(string >= 4 for string in strings) <= 1


def test_every_bar_of_every_voice_is_full(piece: Piece):
    bars = _xml(piece).findall("part/measure")
    attributes = bars[0].find("attributes")
    quarters = Fraction(
        4 * _number(attributes, "time/beats"), _number(attributes, "time/beat-type")
    )
    full = quarters * _number(attributes, "divisions")
    pickup = bars[0].get("implicit") == "yes"
    assert [bar.get("number") for bar in bars] == [str(i + (not pickup)) for i in range(len(bars))]
    for bar in bars[pickup:]:
        assert set(_voice_lengths(bar).values()) == {full}
    if pickup:
        assert 0 < max(_voice_lengths(bars[0]).values()) < full


def _voice_lengths(bar: Element) -> Counter[str]:
    lengths: Counter[str] = Counter()
    for note in bar.findall("note"):
        if note.find("chord") is None:
            lengths[note.findtext("voice", "")] += _number(note, "duration")
    return lengths


def test_pitches_agree_with_strings_and_frets(piece: Piece):
    for note in _xml(piece).iter("note"):
        if note.find("rest") is None:
            pitch = 12 * _number(note, "pitch/octave") + 12
            pitch += STEPS.index(note.findtext("pitch/step", ""))
            pitch += int(note.findtext("pitch/alter", "0"))
            technical = note.find("notations/technical")
            string, fret = _number(technical, "string"), _number(technical, "fret")
            assert pitch == STANDARD_TUNING[string - 1] + fret


def _xml(piece: Piece) -> Element:
    root = parse(pieces.path(piece.name)).getroot()
    assert root is not None
    return root


def _number(element: Element | None, path: str) -> int:
    assert element is not None
    return int(element.findtext(path, ""))


@pytest.mark.parametrize("name", PAPER_NAMES)
def test_the_tune_begins_as_everyone_knows_it(name: str):
    tablature = formats.load(pieces.path(name))
    pitches = [tablature.pitch(note) for note in _melody(tablature)]
    names = [f"{STEPS[pitch % 12]}{pitch // 12 - 1}" for pitch in pitches]
    opening = OPENINGS[name].split()
    assert names[: len(opening)] == opening


@pytest.mark.parametrize("name", PAPER_NAMES)
def test_the_tune_has_its_rhythm(name: str):
    tablature = formats.load(pieces.path(name))
    quarter_s = 60 / tablature.tempi[0].quarters_per_minute
    rhythm = [float(Fraction(length)) for length in RHYTHMS[name].split()]
    melody = _melody(tablature)[: len(rhythm)]
    lengths = [note.duration_s / quarter_s for note in melody]
    assert lengths == pytest.approx(rhythm, abs=1e-4)


def test_twinkle_has_its_six_phrases():
    tablature = formats.load(pieces.path("twinkle"))
    pitches = [tablature.pitch(note) for note in tablature.notes]
    phrases = [pitches[i : i + 7] for i in range(0, len(pitches), 7)]
    assert [phrases.index(phrase) for phrase in phrases] == [0, 1, 2, 2, 0, 1]


def test_a_piece_is_found_by_its_name(piece: Piece):
    assert pieces.find(piece.name) is piece
    assert pieces.path(piece.name).name == piece.file == f"{piece.name}.musicxml"


@given(st.text())
def test_an_unknown_name_lists_the_known_ones(name: str):
    if name not in pieces.names():
        with pytest.raises(RoboGuitaristError, match=", ".join(pieces.names())):
            pieces.find(name)


def test_a_misspelt_name_brings_a_guess():
    with pytest.raises(RoboGuitaristError, match="did you mean fur-elise"):
        pieces.find("Fuer-Elise")
