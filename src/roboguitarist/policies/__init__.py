"""Trained weights of the left hand that come with the package, each with a card and a checksum."""

from __future__ import annotations

import hashlib
import json
from importlib import resources

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.policy import Policy


def names() -> tuple[str, ...]:
    """Hand variants that have weights."""
    return tuple(sorted(_checksums()))


def load(hand: str) -> Policy:
    """The general policy for a hand variant.

    Raises:
        RoboGuitaristError: If there is none, or the file is not the one that was published.
    """
    checksums = _checksums()
    if hand not in checksums:
        raise RoboGuitaristError(
            f"no trained policy for the hand {hand!r} (there are {', '.join(checksums)};"
            " the controller 'planner' needs none)"
        )
    with resources.as_file(resources.files(__name__) / f"{hand}.npz") as path:
        if hashlib.sha256(path.read_bytes()).hexdigest() != checksums[hand]:
            raise RoboGuitaristError(f"{path}: these are not the published weights (checksum)")
        return Policy.load(path)


def _checksums() -> dict[str, str]:
    """SHA-256 of each variant's weights."""
    text = (resources.files(__name__) / "checksums.json").read_text(encoding="utf-8")
    return json.loads(text)
