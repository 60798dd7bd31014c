"""What happens to one string during a performance: plucks and changes of the sounding fret."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from roboguitarist.performance import DEAD, PRESS_THRESHOLD_N, Performance

NO_PLUCK = -1


class Move(StrEnum):
    """What the left hand does to a string that rings."""

    DAMP = "damp"
    """It lets go of a fret or touches the string: the ringing stops."""
    HAMMER_ON = "hammer-on"
    """A finger comes down behind a higher fret while another holds the lower one."""
    PULL_OFF = "pull-off"
    """A finger leaves a fret, and another holds a lower one."""
    SLIDE = "slide"
    """The finger goes to another fret, or a finger stops an open string."""


@dataclass(frozen=True, slots=True)
class Event:
    """From `time_s` on the string sounds at `fret`.

    Attributes:
        time_s: When, at least 0.
        fret: Fret counted from the nut, or `DEAD`.
        pluck: Index of the pluck in the performance, or `NO_PLUCK` if only the left hand moved.
        move: What the left hand does, if the string is not plucked.
    """

    time_s: float
    fret: int
    pluck: int = NO_PLUCK
    move: Move | None = None


def string_events(performance: Performance, string: int) -> list[Event]:
    """Events on a string (1 to 6) in order of time.

    What a pluck sounded is taken from the pluck; between plucks the sounding fret of the control
    ticks counts.
    """
    frets = performance.sounding_fret[:, string - 1]
    moments = [
        (float(t), NO_PLUCK, int(f), tick)
        for tick, (t, f) in enumerate(zip(performance.time_s, frets, strict=True))
    ]
    for pluck in np.flatnonzero(performance.pluck_string == string).tolist():
        time_s, fret = performance.pluck_time_s[pluck], performance.pluck_fret[pluck]
        moments.append((float(time_s), pluck, int(fret), -1))
    events, sounding = [], DEAD
    for time_s, pluck, fret, tick in sorted(moments):
        if pluck != NO_PLUCK:
            events.append(Event(max(time_s, 0.0), fret, pluck))
        elif fret != sounding:
            move = _move(performance, string, (sounding, fret), tick)
            events.append(Event(max(time_s, 0.0), fret, move=move))
        sounding = fret
    return events


def _move(performance: Performance, string: int, frets: tuple[int, int], tick: int) -> Move:
    """What happened at a tick at which a string changed from one fret to another."""
    before, after = frets
    if after <= performance.tablature.capo:
        return Move.DAMP
    if after > before and _presses(performance, string, before, tick):
        return Move.HAMMER_ON
    if after < before and _presses(performance, string, after, tick - 1):
        return Move.PULL_OFF
    return Move.SLIDE


def _presses(performance: Performance, string: int, fret: int, tick: int) -> bool:
    force_n = performance.press_force_n
    if fret < 1 or tick < 0 or fret > force_n.shape[2]:
        return False
    return bool(force_n[tick, string - 1, fret - 1] >= PRESS_THRESHOLD_N)
