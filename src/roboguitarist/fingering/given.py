"""The search where strings and frets are given: what each onset offers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from roboguitarist.fingering.grips import grips
from roboguitarist.fingering.onsets import chords, excluded, released
from roboguitarist.fingering.trellis import Moment
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Tablature

SOON_S = 2.0
"""A finger had better stay where it is needed again within this time."""


def moments(tablature: Tablature, guitar: Guitar) -> list[Moment]:
    """Every onset with the grips that its notes allow."""
    frets = range(tablature.capo + 1, guitar.n_frets + 1)
    end_s, result = released(tablature), []
    again_s = recurrences([(n.onset_s, n.string, n.fret) for n in tablature.notes])
    for chord in chords(tablature.notes):
        left_out = excluded(tablature, chord, frets)
        kept = tuple(index for index in chord if index not in left_out)
        if not kept:
            continue
        notes = [tablature.notes[index] for index in kept]
        places = tuple((note.string, tablature.stopped_fret(note)) for note in notes)
        marks = tuple(note.left_finger or None if note.fret else None for note in notes)
        forms = [(places, grip) for grip in grips(places, marks)]
        ends = tuple(end_s[index] for index in kept)
        result.append(
            Moment(notes[0].onset_s, kept, ends, tuple(again_s[index] for index in kept), forms)
        )
    return result


def recurrences(events: Sequence[tuple[float, int, int]]) -> list[float]:
    """When the same fret of the same string comes next, if soon and no other fret comes first.

    Args:
        events: Onset in seconds, string, fret; in order of time.

    Returns:
        The time for each event, 0 where it does not come.
    """
    result, following = [0.0] * len(events), {}
    for k in range(len(events) - 1, -1, -1):
        onset_s, string, fret = events[k]
        next_s, next_fret = following.get(string, (np.inf, -1))
        if next_fret == fret and next_s - onset_s <= SOON_S:
            result[k] = next_s
        following[string] = onset_s, fret
    return result
