"""Reading and writing scores.

MusicXML, Guitar Pro, MIDI, ASCII tab, alphaTex and our own JSON are read; MusicXML, MIDI, ASCII
tab and JSON are written.
"""

from __future__ import annotations

from pathlib import Path

from roboguitarist import storage
from roboguitarist.errors import TabError
from roboguitarist.formats import ascii_writer, detection, midi_writer, musicxml_writer
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Tablature

MAX_FILE_BYTES = 50_000_000
MAX_JSON_BYTES = 30_000_000
WRITTEN = (
    "MusicXML (.musicxml, .xml), MIDI (.mid), ASCII tab (.txt, .tab) and JSON (.json) are written"
)


def load(
    path: str | Path,
    track: int | str | None = None,
    *,
    tempo: float | None = None,
    grid: int | None = None,
) -> Tablature:
    """Read a score; what it holds decides how, not its suffix.

    Args:
        path: The file.
        track: Number of the part from 1, or its name; by default the first that a six-string
            guitar can play, those with strings and frets before others.
        tempo: Quarter notes a minute of an ASCII tab, from 10 to 1000; by default as the tab
            says, else 120.
        grid: A column of an ASCII tab is the grid-th part of a whole note, from 4 to 192; by
            default as the tab says, else 16.

    Returns:
        The part as it is played. Its `warnings` say what was read otherwise than written.

    Raises:
        TabError: If the file cannot be read or played; one line with the file's name.
    """
    path = Path(path)
    try:
        data = _read_bytes(path)
        first = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
        if first == b"{" or (first == b"[" and path.suffix.lower() == ".json"):
            return _load_json(data)
        score = detection.read(data, path.suffix.lower(), tempo, grid)
        part, warnings = choose(score, track)
        return unroll(score, part, warnings)
    except TabError as error:
        raise error.in_file(path.name) from error


def save(path: str | Path, tablature: Tablature) -> None:
    """Write a tablature; the suffix says how, and the file appears when it is complete.

    JSON (`.json`) keeps everything. MusicXML (`.musicxml`, `.xml`) keeps notes, strings, frets,
    times, tempi, techniques and the fingers of both hands; repeats are written out. MIDI (`.mid`,
    `.midi`) keeps times, tempi, strings and loudness. ASCII tab (`.txt`, `.tab`) keeps the order
    of strings and frets, some techniques, and times as far as a grid of columns can.

    Raises:
        TabError: If the suffix is not known or the file cannot be written.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".musicxml" | ".xml":
            data = musicxml_writer.write(tablature)
        case ".mid" | ".midi":
            data = midi_writer.write(tablature)
        case ".txt" | ".tab":
            data = ascii_writer.write(tablature)
        case ".json":
            data = tablature.to_json().encode()
        case suffix:
            raise TabError(f"cannot write {suffix or 'a file without suffix'}", hint=WRITTEN)
    with storage.replacing(path) as temporary:
        temporary.write_bytes(data)


def _read_bytes(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise TabError("is a folder", hint="name a file")
        if not path.exists():
            raise TabError("no such file")
        if not path.is_file():
            raise TabError("not a regular file")
        with path.open("rb") as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        raise TabError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if len(data) > MAX_FILE_BYTES:
        raise TabError("file too large", hint=f"at most {MAX_FILE_BYTES // 10**6} MB")
    if not data.strip(b"\0 \t\r\n"):
        raise TabError("the file is empty")
    return data


def _load_json(data: bytes) -> Tablature:
    if len(data) > MAX_JSON_BYTES:
        raise TabError("JSON too large", hint=f"at most {MAX_JSON_BYTES // 10**6} MB")
    try:
        return Tablature.from_json(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise TabError("JSON that is not in UTF-8") from error
