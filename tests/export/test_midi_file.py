from dataclasses import replace
from io import BytesIO

import mido
import numpy as np
import pytest
from hypothesis import given, settings

from builders import perfect, tablatures, with_pluck, without_plucks
from roboguitarist import export
from roboguitarist.export.midi_file import midi
from roboguitarist.performance import DEAD
from roboguitarist.tablature import Note, Tablature, Tempo

SHORT = Tablature((Note(0.0, 2, 1, 0.5), Note(0.5, 2, 3, 0.5), Note(0.75, 6, 0, 0.5)), capo=2)


def heard(file):
    """(start, end, channel, pitch, velocity) of every note, in seconds, as a player reads it."""
    now, sounding, found = 0.0, {}, []
    for message in file:
        now += message.time
        if message.type == "note_on" and message.velocity:
            sounding[message.channel, message.note] = (now, message.velocity)
        elif message.type in ("note_on", "note_off"):
            start, velocity = sounding.pop((message.channel, message.note))
            found.append((start, now, message.channel, message.note, velocity))
    assert not sounding
    return sorted(found)


def test_pitches_strings_and_times_are_those_that_sounded():
    notes = heard(midi(perfect(SHORT)))
    assert [(channel, pitch) for _, _, channel, pitch, _ in notes] == [(1, 62), (1, 64), (5, 42)]
    assert [start for start, *_ in notes] == pytest.approx([0.0, 0.5, 0.75], abs=1e-3)
    assert notes[0][1] == pytest.approx(0.5, abs=1e-3)
    assert notes[2][1] > 2


def test_times_hold_when_the_tempo_changes():
    tempi = (Tempo(0.0, 120.0), Tempo(0.4, 60.0), Tempo(0.7, 200.0))
    file = midi(perfect(replace(SHORT, tempi=tempi)))
    assert [start for start, *_ in heard(file)] == pytest.approx([0.0, 0.5, 0.75], abs=1e-3)
    marks = [message.tempo for message in file.tracks[0] if message.type == "set_tempo"]
    assert marks == [500000, 1000000, 300000]


def test_what_was_missed_or_dead_or_wrong_is_heard_so():
    played = perfect(SHORT)
    assert len(heard(midi(without_plucks(played, np.array([True, False, False]))))) == 2
    dead = replace(played, pluck_fret=np.array([DEAD, 5, 2], np.int8))
    assert [pitch for *_, pitch, _ in heard(midi(dead))] == [64, 42]
    assert len(heard(midi(with_pluck(played, 0.25, 5, 2)))) == 4


def test_faster_plucks_are_louder():
    played = perfect(SHORT)
    faster = replace(played, pluck_speed_m_s=np.array([0.1, 0.5, 9.0], np.float32))
    velocities = [velocity for *_, velocity in heard(midi(faster))]
    assert 1 <= velocities[0] < velocities[1] < velocities[2] == 127


@given(tablatures())
@settings(deadline=None)
def test_a_perfect_performance_gives_the_tablature_back(tablature):
    buffer = BytesIO()
    midi(perfect(tablature)).save(file=buffer)
    buffer.seek(0)
    notes = heard(mido.MidiFile(file=buffer))
    wanted = sorted((n.onset_s, n.string - 1, tablature.pitch(n)) for n in tablature.notes)
    assert [(c, p) for _, _, c, p, _ in sorted(notes, key=lambda n: (round(n[0], 2), n[2]))] == [
        (c, p) for _, c, p in wanted
    ]
    assert sorted(s for s, *_ in notes) == pytest.approx([s for s, _, _ in wanted], abs=2e-3)


def test_a_title_with_any_letters_is_written(tmp_path):
    export.write_midi(perfect(replace(SHORT, title="Für 猫")), tmp_path / "a.mid")
    assert mido.MidiFile(tmp_path / "a.mid").tracks[0][0].name == "Für ?"
