"""Reading scores: MusicXML, compressed MusicXML and our own JSON tablature."""

from __future__ import annotations

from pathlib import Path

from roboguitarist import storage
from roboguitarist.errors import TabError
from roboguitarist.formats import musicxml, musicxml_writer, mxl
from roboguitarist.formats.parts import choose
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Tablature

MAX_FILE_BYTES = 50_000_000
READ = "MusicXML (.musicxml, .xml), compressed MusicXML (.mxl) and JSON tablature (.json) are read"
WRITTEN = "MusicXML (.musicxml, .xml) and JSON tablature (.json) are written"
_BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff")
_KNOWN = {
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"%PDF": "a PDF document",
    b"MThd": "a MIDI file",
    b"\x18FICHIER GUITAR PRO": "a Guitar Pro file",
    b"BCFZ": "a Guitar Pro file",
    b"BCFS": "a Guitar Pro file",
}


def load(path: str | Path, track: int | str | None = None) -> Tablature:
    """Read a score; what it holds decides how, not only its suffix.

    Args:
        path: A MusicXML, MXL or JSON file.
        track: Number of the part from 1, or its name; by default the first that a six-string
            guitar can play, those with strings and frets before others.

    Returns:
        The part as it is played. Its `warnings` say what was read otherwise than written.

    Raises:
        TabError: If the file cannot be read or played; one line with the file's name.
    """
    path = Path(path)
    try:
        return _load(_read_bytes(path), path.suffix.lower(), track)
    except TabError as error:
        raise error.in_file(path.name) from error


def save(path: str | Path, tablature: Tablature) -> None:
    """Write a tablature; the suffix says how, and the file appears when it is complete.

    MusicXML (`.musicxml`, `.xml`) keeps notes, strings, frets, times, tempi, techniques and the
    fingers of both hands; repeats are written out. JSON (`.json`) keeps everything.

    Raises:
        TabError: If the suffix is not known or the file cannot be written.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".musicxml" | ".xml":
            data = musicxml_writer.write(tablature)
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


def _load(data: bytes, suffix: str, track: int | str | None) -> Tablature:
    for magic, kind in _KNOWN.items():
        if data.startswith(magic):
            raise TabError(f"this is {kind}", hint=READ)
    start = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    if data.startswith(b"PK"):
        data = mxl.score_bytes(data)
    elif start in (b"{", b"["):
        return _load_json(data)
    elif start != b"<" and not _is_utf16(data):
        what = f"a {suffix} file" if suffix not in ("", ".xml", ".musicxml", ".mxl") else "this"
        raise TabError(f"{what} is not a score that can be read", hint=READ)
    score = musicxml.read(data)
    part, warnings = choose(score, track)
    return unroll(score, part, warnings)


def _is_utf16(data: bytes) -> bool:
    return data.startswith(_BYTE_ORDER_MARKS) or data[:4] in (b"<\0?\0", b"\0<\0?")


def _load_json(data: bytes) -> Tablature:
    try:
        return Tablature.from_json(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise TabError("JSON that is not in UTF-8") from error
