"""What happens to one string during a performance: plucks and changes of the sounding fret."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.performance import DEAD, Performance

NO_PLUCK = -1


@dataclass(frozen=True, slots=True)
class Event:
    """From `time_s` on the string sounds at `fret`.

    Attributes:
        time_s: When, at least 0.
        fret: Fret counted from the nut, or `DEAD`.
        pluck: Index of the pluck in the performance, or `NO_PLUCK` if only the left hand moved.
        damps: The left hand damps the string: it lets go of a fret or touches the string.
    """

    time_s: float
    fret: int
    pluck: int = NO_PLUCK
    damps: bool = False


def string_events(performance: Performance, string: int) -> list[Event]:
    """Events on a string (1 to 6) in order of time.

    What a pluck sounded is taken from the pluck; between plucks the sounding fret of the control
    ticks counts.
    """
    open_fret = performance.tablature.capo
    frets = performance.sounding_fret[:, string - 1]
    moments = [(float(t), NO_PLUCK, int(f)) for t, f in zip(performance.time_s, frets, strict=True)]
    for pluck in np.flatnonzero(performance.pluck_string == string):
        time_s, fret = performance.pluck_time_s[pluck], performance.pluck_fret[pluck]
        moments.append((float(time_s), int(pluck), int(fret)))
    events, sounding = [], DEAD
    for time_s, pluck, fret in sorted(moments):
        if pluck != NO_PLUCK or fret != sounding:
            damps = pluck == NO_PLUCK and fret <= open_fret
            events.append(Event(max(time_s, 0.0), fret, pluck, damps))
        sounding = fret
    return events
