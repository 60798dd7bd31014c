"""Which finger plays which note: left hand 1 to 4, right hand p, i, m, a."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.tablature import Tablature

OPEN = 0
"""Left finger of an open string."""
UNPLAYABLE = -1
"""Left finger of a note that no finger can stop; the right hand still plucks it."""
LEFT_FINGERS = ("open", "index", "middle", "ring", "little")
RIGHT_FINGERS = ("p", "i", "m", "a")


@dataclass(frozen=True)
class Fingering:
    """A tablature with a finger of each hand for every note.

    Attributes:
        tablature: What is asked, with n notes.
        left: (n,) int8, 1 index to 4 little finger, `OPEN` or `UNPLAYABLE`.
        right: (n,) int8, 0 to 3 for p, i, m, a.
        barre: (n,) bool, the left finger lies flat over several strings.
        hold_position: (n,) int8, fret at which the index finger stands, from 1.
        problems: One line for each note that cannot be fingered, with bar and beat.
        method: Name of the method that chose the fingers.
    """

    tablature: Tablature
    left: np.ndarray
    right: np.ndarray
    barre: np.ndarray
    hold_position: np.ndarray
    problems: tuple[str, ...] = ()
    method: str = "paper"

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self, {"tablature": Tablature.to_json})

    @classmethod
    def load(cls, path: str | Path) -> Fingering:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        return storage.load(path, cls, {"tablature": Tablature.from_json})
