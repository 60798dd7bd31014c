"""What of a tablature both ways of fingering go by: chords, releases, and what cannot be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from roboguitarist.fingering.result import SIMULTANEOUS_S
from roboguitarist.tablature import Note, Tablature


def chords(notes: Sequence[Note]) -> Iterator[list[int]]:
    """Indices of the notes that start together, in order of time."""
    chord: list[int] = []
    for index, note in enumerate(notes):
        if chord and note.onset_s - notes[chord[0]].onset_s > SIMULTANEOUS_S:
            yield chord
            chord = []
        chord.append(index)
    if chord:
        yield chord


def released(tablature: Tablature) -> list[float]:
    """When each note lets go of its finger: at its end, or when its string plays on."""
    result, next_onset = [], {}
    for note in reversed(tablature.notes):
        result.append(min(note.end_s, next_onset.get(note.string, np.inf)))
        next_onset[note.string] = note.onset_s
    return result[::-1]


def excluded(tablature: Tablature, chord: list[int], frets: range) -> dict[int, str]:
    """Notes of a chord that no hand could stop, each with the reason."""
    result, taken = {}, set()
    for index in reversed(chord):  # the highest fret of a string comes last, and is what sounds
        note = tablature.notes[index]
        fret = tablature.stopped_fret(note)
        if note.string in taken:
            result[index] = "the string has another note at this moment"
        elif fret and fret not in frets:
            result[index] = f"the guitar has {frets.stop - 1} frets"
        else:
            taken.add(note.string)
    return result
