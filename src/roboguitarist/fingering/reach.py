"""What the simulated hand can hold, as measured in physics."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError

NEEDED_N = 2.0
"""Force that a finger should be able to hold: twice what makes a string sound."""


@dataclass(frozen=True)
class Reach:
    """Forces and chord shapes that a hand can hold.

    Attributes:
        held_n: (4, 6, n_frets) largest force in N that fingers 1 to 4 hold on strings 1 to 6,
            at frets from 1.
        unheld: Shapes, each a set of (finger, string, fret), in which some string does not sound.
    """

    held_n: np.ndarray
    unheld: frozenset[frozenset[tuple[int, int, int]]] = frozenset()

    def missing(self, finger: np.ndarray, string: np.ndarray, fret: np.ndarray) -> np.ndarray:
        """Sum (n,) of the shares of force missing in forms; 1 more for an unheld shape.

        Args:
            finger: (n, 6), below 1 where none stops a note.
            string: (n, 6).
            fret: (n, 6).
        """
        inside = (finger > 0) & (fret > 0) & (fret <= self.held_n.shape[2])
        force = self.held_n[
            np.maximum(finger, 1) - 1,
            np.maximum(string, 1) - 1,
            np.clip(fret, 1, self.held_n.shape[2]) - 1,
        ]
        share = np.where(inside, force, 0.0) / NEEDED_N
        result = np.where(finger > 0, np.clip(1.0 - share, 0.0, 1.0), 0.0).sum(axis=1)
        if self.unheld:
            for row in range(len(finger)):
                pressed = zip(finger[row], string[row], fret[row], strict=True)
                shape = frozenset((int(f), int(s), int(n)) for f, s, n in pressed if f > 0)
                result[row] += shape in self.unheld
        return result

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file: the forces, and (K, 6, 2) finger and fret of unheld shapes."""
        shapes = np.zeros((len(self.unheld), 6, 2), np.int8)
        for shape, places in zip(shapes, sorted(map(sorted, self.unheld)), strict=True):
            for finger, string, fret in places:
                shape[string - 1] = finger, fret
        with storage.replacing(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, held_n=self.held_n.astype(np.float32), unheld=shapes)

    @classmethod
    def load(cls, path: str | Path) -> Reach:
        """Read what `save` wrote; nothing in the file is executed.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        try:
            with np.load(path, allow_pickle=False) as arrays:
                held_n, shapes = arrays["held_n"], arrays["unheld"]
        except (OSError, ValueError, KeyError) as error:
            raise RoboGuitaristError(f"{path}: not a map of reach ({error})") from error
        unheld = (
            frozenset(
                (int(finger), string, int(fret))
                for string, (finger, fret) in enumerate(shape, 1)
                if finger
            )
            for shape in shapes
        )
        return cls(held_n, frozenset(unheld))


def measured(variant: str) -> Reach:
    """What a hand variant held in physics, as `benchmarks/reach.py` found it.

    Raises:
        RoboGuitaristError: If it was not measured.
    """
    with resources.as_file(resources.files("roboguitarist.fingering")) as folder:
        return Reach.load(folder / f"reach-{variant}.npz")
