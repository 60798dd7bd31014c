"""Everything that the search needs to know of a piece's moments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.fingering.costs import KEEP
from roboguitarist.fingering.reach import Reach
from roboguitarist.fingering.result import SIMULTANEOUS_S
from roboguitarist.fingering.trellis import Forms, Moment, Stops, lay_out


@dataclass(frozen=True)
class Setting:
    """What the terms depend on beside forms and stops.

    Attributes:
        forms, stops: The whole piece.
        nut_fret: Fret of nut or capo if the hand must stand before it, else None.
        reach: What the hand can hold, if known.
        free: Strings are still to be chosen.
        step_s: (K, 2) time since the onset before, and since the one before that.
        margin_s: (K, 2) of these, the time in which the fingers may have left.
        open_strings: (K,) bits of the strings that ring open, string 1 the lowest; where strings
            are free, that may ring from before.
    """

    forms: Forms
    stops: Stops
    nut_fret: int | None
    reach: Reach | None
    free: bool
    step_s: np.ndarray
    margin_s: np.ndarray
    open_strings: np.ndarray


def setting(
    onsets: list[Moment], nut_fret: int | None, reach: Reach | None, free: bool = False
) -> Setting:
    """Everything that the search needs to know of these moments."""
    forms, stops = lay_out(onsets)
    begin_s = np.array([moment.onset_s for moment in onsets])
    end_s = np.array([max(moment.end_s) for moment in onsets])
    step_s = np.diff(begin_s, prepend=-np.inf)
    rest_s = step_s - KEEP * (np.minimum(np.roll(end_s, 1), begin_s) - np.roll(begin_s, 1))
    rest_s[:1] = np.inf
    step_s = np.column_stack([step_s, step_s + np.roll(step_s, 1)])
    margin_s = np.column_stack([rest_s, step_s[:, 0] + np.roll(rest_s, 1)])
    step_s[:1], margin_s[:2, 1] = np.inf, np.inf
    open_strings = _may_ring(onsets) if free else _ringing(onsets)
    return Setting(forms, stops, nut_fret, reach, free, step_s, margin_s, open_strings)


def _ringing(onsets: list[Moment]) -> np.ndarray:
    """Bits of the strings that ring open at each moment, those that begin then included."""
    until, result = [0.0] * 7, []
    for moment in onsets:
        (places, _) = moment.forms[0]
        for (string, fret), end_s in zip(places, moment.end_s, strict=True):
            until[string] = 0.0 if fret else end_s
        now_s = moment.onset_s + SIMULTANEOUS_S
        result.append(sum(1 << (s - 1) for s in range(1, 7) if until[s] > now_s))
    return np.array(result, int)


def _may_ring(onsets: list[Moment]) -> np.ndarray:
    """Bits of the strings that may ring open at each moment from notes before it."""
    until, result = [0.0] * 7, []
    for moment in onsets:
        now_s = moment.onset_s + SIMULTANEOUS_S
        result.append(sum(1 << (s - 1) for s in range(1, 7) if until[s] > now_s))
        for places, _ in moment.forms:
            ends = map(max, moment.end_s, moment.again_s)
            for (string, fret), end_s in zip(places, ends, strict=True):
                if string and not fret:
                    until[string] = max(until[string], end_s)
    return np.array(result, int)
