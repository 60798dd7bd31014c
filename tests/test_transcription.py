from hypothesis import given, settings

from builders import idle, perfect, tablatures, with_pluck
from roboguitarist import transcription
from roboguitarist.tablature import Note, Tablature, Technique


@settings(deadline=None, max_examples=30)
@given(tablatures(min_notes=1))
def test_a_perfect_performance_is_heard_as_it_was_asked(tablature):
    heard = transcription.heard(perfect(tablature, control_hz=100.0))
    assert [note.place for note in heard.notes] == [note.place for note in tablature.notes]
    assert (heard.tuning, heard.capo, heard.tempi) == (
        tablature.tuning,
        tablature.capo,
        tablature.tempi,
    )


def test_a_note_lasts_until_the_string_is_let_go_or_plucked_again():
    notes = (Note(0.0, 1, 3, 0.5), Note(1.0, 1, 5, 0.25), Note(1.25, 1, 7, 0.5))
    heard = transcription.heard(perfect(Tablature(notes), control_hz=100.0))
    lengths = [note.duration_s for note in heard.notes]
    for length, expected in zip(lengths, (0.5, 0.25, 0.5), strict=True):
        assert abs(length - expected) < 0.02


def test_a_dead_string_is_a_dead_note_and_silence_is_none():
    silent = idle(Tablature((Note(0.0, 1, 3, 0.5),)))
    assert transcription.heard(silent).notes == ()
    (note,) = transcription.heard(with_pluck(silent, 0.2, 2, -1)).notes
    assert (note.string, note.fret, note.techniques) == (2, 0, (Technique.DEAD,))
    assert note.right_finger == "p"
