from dataclasses import replace
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from written_scores import scores

from roboguitarist import formats, pieces
from roboguitarist.formats import musicxml, musicxml_writer
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Bar, Note, Tablature, Technique, Tempo
from strategies import tablatures


def reread(tablature):
    score = musicxml.read(musicxml_writer.write(tablature))
    part, warnings = choose(score, None)
    assert warnings == ()
    return unroll(score, part)


@settings(deadline=None, max_examples=50)
@given(scores())
def test_what_was_written_reads_the_same(score):
    if any(note.string for note in score.parts[0].notes):
        tablature = unroll(score, score.parts[0])
        again = reread(tablature)
        assert again == tablature
        assert again.warnings == ()
        assert musicxml_writer.write(again) == musicxml_writer.write(tablature)


@settings(deadline=None, max_examples=50)
@given(tablatures(min_notes=1))
def test_no_note_is_lost_however_its_times_fall(tablature):
    # A grace note ends the one that it interrupts.
    tablature = replace(tablature, notes=tuple(map(plain, tablature.notes)))
    again = reread(tablature)
    assert len(again.notes) == len(tablature.notes)
    for before, after in zip(tablature.notes, again.notes, strict=True):
        assert after.onset_s == pytest.approx(before.onset_s, abs=3e-6)
        assert after.duration_s == pytest.approx(before.duration_s, abs=5e-6)
        time = {"onset_s": before.onset_s, "duration_s": before.duration_s}
        place = {"bar": before.bar, "beat": before.beat}
        bend = {"bend": before.bend if Technique.BEND in before.techniques else ()}
        assert replace(after, **time, **place) == replace(before, **bend)


@pytest.mark.parametrize("name", pieces.names())
def test_the_repertoire_survives(tmp_path, name):
    tablature = formats.load(pieces.path(name))
    formats.save(tmp_path / "a.musicxml", tablature)
    assert formats.load(tmp_path / "a.musicxml") == tablature


def plain(note):
    kinds = tuple(kind for kind in note.techniques if kind != Technique.GRACE)
    return replace(note, techniques=kinds)


def elements(tablature, path):
    return ElementTree.fromstring(musicxml_writer.write(tablature)).findall(path)


def test_fingers_strings_and_frets_stand_where_programs_look_for_them():
    note = Note(0.0, 2, 3, 0.5, left_finger=4, right_finger="m")
    (technical,) = elements(Tablature((note,)), ".//note/notations/technical")
    found = {child.tag: child.text for child in technical}
    assert found == {"fingering": "4", "pluck": "m", "string": "2", "fret": "3"}


def test_a_note_over_the_bar_line_is_tied():
    tablature = Tablature((Note(1.5, 1, 0, 1.0),), bars=(Bar(0.0, 1), Bar(2.0, 2)))
    ties = [tie.get("type") for tie in elements(tablature, ".//note/tie")]
    durations = [note.text for note in elements(tablature, ".//note[pitch]/duration")]
    assert (ties, durations) == (["start", "stop"], ["8", "8"])


def test_a_length_that_has_no_name_is_tied_from_some_that_have():
    # Two and a half quarters: a half and a tied eighth.
    tablature = Tablature((Note(0.0, 1, 0, 1.25),), tempi=(Tempo(0.0, 120.0),))
    types = [kind.text for kind in elements(tablature, ".//note[pitch]/type")]
    assert types == ["half", "eighth"]
    assert reread(tablature).notes == tablature.notes


def test_every_bar_is_filled():
    for measure in elements(formats.load(pieces.path("fur-elise")), "part/measure"):
        if measure.get("implicit") != "yes":
            now = most = 0
            for element in measure:
                ticks = int(element.findtext("duration") or 0)
                chord = element.find("chord") is not None
                now += {"note": 0 if chord else ticks, "backup": -ticks}.get(element.tag, 0)
                most = max(most, now)
            assert now == most == 3 * int(8 / 2)


def test_a_hammer_on_joins_two_notes():
    notes = (Note(0.0, 1, 0, 0.5), Note(0.5, 1, 2, 0.5, techniques=(Technique.HAMMER_ON,)))
    marks = elements(Tablature(notes), ".//hammer-on")
    assert [mark.get("type") for mark in marks] == ["start", "stop"]


def test_characters_that_xml_has_not_are_left_out():
    tablature = Tablature((Note(0.0, 1, 0, 0.5),), title="a\0b\x08c")
    assert reread(tablature).title == "abc"
