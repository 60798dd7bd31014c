"""What makes a fingering hard: the terms that the search adds up, and their weights."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

FRET_M = 0.029
"""Distance of two frets in the fifth position of a 65 cm scale. All distances are reckoned with
it, so that a passage keeps its fingers wherever it lies on the neck."""
STRING_GAP_M = 0.009
JUMP_S, JUMP_S_M = 0.07, 1.12
"""A finger needs this time from one place to another, plus so much for every metre."""
SHIFT_S, SHIFT_S_M = 0.06, 1.12
"""The same for the hand: 10 cm take it about 0.17 s."""
RING_S, RING_MOMENTS = 1.5, 6
"""A finger that nothing calls away stays so long on its note, and over so many onsets at most, so
that the note rings on."""
FRESH_S = 0.5
"""That long after its note a finger is as free as any."""
KEEP, LEAST = 0.68, 2 / 3
"""Share of a note for which its finger stays by itself, and for which it must."""


@dataclass(frozen=True)
class Costs:
    """Weights of the terms, each at least 0; the costs of a piece are their weighted sum.

    Attributes:
        index: For every form that uses the index finger.
        middle: The same for the middle finger.
        ring: The same for the ring finger.
        little: The same for the little finger.
        stretch: For each fret by which the index finger and another are farther apart than their
            numbers are, while both are down.
        spread: The same for two other fingers.
        squeeze: For each fret by which two fingers are nearer than their numbers are.
        crossed: Two fingers on one fret, the lower-numbered one on the higher-pitched string.
        tight: Two fingertips on one fret of neighbouring strings.
        barre: A finger lies flat.
        barre_strings: For each string under it.
        flattened: The index finger that holds a note is laid flat for another.
        nut: For each fret that the hand stands behind the first position, in a piece with open
            strings.
        away: For each fret that it stands beyond the first position, in a piece with open
            strings.
        nudge: The hand moves by one fret.
        shift: The hand moves by two frets or more.
        distance: For each fret of such a shift.
        speed: For each metre per second of a nudge or shift.
        free: For each fret of a move that an open string leaves time for; the last four do not
            count then.
        hurried: Share of the time for a shift that is missing.
        guide: A finger moves along its string by three frets or more.
        slide: It moves by one fret or two, where its neighbour could have stepped in.
        hop: A finger moves to another string on the same fret.
        jump: It moves to another string and fret.
        rushed: Share of the time for a hop or jump that is missing.
        changed: A place just stopped by one finger is stopped by another.
        cut: Share of a note that is missing since it is let go early.
        lost: A note is let go before two thirds of it.
        replanted: A finger leaves a place that it will need again soon.
        lifted: A finger leaves a place that could ring on.
        left_out: A note that no finger stops.
        stopped: For every stopped note, where strings are free.
        height: For each fret up the neck of a stopped note, where strings are free.
        silenced: A ringing open string is taken for another note, where strings are free.
        unheld: Share of the force missing where this hand presses less than it must.
    """

    index: float = 0.0
    middle: float = 0.1
    ring: float = 0.3
    little: float = 0.5
    stretch: float = 1.0
    spread: float = 1.0
    squeeze: float = 0.5
    crossed: float = 2.0
    tight: float = 0.2
    barre: float = 1.0
    barre_strings: float = 0.2
    flattened: float = 1.4
    nut: float = 2.0
    away: float = 0.1
    nudge: float = 0.8
    shift: float = 1.0
    distance: float = 0.3
    speed: float = 0.3
    free: float = 0.3
    hurried: float = 3.0
    guide: float = 0.3
    slide: float = 1.0
    hop: float = 0.8
    jump: float = 1.5
    rushed: float = 3.0
    changed: float = 1.5
    cut: float = 2.0
    lost: float = 5.0
    replanted: float = 1.0
    lifted: float = 0.3
    left_out: float = 100.0
    stopped: float = 0.3
    height: float = 0.15
    silenced: float = 2.5
    unheld: float = 20.0

    def total(self, terms: Terms) -> np.ndarray:
        """Weighted sum of the terms, on a grid of 1/1024 so that sums of costs are exact."""
        costs = sum(getattr(self, name) * values for name, values in terms.items())
        return np.rint(np.multiply(costs, GRID)) / GRID


GRID = 1024.0
Terms = dict[str, np.ndarray]
"""Values of some of the terms of `Costs`, by name, in arrays of one shape."""
NAMES = tuple(entry.name for entry in fields(Costs))

HUMAN = Costs(
    stretch=0.954,
    spread=1.24,
    squeeze=0.0,
    crossed=2.576,
    tight=0.0,
    barre=0.643,
    barre_strings=0.0,
    flattened=1.348,
    nut=0.315,
    away=0.091,
    shift=0.956,
    distance=0.276,
    free=0.436,
    guide=0.156,
    slide=0.676,
    hop=1.083,
    jump=1.593,
    changed=0.895,
    replanted=1.698,
    lifted=0.296,
)
"""A guitarist's hand: learned from the fingers that editors wrote (benchmarks/editors.py)."""
ROBOT = replace(HUMAN, tight=0.5, squeeze=0.1, nudge=1.2, slide=1.2, hop=2.0, jump=2.0)
"""The simulated hand's. Its fingertips are 13 mm wide, so that two on one fret of neighbouring
strings push each other aside; a finger that goes elsewhere comes late; and its arm is heavier than
a finger, so that it had better stand still."""
HANDS = {"human": HUMAN, "robot": ROBOT}
"""Weights by hand."""
