import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import TabError
from roboguitarist.tablature import STANDARD_TUNING, Note, Tablature, Tempo, validate
from strategies import tablatures

NOTE = Note(onset_s=0.5, string=2, fret=3, duration_s=0.25)
JSON = json.loads(Tablature((NOTE,)).to_json())
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
GARBAGE = st.recursive(SCALARS, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner))


@given(tablatures())
def test_saving_and_loading_gives_the_same_tablature(tablature):
    text = tablature.to_json()
    assert Tablature.from_json(text) == tablature
    assert Tablature.from_json(text).to_json() == text


@given(tablatures(min_notes=1))
def test_pitch_is_tuning_plus_capo_plus_fret(tablature):
    capo_up = replace(tablature, capo=tablature.capo + 1)
    for note in tablature.notes:
        pitch = tablature.pitch(note)
        assert pitch == tablature.tuning[note.string - 1] + tablature.capo + note.fret
        assert capo_up.pitch(note) == pitch + 1
        assert tablature.pitch(replace(note, fret=note.fret + 12)) == pitch + 12


@given(tablatures(min_notes=1))
def test_a_stopped_fret_counts_from_the_nut_and_open_strings_need_none(tablature):
    for note in tablature.notes:
        stopped = tablature.stopped_fret(note)
        assert (stopped == 0) == (note.fret == 0)
        if stopped:
            assert STANDARD_TUNING[0] + stopped == STANDARD_TUNING[0] + note.fret + tablature.capo


@given(tablatures())
def test_the_piece_ends_with_its_last_note(tablature):
    ends = [note.onset_s + note.duration_s for note in tablature.notes]
    assert tablature.duration_s == max(ends, default=0)


@given(tablatures(), st.floats(0.25, 4.0))
def test_speed_divides_all_times_and_nothing_else(tablature, factor):
    faster = tablature.at_speed(factor)
    assert faster.duration_s == pytest.approx(tablature.duration_s / factor, abs=2e-6)
    assert faster.tempi[0].quarters_per_minute == tablature.tempi[0].quarters_per_minute * factor
    for before, after in zip(tablature.notes, faster.notes, strict=True):
        assert after.onset_s == pytest.approx(before.onset_s / factor, abs=1e-6)
        same_time = {"onset_s": before.onset_s, "duration_s": before.duration_s}
        assert replace(after, **same_time) == before
    assert tablature.at_speed(1.0) == tablature


@pytest.mark.parametrize("factor", [0.0, -1.0, float("nan"), float("inf"), 11.0])
def test_an_absurd_speed_is_refused(factor):
    with pytest.raises(TabError, match="speed"):
        Tablature((NOTE,)).at_speed(factor)


@given(tablatures(min_notes=2, chord=1))
def test_notes_out_of_order_are_refused(tablature):
    with pytest.raises(TabError, match="order"):
        validate(replace(tablature, notes=tablature.notes[::-1]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fret": 37}, "bar 1, beat 1: fret 37 (0 to 24)"),
        ({"fret": -1}, "fret -1"),
        ({"string": 7}, "string 7"),
        ({"string": 0}, "string 0"),
        ({"duration_s": -1.0}, "duration of -1 s"),
        ({"duration_s": 0.0}, "duration of 0 s"),
        ({"duration_s": float("nan")}, "duration of nan s"),
        ({"onset_s": -0.1}, "onset at -0.1 s"),
        ({"onset_s": float("inf")}, "onset at inf s"),
        ({"beat": float("nan")}, "beat that is not a number"),
        ({"left_finger": 5}, "left finger 5"),
        ({"right_finger": "q"}, "right finger q"),
        ({"bend": ((0.0, 1.0), (1.5, 2.0))}, "a bend out of range"),
        ({"bend": ((0.5, 1.0), (0.2, 2.0))}, "a bend out of range"),
        ({"bend": ((0.0, -1.0),)}, "a bend out of range"),
        ({"velocity": 128}, "velocity 128"),
    ],
)
def test_a_note_that_no_guitar_has_is_refused(change, message):
    with pytest.raises(TabError) as caught:
        validate(Tablature((replace(NOTE, **change),)), file="x.json")
    assert message in str(caught.value)
    assert str(caught.value).startswith("x.json, bar 1")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tuning": STANDARD_TUNING[:4]}, "4 strings"),
        ({"tuning": (*STANDARD_TUNING, 35)}, "7 strings"),
        ({"tuning": (*STANDARD_TUNING[:5], -1)}, "tuning"),
        ({"capo": 13}, "capo at fret 13"),
        ({"tempi": ()}, "tempo"),
        ({"tempi": (Tempo(0.0, 0.0),)}, "tempo"),
        ({"tempi": (Tempo(0.0, float("nan")),)}, "tempo"),
        ({"tempi": (Tempo(float("nan"), 100.0),)}, "tempo"),
        ({"tempi": (Tempo(1.0, 100.0), Tempo(0.0, 100.0))}, "order"),
        ({"notes": (NOTE, replace(NOTE, fret=5))}, "two notes on string 2 at once"),
    ],
)
def test_a_piece_that_no_guitar_has_is_refused(change, message):
    with pytest.raises(TabError, match=message):
        validate(replace(Tablature((NOTE,)), **change))


@given(st.text() | GARBAGE.map(json.dumps))
def test_garbage_is_refused_in_one_line(text):
    with pytest.raises(TabError) as caught:
        Tablature.from_json(text)
    assert "\n" not in str(caught.value)


@given(st.sampled_from([*JSON, *(("notes", name) for name in JSON["notes"][0])]), GARBAGE)
def test_a_field_of_another_type_is_refused_or_valid(place, value):
    data = json.loads(json.dumps(JSON))
    if isinstance(place, tuple):
        data["notes"][0][place[1]] = value
    else:
        data[place] = value
    try:
        tablature = Tablature.from_json(json.dumps(data))
    except TabError:
        return
    assert validate(tablature) == tablature
    for note in tablature.notes:
        assert type(note.fret) is int
        assert type(note.onset_s) is float


@pytest.mark.parametrize("name", ["string", "fret", "onset_s", "duration_s", "bar"])
def test_true_is_not_a_number(name):
    data = json.loads(json.dumps(JSON))
    data["notes"][0][name] = True
    with pytest.raises(TabError, match="True"):
        Tablature.from_json(json.dumps(data))


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"notes": ' + "9" * 5000 + "}", '{"notes": [{"onset_s": 1e999}]}']
)
def test_hostile_json_is_refused(text):
    with pytest.raises(TabError):
        Tablature.from_json(text)
