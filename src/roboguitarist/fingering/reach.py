"""What the simulated hand can hold, as measured in physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
