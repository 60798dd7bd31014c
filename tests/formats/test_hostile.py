"""Files that are made to harm, or that make no sense: one line each, soon, in little memory."""

import io
import random
import time
import tracemalloc
import zipfile

import mido
import pytest
from musicxml_texts import CONTAINER, archive, attributes, note, score
from score_files import ASCII, FILES, gp, gpif, guitar_pro, musicxml, packed

from complaints import complaint
from roboguitarist import formats
from roboguitarist.cli import main
from roboguitarist.errors import TabError

LOLS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
LAUGHS = f'<!DOCTYPE s [<!ENTITY l0 "lol">{LOLS}]>'
BLOW_UP = f'<!DOCTYPE s [<!ENTITY a "{"a" * 50_000}">]>'
EXTERNAL = '<!DOCTYPE s [<!ENTITY x SYSTEM "file:///etc/hostname">]>'
DOCTYPES = {"laughs": LAUGHS, "quadratic": BLOW_UP, "external": EXTERNAL}
SEVEN = ASCII.rstrip() + "\nB|---------|---------|\n"
DRUMS = "\n".join(f"{name}|x-x-x-x-|o---o---|" for name in ("CC", "HH", "SD", "T1", "FT", "BD"))
PLACE = "<notations><technical><string>{}</string><fret>{}</fret></technical></notations>"


def zip_bomb():
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("META-INF/container.xml", CONTAINER)
        file.writestr("score.xml", bytes(100_000_000))
    return buffer.getvalue()


def dotted():
    container = '<container><rootfile full-path="../../../etc/passwd"/></container>'
    return archive({"../../../etc/passwd": b"root"}, container)


def midi():
    file = mido.MidiFile(type=0)
    file.tracks.append(mido.MidiTrack())
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


def drums():
    track = mido.MidiTrack()
    track.append(mido.Message("note_on", channel=9, note=40, velocity=70))
    track.append(mido.Message("note_off", channel=9, note=40, time=100))
    file = mido.MidiFile(type=0)
    file.tracks.append(track)
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


def unended(n_ended):
    """A note that is never let go, and after it some that are."""
    track = mido.MidiTrack([mido.Message("note_on", note=48, velocity=70)])
    for _ in range(n_ended):
        track.append(mido.Message("note_on", note=64, velocity=70))
        track.append(mido.Message("note_off", note=64, time=480))
    file = mido.MidiFile(type=0, ticks_per_beat=480)
    file.tracks.append(track)
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


def silent():
    return "\n".join(f"{name}|----|----|" for name in "eBGDAE").encode()


def for_ever():
    """More repeats than anyone would play, and a da capo behind them."""
    bar = note("C4") + '<barline><repeat direction="backward" times="100"/></barline>'
    return score(*[bar] * 200, '<direction><sound dacapo="yes"/></direction>')


def placed(string: object, fret: object, duration: object = 1) -> bytes:
    return score(note("C4", duration, PLACE.format(string, fret)))


def gpif_with(old, new):
    text = gpif().decode()
    assert old in text
    return gp(text.replace(old, new).encode())


