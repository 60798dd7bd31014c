"""What a fingering is: a finger of each hand for every note."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.tablature import Note, Tablature

OPEN = 0
"""Left finger of an open string."""
UNPLAYABLE = -1
"""Left finger of a note that no finger can stop; the right hand still plucks it."""
LEFT_FINGERS = ("open", "index", "middle", "ring", "little")
RIGHT_FINGERS = ("p", "i", "m", "a")
SIMULTANEOUS_S = 5e-6
"""Times nearer than this are one moment: note times are rounded to whole microseconds."""


@dataclass(frozen=True)
class Fingering:
    """A tablature with a finger of each hand for every note.

    Attributes:
        tablature: What is asked, with n notes.
        left: (n,) int8, 1 index to 4 little finger, `OPEN` or `UNPLAYABLE`.
        right: (n,) int8, 0 to 3 for p, i, m, a.
        barre: (n,) bool, the left finger lies flat over several strings.
        hold_position: (n,) int8, fret at which the index finger stands, from 1.
        release_s: (n,) when the left finger lets go of the note, in seconds.
        strum: (n,) int8, 1 for a note of a strum towards string 1, -1 towards string 6, else 0.
        difficulty: (n,) cost of the left hand's step to the note's onset; 0 if not known.
        problems: One line, with bar and beat, for each note that cannot be fingered and for
            each left finger marked in the file that had to be changed.
        method: Name of the method that chose the fingers.
    """

    tablature: Tablature
    left: np.ndarray
    right: np.ndarray
    barre: np.ndarray
    hold_position: np.ndarray
    release_s: np.ndarray
    strum: np.ndarray
    difficulty: np.ndarray
    problems: tuple[str, ...] = ()
    method: str = "paper"

    def marked(self) -> Tablature:
        """The tablature with these fingers as its marks."""
        notes = (
            replace(note, left_finger=int(left) if left >= 0 else None, right_finger=hand)
            for note, left, hand in zip(
                self.tablature.notes,
                self.left,
                (RIGHT_FINGERS[finger] for finger in self.right),
                strict=True,
            )
        )
        return replace(self.tablature, notes=tuple(notes))

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self, {"tablature": Tablature.to_json})

    @classmethod
    def load(cls, path: str | Path) -> Fingering:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        loaded = storage.load(path, cls, {"tablature": Tablature.from_json})
        return replace(loaded, problems=tuple(str(line) for line in loaded.problems))


def describe(note: Note) -> str:
    """A note's place in words, such as `bar 3, beat 2: string 5 fret 4`."""
    return f"bar {note.bar}, beat {note.beat:g}: string {note.string} fret {note.fret}"
