"""Zip archives with a score inside: compressed MusicXML, and Guitar Pro 7 and 8 (.gp).

Format: https://www.w3.org/2021/06/musicxml40/tutorial/compressed-mxl-files/
"""

from __future__ import annotations

import io
import zipfile
import zlib

from roboguitarist.errors import TabError
from roboguitarist.formats import xml_tree

MAX_ARCHIVE_BYTES = 10_000_000
MAX_MEMBERS = 1000
MAX_MEMBER_BYTES = 50_000_000
_CONTAINER = "META-INF/container.xml"
_GPIF = "score.gpif"


def score_bytes(data: bytes) -> bytes:
    """The XML text of the score in an archive.

    Raises:
        TabError: If the archive is broken, encrypted or too large, or names no score.
    """
    if len(data) > MAX_ARCHIVE_BYTES:
        raise TabError("archive too large", hint=f"at most {MAX_ARCHIVE_BYTES // 10**6} MB")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if len(archive.infolist()) > MAX_MEMBERS:
                raise TabError(f"more than {MAX_MEMBERS} files in the archive")
            return _read(archive, _root_file(archive))
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError) as error:
        raise TabError(f"broken archive: {error}") from error
    except (NotImplementedError, RuntimeError, ValueError) as error:
        raise TabError(f"archive cannot be unpacked: {error}") from error


def _root_file(archive: zipfile.ZipFile) -> str:
    names = archive.namelist()
    if _CONTAINER not in names:
        gpif = next((name for name in names if name.endswith(_GPIF)), None)
        if gpif is not None:
            return gpif
        raise TabError(f"not an archive with a score: no {_CONTAINER} and no {_GPIF}")
    container = xml_tree.parse(_read(archive, _CONTAINER))
    paths = [entry.get("full-path", "") for entry in container.iterfind(".//rootfile")]
    found = [path for path in paths if path in names]
    if not found:
        raise TabError("the archive does not name the file with the score (rootfile)")
    return found[0]


def _read(archive: zipfile.ZipFile, name: str) -> bytes:
    """Unpack one file, trusting its real size only, not the one that the archive states."""
    with archive.open(name) as member:
        data = member.read(MAX_MEMBER_BYTES + 1)
    if len(data) > MAX_MEMBER_BYTES:
        limit = MAX_MEMBER_BYTES // 10**6
        raise TabError(f"{name} unpacks to more than {limit} MB")
    return data
