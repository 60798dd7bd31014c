import io

import mido
from hypothesis import given, settings
from written_scores import scores

from roboguitarist.formats import midi, midi_writer
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Note, Tablature, Technique


def reread(tablature):
    score = midi.read(midi_writer.write(tablature))
    return unroll(score, choose(score, None)[0])


def heard(tablature):
    return [(note.place, note.duration_s) for note in tablature.notes]


@settings(deadline=None, max_examples=25)
@given(scores())
def test_places_and_times_survive(score):
    if any(note.string for note in score.parts[0].notes):
        tablature = unroll(score, score.parts[0])
        again = reread(tablature)
        assert len(again.notes) == len(tablature.notes)
        for before, after in zip(tablature.notes, again.notes, strict=True):
            assert abs(before.onset_s - after.onset_s) < 1e-4
            assert (before.string, before.fret) == (after.string, after.fret)
            assert after.velocity == (before.velocity or midi_writer.VELOCITY)
        assert (again.tuning, again.capo, again.title) == (
            tablature.tuning,
            tablature.capo,
            tablature.title,
        )
        assert heard(reread(again)) == heard(again)


def tracks(*contents, kind=1):
    file = mido.MidiFile(type=kind, ticks_per_beat=480)
    for messages in contents:
        file.tracks.append(mido.MidiTrack(messages))
    buffer = io.BytesIO()
    file.save(file=buffer)
    return midi.read(buffer.getvalue())


def sounding(pitch, channel=0):
    on = mido.Message("note_on", note=pitch, channel=channel, velocity=64)
    return [on, mido.Message("note_off", note=pitch, channel=channel, time=480)]


def test_each_track_is_an_instrument_and_in_type_0_each_channel():
    assert [len(part.notes) for part in tracks(sounding(60), sounding(62)).parts] == [1, 1]
    together = [*sounding(60), *sounding(62, channel=3)]
    assert [len(part.notes) for part in tracks(together, kind=0).parts] == [1, 1]
    assert [len(part.notes) for part in tracks(together, kind=1).parts] == [2]


def test_drums_and_bass_are_no_guitar():
    bass = [mido.Message("program_change", program=33), *sounding(40)]
    parts = tracks(sounding(40, channel=9), bass, sounding(60)).parts
    assert ["drum" in parts[0].obstacle, "bass" in parts[1].obstacle, parts[2].obstacle] == [
        True,
        True,
        "",
    ]


def test_tempo_and_signature_changes_make_bars():
    conductor = [
        mido.MetaMessage("time_signature", numerator=3, denominator=4),
        mido.MetaMessage("set_tempo", tempo=1_000_000),
        mido.MetaMessage("set_tempo", tempo=500_000, time=3 * 480),
    ]
    notes = [*sounding(60), *sounding(62), *sounding(64), *sounding(65)]
    score = tracks(conductor, notes)
    assert [bar.length for bar in score.bars] == [3, 3]
    tablature = unroll(score, score.parts[0])
    assert [note.onset_s for note in tablature.notes] == [0.0, 1.0, 2.0, 3.0]
    assert tablature.notes[3].duration_s == 0.5


def test_a_bend_moves_the_pitch_wheel_and_back():
    note = Note(0.0, 3, 7, 1.0, techniques=(Technique.BEND,), bend=((0.0, 0.0), (1.0, 12.0)))
    data = midi_writer.write(Tablature((note,)))
    wheel = [m for m in mido.MidiFile(file=io.BytesIO(data)) if m.type == "pitchwheel"]
    assert {message.channel for message in wheel} == {2}
    heights = [message.pitch for message in wheel]
    assert heights[:-1] == sorted(heights[:-1])
    assert heights[-1] == 0
    assert max(heights) > 7000
