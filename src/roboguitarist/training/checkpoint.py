"""A learner's state in one file that is there as a whole or not at all; nothing is pickled."""

from __future__ import annotations

import os
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError

try:
    import torch
except ModuleNotFoundError as error:
    raise RoboGuitaristError(
        "PyTorch is not installed (pip install 'roboguitarist[train]')"
    ) from error


def save(path: str | Path, state: Mapping[str, Any]) -> None:
    """Write nested dictionaries of numbers, text, arrays and tensors.

    The file replaces an older one only when it is complete and on the disk: a process killed at
    any moment leaves the old or the new one.

    Raises:
        RoboGuitaristError: If it cannot be written; the old one stays.
    """
    with storage.replacing(path) as temporary, temporary.open("wb") as file:
        try:
            torch.save(_tensors(state), file)
            file.flush()
            os.fsync(file.fileno())
        except RuntimeError as error:  # so PyTorch reports a full disk
            cause = error.__context__
            raise cause if isinstance(cause, OSError) else OSError(None, str(error)) from error


def load(path: str | Path) -> dict[str, Any]:
    """Read what `save` wrote, arrays as tensors; nothing in the file is executed.

    Raises:
        RoboGuitaristError: If it is not such a file.
    """
    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        raise RoboGuitaristError(f"cannot read {path}: {error.strerror or error}") from error
    except (RuntimeError, EOFError, KeyError, ValueError, pickle.UnpicklingError) as error:
        raise RoboGuitaristError(f"{path}: not a checkpoint ({error})") from error


def _tensors(item: Any) -> Any:
    if isinstance(item, np.ndarray):
        return torch.from_numpy(
            item if item.flags.c_contiguous and item.flags.writeable else item.copy()
        )
    if isinstance(item, Mapping):
        return {key: _tensors(value) for key, value in item.items()}
    return item
