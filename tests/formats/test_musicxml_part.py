from fractions import Fraction
from xml.etree.ElementTree import fromstring

import pytest
from musicxml_texts import attributes, ending, measures, note, repeat

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_part import GRACE_LENGTH, PartReader
from roboguitarist.tablature import Technique

CHORD = "<chord/>"


def read(*bodies):
    reader = PartReader()
    for measure in fromstring(f"<part>{measures(*bodies)}</part>"):
        reader.read(measure)
    return reader


def times(*bodies):
    return [(n.bar, float(n.offset), float(n.length), n.pitch) for n in read(*bodies).notes]


def test_notes_follow_each_other_and_rests_take_time():
    assert times(note("C4") + note() + note("D4", 2), note("E4")) == [
        (0, 0, 1, 60),
        (0, 2, 2, 62),
        (1, 0, 1, 64),
    ]


def test_a_chord_starts_together():
    body = note("C4") + note("E4", inside=CHORD) + note("G4", inside=CHORD) + note("C5")
    assert times(body) == [(0, 0, 1, 60), (0, 0, 1, 64), (0, 0, 1, 67), (0, 1, 1, 72)]


def test_backup_and_forward_move_without_sound():
    body = (
        note("C5", 4)
        + "<backup><duration>4</duration></backup><forward><duration>1</duration></forward>"
        + note("C3", 3, "<voice>2</voice>")
    )
    assert times(body) == [(0, 0, 4, 72), (0, 1, 3, 48)]
    assert [n.voice for n in read(body).notes] == [1, 2]


def test_a_backup_stops_at_the_bar_line():
    assert times(note("C4") + "<backup><duration>9</duration></backup>" + note("D4"))[1][1] == 0


def test_divisions_change_and_may_be_missing():
    change = attributes("<divisions>6</divisions>")
    assert times(note("C4") + change + note("D4", 2) + note("E4", 2) + note("F4", 2)) == [
        (0, 0, 1, 60),
        (0, 1, pytest.approx(1 / 3), 62),
        (0, pytest.approx(4 / 3), pytest.approx(1 / 3), 64),
        (0, pytest.approx(5 / 3), pytest.approx(1 / 3), 65),
    ]


def test_triplets_fill_their_bar_exactly():
    reader = read(attributes("<divisions>3</divisions>") + note("C4") * 12)
    assert reader.bars[0].held == 4
    assert reader.notes[-1].offset == Fraction(11, 3)


def test_grace_notes_come_just_before_their_beat():
    grace = "<note><grace/><pitch><step>{}</step><octave>4</octave></pitch></note>"
    reader = read(note("C4") + grace.format("D") + grace.format("E") + note("F4"))
    starts = [note.offset for note in reader.notes]
    assert starts == [0, 1 - 2 * GRACE_LENGTH, 1 - GRACE_LENGTH, 1]
    assert [note.pitch for note in reader.notes] == [60, 62, 64, 65]
    assert reader.notes[1].techniques == (Technique.GRACE,)


def test_a_grace_chord_takes_one_place_and_may_stand_before_the_bar():
    grace = "<note><grace/>{}<pitch><step>{}</step><octave>4</octave></pitch></note>"
    body = grace.format("", "D") + grace.format("<chord/>", "F") + note("G4")
    assert [note.offset for note in read(body).notes] == [-GRACE_LENGTH, -GRACE_LENGTH, 0]


def test_cue_notes_are_silent():
    assert times(note("C4", inside="<cue/>") + note("D4")) == [(0, 1, 1, 62)]


def test_what_is_left_out_is_said():
    body = (
        "<note><unpitched/><duration>1</duration></note>" * 2
        + note("C4", 0)
        + "<note><duration>1</duration></note>"
    )
    reader = read(body)
    assert reader.notes == []
    assert reader.n_unpitched == 2
    assert len(reader.warnings()) == 3
    assert "(2 times)" in reader.warnings()[0]


def test_string_and_fret():
    (placed,) = read(note("C4", place="2/1")).notes
    assert (placed.string, placed.fret, placed.pitch) == (2, 1, 60)
    technical = "<notations><technical><string>1</string><open-string/></technical></notations>"
    (opened,) = read(note("E4", inside=technical)).notes
    assert (opened.string, opened.fret) == (1, 0)
    (bare,) = read(f"<note><duration>1</duration>{technical}</note>").notes
    assert bare.pitch is None


def test_ties():
    tied = [
        n.tied
        for n in read(
            note("C4", inside='<tie type="start"/>')
            + note("C4", inside='<tie type="stop"/><tie type="start"/>')
            + note("C4", inside='<notations><tied type="stop"/></notations>')
            + note("C4", inside='<notations><tied type="let-ring"/></notations>')
        ).notes
    ]
    assert tied == [False, True, True, False]


def test_endings_reach_from_start_to_stop():
    reader = read(
        note("C4"),
        ending("1") + note("C4"),
        note("C4") + ending("1", "stop") + repeat("backward"),
        ending("2") + note("C4") + ending("2", "discontinue"),
        note("C4"),
    )
    assert [set(bar.endings) for bar in reader.bars] == [set(), {1}, {1}, {2}, set()]


def test_an_ending_that_is_not_stopped_ends_with_its_repeat():
    reader = read(ending("1") + note("C4"), note("C4") + repeat("backward"), note("C4"))
    assert [set(bar.endings) for bar in reader.bars] == [{1}, {1}, set()]


def test_the_time_signature_lasts():
    time = "<time><beats>3</beats><beat-type>8</beat-type></time>"
    reader = read(note("C4"), attributes(time) + note("C4"), note("C4"))
    assert [bar.signature for bar in reader.bars] == [(4, 4), (3, 8), (3, 8)]


def test_a_tempo_mark_stands_where_it_is_written():
    later = '<direction><offset>1</offset><sound tempo="60"/></direction>'
    reader = read(note("C4") + '<sound tempo="90"/>' + later)
    assert reader.bars[0].tempi == {1: 90, 2: 60}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (note("C4") + note("C4", -1), "bar 2, beat 2: duration of -1"),
        (note("C4", "x"), "bar 2, beat 1: duration 'x' is not a number"),
        (note("C4") + note("C9") + note("Cb4", 1).replace(">4<", ">-9<"), "bar 2, beat 3: pitch"),
        (attributes("<divisions>0</divisions>"), "bar 2, beat 1: divisions of 0"),
        (attributes("<divisions>-1</divisions>"), "bar 2, beat 1: divisions of -1"),
        (note("C4", 2) + '<sound tempo="0"/>', "bar 2, beat 3: tempo 0"),
        (note("C4", place="1/x"), "bar 2, beat 1: fret 'x' is not a number"),
    ],
)
def test_nonsense_is_refused_with_its_place(body, message):
    with pytest.raises(TabError) as caught:
        read(note("C4", 4), body)
    assert str(caught.value).startswith(message)
