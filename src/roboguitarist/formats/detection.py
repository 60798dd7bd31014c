"""What kind of score some bytes are, and reading them with the reader for it.

The content decides, not the name of the file: many a file is named wrongly.
"""

from __future__ import annotations

from roboguitarist.errors import TabError
from roboguitarist.formats import (
    alphatex,
    ascii_tab,
    gpif,
    gpx,
    guitar_pro,
    midi,
    musicxml,
    mxl,
    xml_tree,
)
from roboguitarist.formats.written import WrittenScore

READ = (
    "MusicXML (.musicxml, .xml, .mxl), Guitar Pro (.gp3, .gp4, .gp5, .gpx, .gp), MIDI (.mid), "
    "ASCII tab (.txt, .tab), alphaTex (.alphatex) and JSON tablature (.json) are read"
)
_OTHER_KINDS = {
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"GIF8": "a GIF picture",
    b"%PDF": "a PDF document",
    b"RIFF": "a sound or video file",
    b"ID3": "a sound file",
    b"OggS": "a sound file",
    b"fLaC": "a sound file",
    b"\x1f\x8b": "a gzip archive",
    b"Rar!": "a RAR archive",
    b"7z\xbc\xaf": "a 7-Zip archive",
    b"ptab": "a Power Tab file",
}
_BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff")
_CONFLICT = b"<<<<<<<"
_XML_SUFFIXES = ("", ".xml", ".musicxml", ".mxl")


def read(
    data: bytes, suffix: str = "", tempo: float | None = None, grid: int | None = None
) -> WrittenScore:
    """Read a score of any kind but JSON.

    Args:
        data: The whole file.
        suffix: Of the file's name, for the message if it is no score.
        tempo: Of an ASCII tab, see `ascii_tab.read`.
        grid: Of an ASCII tab.

    Raises:
        TabError: If it is no score, or a broken one.
    """
    for magic, kind in _OTHER_KINDS.items():
        if data.startswith(magic):
            raise TabError(f"this is {kind}", hint=READ)
    if data.startswith(b"MThd"):
        return midi.read(data)
    if data.startswith(guitar_pro.MAGIC, 1):
        return guitar_pro.read(data)
    if data.startswith(gpx.MAGIC):
        return gpif.read(gpx.score_bytes(data))
    if data.startswith(b"PK"):
        return _read_xml(mxl.score_bytes(data))
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if (text.startswith(b"<") and not text.startswith(_CONFLICT)) or _is_utf16_xml(data):
        return _read_xml(data)
    return _read_text(data, suffix, tempo, grid)


def _read_xml(data: bytes) -> WrittenScore:
    root = xml_tree.parse(data)
    return gpif.read(root) if root.tag == "GPIF" else musicxml.read(root)


def _is_utf16_xml(data: bytes) -> bool:
    start = data[:200].removeprefix(b"\xff\xfe").removeprefix(b"\xfe\xff")
    return start.replace(b"\0", b"").lstrip().startswith(b"<") and b"\0" in start


def _read_text(data: bytes, suffix: str, tempo: float | None, grid: int | None) -> WrittenScore:
    if b"\0" not in data or data.startswith(_BYTE_ORDER_MARKS):
        text = _decoded(data)
        if alphatex.is_alphatex(text):
            return alphatex.read(text)
        if ascii_tab.is_tab(text):
            return ascii_tab.read(text, tempo, grid)
    what = f"a {suffix} file" if suffix not in _XML_SUFFIXES else "this"
    raise TabError(f"{what} is not a score that can be read", hint=READ)


def _decoded(data: bytes) -> str:
    """Text in UTF-8, UTF-16 with a byte order mark, or else in the code of old Windows."""
    if data.startswith(_BYTE_ORDER_MARKS):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")
