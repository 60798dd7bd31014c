"""Which pluck plays which note of the tablature, and what is wrong with the others."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.optimize import linear_sum_assignment

from roboguitarist.fingering import describe
from roboguitarist.performance import DEAD, PRESS_THRESHOLD_N, Performance
from roboguitarist.tablature import N_STRINGS, Note, Tablature

ONSET_TOLERANCE_S = 0.050
HOLD_FRACTION = 2 / 3
"""Share of its written length that a fretted note must be held."""
ROUNDING_S = 1e-6
"""Times in a tablature are whole microseconds, those of a performance are not."""
SEARCH_S = 0.250
"""A pluck this near to a missed note's onset is taken for that note, early or late."""


def match(performance: Performance, tablature: Tablature) -> np.ndarray:
    """Which pluck makes each note right.

    A pluck makes a note right if it is on the note's string within 50 ms of its onset, sounds
    the asked fret, and, when fretted, the fret is held from then on, at every tick, for 2/3 of
    the written length or until the string is plucked again. No pluck serves two notes: of all
    one-to-one assignments this takes the one with most right notes and, among these, the least
    sum of onset errors, so the result does not depend on an order of visit.

    Returns:
        (n,) int, index of the pluck, -1 for a note that is not right.
    """
    plucks = np.full(len(tablature.notes), -1)
    onset_s = np.array([note.onset_s for note in tablature.notes])
    duration_s = np.array([note.duration_s for note in tablature.notes])
    next_s = _next_pluck(performance)
    for (string, fret), notes in _by_place(tablature).items():
        same = (performance.pluck_string == string) & (performance.pluck_fret == fret)
        candidates = np.flatnonzero(same)
        time_s = performance.pluck_time_s[candidates]
        error_s = np.abs(time_s - onset_s[notes, None])
        due_s = np.minimum(time_s + HOLD_FRACTION * duration_s[notes, None], next_s[candidates])
        right = error_s <= ONSET_TOLERANCE_S + ROUNDING_S
        if fret > tablature.capo:
            right &= _held_until(performance, string, fret, time_s) >= due_s - ROUNDING_S
        rows, columns = linear_sum_assignment(np.where(right, error_s, 1e3))
        hit = right[rows, columns]
        plucks[notes[rows[hit]]] = candidates[columns[hit]]
    return plucks


def _by_place(tablature: Tablature) -> dict[tuple[int, int], np.ndarray]:
    """Indices of the notes on each (string, sounding fret counted from the nut)."""
    places: dict[tuple[int, int], list[int]] = {}
    for index, note in enumerate(tablature.notes):
        places.setdefault((note.string, note.fret + tablature.capo), []).append(index)
    return {place: np.array(indices) for place, indices in places.items()}


def _next_pluck(performance: Performance) -> np.ndarray:
    """(P,) time in seconds when each pluck's string is plucked again, inf if never."""
    again = np.full(performance.pluck_time_s.size, np.inf)
    for string in range(1, N_STRINGS + 1):
        indices = np.flatnonzero(performance.pluck_string == string)
        again[indices[:-1]] = performance.pluck_time_s[indices[1:]]
    return again


def _held_until(performance: Performance, string: int, fret: int, time_s: np.ndarray) -> np.ndarray:
    """First tick at or after each of `time_s` at which the fret is no longer pressed."""
    ticks, _, width = performance.press_force_n.shape
    lifted = np.arange(ticks)
    if fret <= width:
        force_n = performance.press_force_n[:, string - 1, fret - 1]
        lifted = np.flatnonzero(force_n < PRESS_THRESHOLD_N)
    end_s = performance.time_s[-1] + 1 / performance.control_hz if ticks else -np.inf
    lifted_s = np.append(performance.time_s[lifted], end_s)
    first = np.searchsorted(performance.time_s, time_s - ROUNDING_S)
    return lifted_s[np.searchsorted(lifted, first)]


class Cause(StrEnum):
    """Why a note is not right."""

    NOT_PLUCKED = "not plucked"
    EARLY = "too early"
    LATE = "too late"
    WRONG_FRET = "wrong fret"
    DEAD = "dead"
    NOT_HELD = "not held"


@dataclass(frozen=True, slots=True)
class Miss:
    """A note that is not right.

    Attributes:
        index: Index of the note in the tablature.
        note: The note.
        cause: What went wrong.
        detail: The same in words, with the figure that matters.
        pluck: Index of the pluck that went wrong, if there was one.
    """

    index: int
    note: Note
    cause: Cause
    detail: str
    pluck: int | None = None

    def __str__(self) -> str:
        """One line with bar, beat, string, fret and what went wrong."""
        return f"{describe(self.note)}: {self.detail}"


def misses(performance: Performance, tablature: Tablature | None = None) -> tuple[Miss, ...]:
    """Every note that is not right, in order of the tablature, with its cause.

    Each is blamed on the nearest pluck of its string that made no note right: first within
    50 ms, then, as early or late, within `SEARCH_S`. No pluck is blamed twice.
    """
    tablature = tablature or performance.tablature
    matched = match(performance, tablature)
    spare = set(range(performance.pluck_time_s.size)) - set(matched.tolist())
    found: dict[int, Miss] = {}
    for limit_s in (ONSET_TOLERANCE_S + ROUNDING_S, SEARCH_S):
        for index in np.flatnonzero(matched < 0).tolist():
            asked = tablature.notes[index]
            near = [
                (abs(performance.pluck_time_s[pluck] - asked.onset_s), pluck)
                for pluck in spare
                if performance.pluck_string[pluck] == asked.string
            ]
            if index not in found and near and min(near)[0] <= limit_s:
                spare.remove(pluck := min(near)[1])
                cause, detail = _blame(performance, tablature, asked, pluck)
                found[index] = Miss(index, asked, cause, detail, pluck)
    for index in np.flatnonzero(matched < 0).tolist():
        silent = Miss(index, tablature.notes[index], Cause.NOT_PLUCKED, Cause.NOT_PLUCKED.value)
        found.setdefault(index, silent)
    return tuple(found[index] for index in sorted(found))


def _blame(
    performance: Performance, tablature: Tablature, asked: Note, pluck: int
) -> tuple[Cause, str]:
    time_s, fret = performance.pluck_time_s[pluck], int(performance.pluck_fret[pluck])
    late_s = time_s - asked.onset_s
    if abs(late_s) > ONSET_TOLERANCE_S + ROUNDING_S:
        cause = Cause.LATE if late_s > 0 else Cause.EARLY
        return cause, f"plucked {1e3 * abs(late_s):.0f} ms {cause.value}"
    if fret == DEAD:
        return Cause.DEAD, "touched but not pressed, so it does not sound"
    if fret != asked.fret + tablature.capo:
        return Cause.WRONG_FRET, f"sounded fret {fret - tablature.capo}"
    until_s = _held_until(performance, asked.string, fret, np.array([time_s]))[0]
    share = max(0.0, until_s - time_s) / asked.duration_s
    return Cause.NOT_HELD, f"held for {share:.0%} of its length"
