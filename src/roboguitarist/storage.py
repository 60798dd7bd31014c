"""Saving a frozen dataclass of arrays to one `.npz` and reading it back, without pickle."""

from __future__ import annotations

import io
import os
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, get_origin, get_type_hints

import numpy as np

from roboguitarist.errors import RoboGuitaristError

MAX_BYTES = 2_000_000_000
"""Unpacked size from which a file is refused."""


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that becomes `path` if the block succeeds, else is removed.

    Raises:
        RoboGuitaristError: If the folder cannot be written or the disk is full.
    """
    path = Path(path)
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".part-", suffix=path.suffix)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        raise RoboGuitaristError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def save(
    path: str | Path, item: Any, encode: dict[str, Callable[[Any], str]] | None = None
) -> None:
    """Write the fields of dataclass `item` to `path` as a compressed `.npz`.

    The bytes depend on the content only. Fields named in `encode` go through that function to
    text first; the others must be arrays, numbers, strings or tuples of one of these.

    Raises:
        RoboGuitaristError: If the file cannot be written.
    """
    encode = encode or {}
    arrays = {}
    for entry in fields(item):
        value = getattr(item, entry.name)
        arrays[entry.name] = np.asarray(
            encode[entry.name](value) if entry.name in encode else value
        )
        if arrays[entry.name].dtype.hasobject:
            raise TypeError(f"field {entry.name} cannot be stored as an array")
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    with replacing(path) as temporary:
        temporary.write_bytes(buffer.getvalue())


def load(
    path: str | Path, kind: type, decode: dict[str, Callable[[str], Any]] | None = None
) -> Any:
    """Read a dataclass of type `kind` that `save` wrote.

    A field with a default may be missing: files stay readable when a dataclass gains one.

    Raises:
        RoboGuitaristError: If the file is missing or is not such a file.
    """
    decode, hints = decode or {}, get_type_hints(kind)
    try:
        arrays = _arrays(Path(path), kind)
        values = {
            name: array if name in decode else _restored(array, hints[name], name)
            for name, array in arrays.items()
        }
    except OSError as error:
        raise RoboGuitaristError(f"cannot read {path}: {error.strerror or error}") from error
    except _BROKEN as error:
        raise RoboGuitaristError(f"{path}: not a saved {kind.__name__} ({error})") from error
    for name, text in decode.items():
        if name in values:
            values[name] = text(str(values[name]))
    return kind(**values)


# What numpy and zipfile raise on files that are broken in one way or another.
_BROKEN = (
    ValueError,
    TypeError,
    KeyError,
    AttributeError,
    EOFError,
    MemoryError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
)


def _arrays(path: Path, kind: type) -> dict[str, np.ndarray]:
    with zipfile.ZipFile(path) as archive:
        if sum(member.file_size for member in archive.infolist()) > MAX_BYTES:
            raise ValueError(f"it unpacks to more than {MAX_BYTES // 10**9} GB")
    with np.load(path, allow_pickle=False) as archive:
        return {
            entry.name: archive[entry.name]
            for entry in fields(kind)
            if entry.default is MISSING or entry.name in archive
        }


_KINDS = {int: "iu", float: "fiu", str: "U", bool: "b", np.ndarray: "biufU"}


def _restored(array: np.ndarray, declared: type, name: str) -> Any:
    """The value of a field as it was before saving."""
    if get_origin(declared) is tuple:
        return tuple(array.tolist())
    if array.dtype.kind not in _KINDS.get(declared, array.dtype.kind):
        raise TypeError(f"{name} holds {array.dtype}, not {declared.__name__}")
    if declared is np.ndarray:
        return array
    if array.ndim:
        raise TypeError(f"{name} is not a single {declared.__name__}")
    return array.item()
