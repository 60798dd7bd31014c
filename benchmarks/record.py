"""Writing results in one form: the command, the versions it ran with, and what came out."""

from __future__ import annotations

import json
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

from roboguitarist import storage

FOLDER = Path(__file__).parent / "results"
PACKAGES = ("roboguitarist", "mujoco", "mink", "numpy", "scipy")


def versions(*more: str) -> dict[str, str]:
    """Versions of Python and of the packages that results depend on, and of others by name."""
    found = {package: version(package) for package in (*PACKAGES, *more)}
    return {"python": ".".join(map(str, sys.version_info[:3])), **found}


def write(name: str, results: Any, **facts: Any) -> Path:
    """Write `results` to a file of that name and return its path.

    Args:
        name: Stem of the file, and of the script that makes it.
        results: Anything that JSON can hold.
        facts: What else the results depend on, such as the processor.
    """
    path = FOLDER / f"{name}.json"
    document = {
        "command": f"python benchmarks/{name}.py",
        "versions": versions(),
        **facts,
        "results": results,
    }
    with storage.replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return path
