"""How far each string is seen to swing after a pluck."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from roboguitarist.guitar import STRINGS
from roboguitarist.performance import DEAD, Performance
from roboguitarist.sound.damping import LN_60_DB
from roboguitarist.sound.events import NO_PLUCK, Event, string_events
from roboguitarist.sound.strings import strength
from roboguitarist.sound.voices import tone

WIDEST_M = 0.0022
"""Half the width of the swing after the strongest pluck, wider than real to be seen from afar."""
DEAD_DECAY_S = 0.08


@dataclass(frozen=True, slots=True)
class Ring:
    """One string swinging from a pluck to what stops it.

    Attributes:
        start_s, end_s: In seconds from the start of the piece.
        string: 1 to 6.
        fret: The fret that stops the string, counted from the nut; 0 for the open string.
        width_m: Half the width of the swing at the start.
        decay_s: Time in which it loses 60 dB.
    """

    start_s: float
    end_s: float
    string: int
    fret: int
    width_m: float
    decay_s: float

    def width_at(self, time_s: float) -> float:
        """Half the width of the swing in metres at a time; 0 before and after."""
        if not self.start_s <= time_s < self.end_s:
            return 0.0
        return self.width_m * float(np.exp(-LN_60_DB * (time_s - self.start_s) / self.decay_s))


def rings(performance: Performance) -> tuple[Ring, ...]:
    """What swings during a performance, in order of time."""
    found = []
    for string in STRINGS.tolist():
        events = [*string_events(performance, string), Event(np.inf, DEAD)]
        for event, following in pairwise(events):
            if event.pluck != NO_PLUCK:
                found.append(_ring(performance, string, event, following))
    return tuple(sorted(found, key=lambda ring: (ring.start_s, ring.string)))


def _ring(performance: Performance, string: int, event: Event, following: Event) -> Ring:
    dead = event.fret == DEAD
    fret = 0 if dead else int(event.fret)
    fades_s = DEAD_DECAY_S if dead else tone(performance, string, fret).decay_s()
    end_s = min(following.time_s, event.time_s + fades_s)
    width = WIDEST_M * strength(float(performance.pluck_speed_m_s[event.pluck]))
    return Ring(event.time_s, end_s, string, fret, width, fades_s)
