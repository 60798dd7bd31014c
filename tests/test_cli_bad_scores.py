import io
import time
import zipfile

import pytest

from complaints import complaint
from roboguitarist.cli import main

NOTE = (
    "<note><pitch><step>C</step><octave>4</octave></pitch><duration>{duration}</duration>"
    "<notations><technical><string>{string}</string><fret>{fret}</fret></technical></notations>"
    "</note>"
)
CONTAINER = '<container><rootfiles><rootfile full-path="score.xml"/></rootfiles></container>'


def score(attributes="", header="", **note):
    note = NOTE.format(**{"duration": 4, "string": 2, "fret": 1, **note})
    return (
        '<?xml version="1.0"?><score-partwise><part-list><score-part id="P1">'
        f'<part-name>Part</part-name>{header}</score-part></part-list><part id="P1">'
        f'<measure number="1"><attributes><divisions>4</divisions>{attributes}</attributes>'
        f"{note}</measure></part></score-partwise>"
    ).encode()


def archive(content):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("META-INF/container.xml", CONTAINER)
        file.writestr("score.xml", content)
    return buffer.getvalue()


LOLS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
ENTITY_BOMB = f'<?xml version="1.0"?><!DOCTYPE s [<!ENTITY l0 "lol">{LOLS}]><s>&l9;</s>'.encode()
BASS_TUNING = "".join(
    f'<staff-tuning line="{line}"><tuning-step>{step}</tuning-step>'
    f"<tuning-octave>{octave}</tuning-octave></staff-tuning>"
    for line, (step, octave) in enumerate((("E", 1), ("A", 1), ("D", 2), ("G", 2)), 1)
)
DRUMS = "<midi-instrument id='I1'><midi-channel>10</midi-channel></midi-instrument>"
UNUSABLE = {
    "missing.musicxml": (None, "no such file"),
    "empty.musicxml": (b"", "empty"),
    "picture.musicxml": (b"\x89PNG\r\n\x1a\n" + bytes(100), "PNG"),
    "cut.musicxml": (score()[:-60], "XML"),
    "cut.mxl": (archive(score())[:-40], "archive"),
    "entities.musicxml": (ENTITY_BOMB, "entit"),
    "bomb.mxl": (archive(bytes(60_000_000)), "unpacks to more than"),
    "seven.musicxml": (
        score(attributes="<staff-details><staff-lines>7</staff-lines></staff-details>", string=7),
        "7 strings",
    ),
    "bass.musicxml": (
        score(
            attributes=f"<staff-details><staff-lines>4</staff-lines>{BASS_TUNING}</staff-details>"
        ),
        "bass",
    ),
    "drums.musicxml": (score(header=DRUMS), "drum"),
    "fret.musicxml": (score(fret=37), "fret 37"),
    "duration.musicxml": (score(duration=-4), "duration"),
    "notes.txt": (b"C D E F", "not a score"),
}


@pytest.mark.parametrize("name", UNUSABLE)
@pytest.mark.parametrize("command", ["play", "evaluate", "finger"])
def test_an_unusable_score_gives_one_line_and_leaves_nothing(command, name, tmp_path, capsys):
    content, reason = UNUSABLE[name]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    before = sorted(tmp_path.iterdir())
    options = {"play": ["--out", str(tmp_path / "out")], "evaluate": [], "finger": []}
    start = time.perf_counter()
    assert main([command, str(tmp_path / name), *options[command]]) == 2
    assert time.perf_counter() - start < 5
    line = complaint(capsys)
    assert name in line
    assert reason in line
    assert sorted(tmp_path.iterdir()) == before