CUT = {"a.alphatex": 0.8, "a.txt": 0.6}
"""Where files are cut off; text that ends between notes is a shorter text, and no fault."""
TRUNCATED = {name: made()[: int(len(made()) * CUT.get(name, 0.5))] for name, made in FILES.items()}
REFUSED = {
    "empty.gp5": (b"", "empty"),
    "zeros.mid": (bytes(100), "empty"),
    "picture.gp5": (b"\x89PNG\r\n\x1a\n" + bytes(99), "PNG"),
    "picture.mid": (b"\xff\xd8\xff\xe0" + bytes(99), "JPEG"),
    "page.gpx": (b"<!DOCTYPE html><html><body>404</body></html>", "html"),
    "page.txt": (b"<html><body><p>404</p></body></html>", "html"),
    "noise.gp4": (bytes(range(1, 256)) * 9, "not a score"),
    **{
        f"{name}.musicxml": (score(note("C4"), before=doctype), "entities")
        for name, doctype in DOCTYPES.items()
    },
    **{
        f"{name}.gp": (gp(b'<?xml version="1.0"?>' + doctype.encode() + gpif()), "entities")
        for name, doctype in DOCTYPES.items()
    },
    "bomb.mxl": (zip_bomb(), "unpacks to more than"),
    "bomb.gpx": (b"BCFZ" + (10**9).to_bytes(4, "little") + b"\xff" * 99, "unpacks to more"),
    "dots.mxl": (dotted(), "XML"),
    "nothing.mxl": (archive({}, None), "container"),
    "nothing.gp": (archive({"Content/meta.json": b""}, None), "container"),
    "nothing.gpx": (packed(b"BCFS" + bytes(0x3000)), "no score.gpif"),
    "copy.gpx": (b"BCFZ" + bytes([9, 0, 0, 0]) + b"\xff" * 9, "before its start"),
    "rests.musicxml": (score(note()), "no notes"),
    "rests.mid": (midi(), "no part"),
    "fret99.musicxml": (placed(1, 99), "fret 99"),
    "fret-3.musicxml": (placed(1, -3), "fret -3"),
    "abc.musicxml": (placed(1, "abc"), "'abc' is not a number"),
    "string9.musicxml": (placed(9, 1), "9 strings"),
    "nan.musicxml": (placed("nan", 1), "'nan' is not a number"),
    "back.musicxml": (placed(1, 1, -1), "duration of -1"),
    "endless.musicxml": (placed(1, 1, "inf"), "'inf' is not a number"),
    "huge.musicxml": (placed(1, 1, "1e999"), "is not a number"),
    "long.musicxml": (placed(1, 1, 999_999_999), "four hours|duration"),
    "zero.musicxml": (
        score(attributes("<divisions>0</divisions>") + note("C4")),
        "divisions of 0",
    ),
    "repeats.musicxml": (for_ever(), "repeats make more than|played for ever"),
    "dacapo.musicxml": (
        score(note("C4"), note("D4") + '<direction><sound dacapo="yes"/></direction>'),
        "bar 2: this da capo would be played for ever",
    ),
    "transposed.musicxml": (
        score(
            attributes("<transpose><octave-change>-9999999</octave-change></transpose>")
            + note("C4")
        ),
        "transposition by",
    ),
    "unended.mid": (unended(n_ended=1), "1 of its 2 notes never end"),
    "silent.txt": (silent(), "no notes"),
    **{f"truncated.{name}": (data, None) for name, data in TRUNCATED.items()},
    "fret99.gp": (gpif_with("<Fret>3</Fret>", "<Fret>99</Fret>"), "fret 99"),
    "fret-3.gp": (gpif_with("<Fret>3</Fret>", "<Fret>-3</Fret>"), "fret -3"),
    "abc.gp": (gpif_with("<Fret>3</Fret>", "<Fret>abc</Fret>"), "'abc' is not a number"),
    "string9.gp": (gpif_with("<String>1</String>", "<String>8</String>"), "string 9"),
    "tuplet.gp": (
        gpif_with("<NoteValue>W", '<PrimaryTuplet num="0" den="2"/><NoteValue>W'),
        "tuplet of '0'",
    ),
    "value.gp": (gpif_with("<NoteValue>Whole", "<NoteValue>Inf"), "note value 'Inf'"),
    "tempo.gp": (gpif_with("100 2", "-5 2"), "tempo -5"),
    "time.gp": (gpif_with("<Time>4/4", "<Time>4/0"), "time signature '4/0'"),
    "seven.gp": (gpif_with("40 45", "35 40 45"), "7 strings"),
    "bass.gp": (gpif_with("40 45 50 55 59 64", "28 33 38 43"), "bass"),
    "fret99.gp3": (guitar_pro((3, 0, 0), fret=99), "fret 99"),
    "fret99.gp5": (guitar_pro((5, 1, 0), fret=99), "fret 99"),
    "division.mid": (midi()[:12] + b"\0\0" + midi()[14:], "division 0"),
    "frames.mid": (midi()[:12] + b"\xe8\x28" + midi()[14:], "film frames"),
    "drums.mid": (drums(), "drum part"),
    "drums.txt": (DRUMS.encode(), "drum"),
    "seven.txt": (SEVEN.encode(), "7 strings"),
    "conflict.txt": (f"<<<<<<< HEAD\n{ASCII}=======\n{ASCII}>>>>>>> x\n".encode(), "git"),
    "within.txt": (ASCII.replace("G|", "<<<<<<< HEAD\nG|").encode(), "git"),
    "fret99.txt": (ASCII.replace("-3-", "-99-").encode(), "fret 99"),
    "abc.txt": (ASCII.replace("--1-", "-abc-").encode(), "sign 'a'"),
    "tempo.txt": (ASCII.replace("100", "0").encode(), "tempo 0"),
    "grid.txt": (ASCII.replace("Grid: 8", "Grid: 9999").encode(), "grid 9999"),
    "fret99.alphatex": (b"\\tempo 120 . 99.1", "fret 99"),
    "string9.alphatex": (b"\\tempo 120 . 3.9", "string 9"),
    "abc.alphatex": (b"\\tempo 120 . abc.1", "is read"),
    "zero.alphatex": (b"\\tempo 120 . 3.3.0", "duration 0"),
    "open.alphatex": (b"\\tempo 120 . (3.3 4.4", "is read"),
    "many.alphatex": (b"\\tempo 120 . 3.3*999999", "999999 times"),
    "tempo.alphatex": (b"\\tempo 0 . 3.3", "tempo 0"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_in_one_line_soon_and_in_little_memory(tmp_path, name):
    data, reason = REFUSED[name]
    path = tmp_path / name
    path.write_bytes(data)
    tracemalloc.start()
    start = time.process_time()
    try:
        with pytest.raises(TabError) as caught:
            formats.load(path)
        assert time.process_time() - start < 5
        assert tracemalloc.get_traced_memory()[1] < 1e9
    finally:
        tracemalloc.stop()
    message = str(caught.value)
    assert message.startswith(f"{name}")
    assert len(message.splitlines()) == 1
    if reason is not None:
        assert any(part in message for part in reason.split("|")), message


@pytest.mark.parametrize("name", REFUSED)
def test_the_command_line_says_so_in_one_line(tmp_path, capsys, name):
    path = _written(tmp_path / name, REFUSED[name][0])
    assert main(["finger", str(path)]) == 2
    assert name in complaint(capsys)
    assert main(["convert", str(path), str(tmp_path / "out.json")]) == 2
    assert name in complaint(capsys)
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", FILES)
def test_a_flipped_bit_is_read_or_refused_in_one_line(tmp_path, capsys, name):
    rng = random.Random(name)
    for _ in range(12):
        data = bytearray(FILES[name]())
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        path = _written(tmp_path / name, bytes(data))
        status = main(["convert", str(path), str(tmp_path / "out.json")])
        assert status in (0, 2)
        if status:
            assert name in complaint(capsys)
        capsys.readouterr()


def test_xml_in_the_encoding_that_it_declares_is_read(tmp_path):
    text = musicxml().decode().replace("Guitar", "Gitarre für zwei Hände")
    expected = formats.load(_written(tmp_path / "a.xml", text.encode()))
    for code in ("UTF-16", "ISO-8859-1", "windows-1252"):
        declared = text.replace('version="1.0"', f'version="1.0" encoding="{code}"')
        data = declared.encode(code)
        assert formats.load(_written(tmp_path / "b.xml", data)) == expected


def test_a_da_capo_from_every_bar_comes_to_an_end(tmp_path):
    bar = '<direction><sound dacapo="yes" dalsegno="x"/></direction>' + note("C4")
    fine = bar.replace("<sound", '<sound fine="yes"')
    path = _written(tmp_path / "a.xml", score(*[bar] * 8, fine))
    assert len(formats.load(path).notes) == 10


def test_a_tab_in_an_old_code_is_read(tmp_path):
    text = "Title: Für Elise\n" + ASCII
    for data in (text.encode("latin-1"), text.encode(), text.encode("utf-16")):
        assert formats.load(_written(tmp_path / "a.txt", data)).title == "Für Elise"


def test_a_note_that_never_ends_lasts_until_its_track_does(tmp_path):
    tablature = formats.load(_written(tmp_path / "a.mid", unended(n_ended=10)))
    held = [note.duration_s for note in tablature.notes if note.string == 5]
    assert held == [10 * 0.5]
    assert any("1 notes never end" in line for line in tablature.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_fifty_megabytes_of_it_are_refused_or_read_soon(tmp_path, name):
    data = FILES[name]()
    filler = b"-" if name.endswith((".txt", ".alphatex")) else b" "
    path = _written(tmp_path / name, data + filler * (49_000_000 - len(data)))
    start = time.process_time()
    try:
        formats.load(path)
    except TabError as error:
        assert error.file == name  # noqa: PT017 - both are fine, but nothing else
    assert time.process_time() - start < 5


def _written(path, data):
    path.write_bytes(data)
    return path
