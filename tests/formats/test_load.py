import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from musicxml_texts import GUITAR, archive, attributes, measures, note, repeat, score, several

from roboguitarist import formats
from roboguitarist.errors import TabError
from roboguitarist.formats import load
from roboguitarist.tablature import STANDARD_TUNING, Note, Tablature
from strategies import tablatures

SCORE = score(note("C4", 2, place="2/1") + note("E4", 2, place="1/0"))


def write(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.musicxml", SCORE),
        ("a.xml", SCORE),
        ("a.mxl", archive({"score.xml": SCORE})),
        ("archive.musicxml", archive({"score.xml": SCORE})),
        ("plain.mxl", SCORE),
        ("noname", SCORE),
        ("mark.xml", b"\xef\xbb\xbf" + SCORE),
        ("wide.xml", SCORE.decode().encode("utf-16")),
    ],
)
def test_content_tells_how_to_read(tmp_path, name, data):
    tablature = load(write(tmp_path, name, data))
    assert tablature.notes == (
        Note(0.0, 2, 1, 1.0, bar=1, beat=1.0),
        Note(1.0, 1, 0, 1.0, bar=1, beat=3.0),
    )
    assert tablature.tuning == STANDARD_TUNING


@given(tablatures(max_notes=6))
def test_what_was_saved_as_json_is_loaded(tmp_path_factory, tablature):
    path = tmp_path_factory.getbasetemp() / "a.json"
    path.write_text(tablature.to_json(), encoding="utf-8")
    assert load(path) == tablature


def test_loading_and_saving_a_score_keeps_it(tmp_path):
    body = attributes("<divisions>3</divisions>") + note("C4") * 3 + repeat("backward")
    tablature = load(write(tmp_path, "a.musicxml", score(body)))
    assert len(tablature.notes) == 6
    assert Tablature.from_json(tablature.to_json()) == tablature


def test_a_part_is_chosen(tmp_path):
    second = GUITAR.replace("P1", "P2").replace("Guitar", "Second")
    data = several(measures(note("C4")), measures(note("D4")), header=GUITAR + second)
    path = write(tmp_path, "a.musicxml", data)
    assert [load(path).pitch(n) for n in load(path).notes] == [60]
    assert load(path).warnings == ("part 1 (Guitar) of 2 is played",)
    for track in (2, "second"):
        assert [load(path, track).pitch(n) for n in load(path, track).notes] == [62]


SEVEN = "".join(
    f"<staff-tuning line='{k}'><tuning-step>E</tuning-step><tuning-octave>{k}</tuning-octave>"
    "</staff-tuning>"
    for k in range(1, 8)
)
BAD = {
    "empty.musicxml": (b"", "empty"),
    "blank.musicxml": (b" \r\n", "empty"),
    "picture.musicxml": (b"\x89PNG\r\n\x1a\n" + bytes(99), "PNG"),
    "junk.musicxml": (bytes(range(256)) * 9, "not a score"),
    "cut.musicxml": (SCORE[:-40], "broken XML"),
    "cut.mxl": (archive({"score.xml": SCORE})[:-40], "broken archive"),
    "bomb.musicxml": (
        score(note("C4"), before='<!DOCTYPE a [<!ENTITY b "c">]>'),
        "entities",
    ),
    "fret.musicxml": (score(note("C4", place="1/37")), "bar 1, beat 1: fret 37"),
    "back.musicxml": (score(note("C4", -1)), "bar 1, beat 1: duration of -1"),
    "seven.musicxml": (
        score(attributes(f"<staff-details>{SEVEN}</staff-details>") + note("C4")),
        "7 strings",
    ),
    "bass.musicxml": (score(note("E2"), header=GUITAR.replace("Guitar", "Bass")), "bass"),
    "drums.musicxml": (score("<note><unpitched/><duration>1</duration></note>"), "drum"),
    "rests.musicxml": (score(note()), "no notes"),
    "page.xml": (b"<html/>", "not a MusicXML score"),
    "song.gp5": (b"\x18FICHIER GUITAR PRO v5.10", "broken Guitar Pro"),
    "song.mid": (b"MThd\0\0\0\6", "broken MIDI"),
    "tab.txt": (b"C D E F\n", ".txt file is not a score"),
    "bad.json": (b'{"notes": 3}', "not a saved tablature"),
    "latin.json": ('{"title": "Für"}'.encode("latin-1"), "UTF-8"),
    "list.json": (json.dumps([1, 2]).encode(), "not a saved tablature"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line_with_the_file_and_the_reason(tmp_path, name):
    data, reason = BAD[name]
    with pytest.raises(TabError) as caught:
        load(write(tmp_path, name, data))
    message = str(caught.value)
    assert message.startswith(name)
    assert reason in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["tab.txt", "junk.musicxml"])
def test_a_file_of_another_kind_is_told_what_is_read(tmp_path, name):
    with pytest.raises(TabError, match=r"\.musicxml, \.xml.*\.mxl.*\.json"):
        load(write(tmp_path, name, BAD[name][0]))


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(TabError, match=r"^b\.musicxml: no such file$"):
        load(tmp_path / "b.musicxml")
    with pytest.raises(TabError, match="is a folder"):
        load(tmp_path)
    with pytest.raises(TabError):
        load("a\0b")
    with pytest.raises(TabError):
        load(tmp_path / ("x" * 5000))


def test_a_large_file_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(formats, "MAX_FILE_BYTES", 100)
    with pytest.raises(TabError, match="too large"):
        load(write(tmp_path, "a.musicxml", SCORE))


@given(st.binary(max_size=300))
def test_any_bytes_are_refused_or_read(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.musicxml"
    path.write_bytes(data)
    with pytest.raises(TabError):
        load(path)


@given(st.data())
def test_a_score_with_any_byte_changed_is_refused_or_read(tmp_path_factory, data):
    place = data.draw(st.integers(0, len(SCORE) - 1))
    changed = bytearray(SCORE)
    changed[place] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "changed.musicxml"
    path.write_bytes(changed)
    try:
        tablature = load(path)
    except TabError:
        return
    assert Tablature.from_json(tablature.to_json()) == tablature
