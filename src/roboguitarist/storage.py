"""Saving a frozen dataclass of arrays to one `.npz` and reading it back, without pickle."""

from __future__ import annotations

import io
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from roboguitarist.errors import RoboGuitaristError


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

    Raises:
        RoboGuitaristError: If the file is missing or is not such a file.
    """
    decode = decode or {}
    try:
        with np.load(path, allow_pickle=False) as archive:
            values = {entry.name: archive[entry.name] for entry in fields(kind)}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise RoboGuitaristError(f"{path}: not a saved {kind.__name__} ({error})") from error
    for name, value in values.items():
        if name in decode:
            values[name] = decode[name](str(value))
        elif value.ndim == 0:
            values[name] = value.item()
    return kind(**values)
