"""Files of Guitar Pro 6 (.gpx) and of 7 and 8 (.gp): the GPIF document inside.

A .gp file is a zip archive. A .gpx file is a small file system of sectors, mostly packed with a
code of literal bytes and of copies from what was unpacked before.
"""

from __future__ import annotations

from collections.abc import Iterator

from roboguitarist.errors import TabError

SCORE = "score.gpif"
MAX_UNPACKED_BYTES = 50_000_000
_PACKED, _PLAIN = b"BCFZ", b"BCFS"
MAGIC = (_PACKED, _PLAIN)
_SECTOR = 0x1000
_FILE = 2
_NAME, _SIZE, _SECTORS = slice(4, 131), 0x8C, 0x94


def score_bytes(data: bytes) -> bytes:
    """The GPIF document in a .gpx file.

    Raises:
        TabError: If the file is broken, too large, or has no score.
    """
    if data.startswith(_PACKED):
        data = _unpacked(data)
    if not data.startswith(_PLAIN):
        raise TabError("broken Guitar Pro 6 file: no file system inside")
    for name, content in _files(data[len(_PLAIN) :]):
        if name == SCORE:
            return content
    raise TabError(f"broken Guitar Pro 6 file: no {SCORE}")


def _unpacked(data: bytes) -> bytes:
    length = int.from_bytes(data[4:8], "little")
    if length > MAX_UNPACKED_BYTES:
        limit = MAX_UNPACKED_BYTES // 10**6
        raise TabError(f"a Guitar Pro 6 file that unpacks to more than {limit} MB")
    out = bytearray()
    bit, last = 64, 8 * len(data)
    while len(out) < length and bit < last:
        # No code is longer than 35 bits; after up to 7 bits of the byte before.
        window = int.from_bytes(data[bit >> 3 : (bit >> 3) + 8].ljust(8, b"\0"), "big")
        window = (window << (bit & 7)) & 0xFFFF_FFFF_FFFF_FFFF
        if window >> 63:
            width = (window >> 59) & 15
            offset = _reversed((window >> (59 - width)) & ((1 << width) - 1), width)
            size = _reversed((window >> (59 - 2 * width)) & ((1 << width) - 1), width)
            if offset > len(out):
                raise TabError("broken Guitar Pro 6 file: a copy from before its start")
            start = len(out) - offset
            out += out[start : start + min(offset, size)]
            bit += 5 + 2 * width
        else:
            size = _reversed((window >> 61) & 3, 2)
            literal = (window >> (61 - 8 * size)) & ((1 << 8 * size) - 1)
            out += literal.to_bytes(size, "big")
            bit += 3 + 8 * size
    return bytes(out)


def _reversed(value: int, width: int) -> int:
    """The lowest bit first."""
    return int(f"{value:0{width}b}"[::-1], 2) if width else 0


def _files(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Name and content of every file; the sectors are counted from the first on."""
    for start in range(_SECTOR, len(data) - 3, _SECTOR):
        entry = data[start : start + _SECTOR]
        if int.from_bytes(entry[:4], "little") != _FILE:
            continue
        name = entry[_NAME].partition(b"\0")[0].decode("latin-1")
        size = int.from_bytes(entry[_SIZE : _SIZE + 4], "little")
        content = bytearray()
        for at in range(_SECTORS, len(entry) - 3, 4):
            sector = int.from_bytes(entry[at : at + 4], "little") * _SECTOR
            if not sector or len(content) >= size:
                break
            content += data[sector : sector + _SECTOR]
        yield name, bytes(content[:size])
