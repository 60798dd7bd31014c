"""What was heard, written down: the tablature of what a performance really played."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from roboguitarist.performance import DEAD, Performance
from roboguitarist.tablature import N_STRINGS, Note, Tablature, Technique, validate

LOUD_M_S = 0.6
"""Speed of a fingertip that is written as a forte."""
FORTE = 96
SHORTEST_S = 0.02


def heard(performance: Performance) -> Tablature:
    """The plucks of a performance as notes.

    A note lasts until its string is plucked again, sounds another fret by the left hand, or the
    recording ends. Its fret is the one that sounded, whatever was asked; a string that was
    touched but not pressed gives a dead note. Bars, tempi and texts are those that were asked.
    """
    asked = performance.tablature
    notes = []
    for k in range(len(performance.pluck_time_s)):
        onset_s = round(max(0.0, float(performance.pluck_time_s[k])), 6)
        string, fret = int(performance.pluck_string[k]), int(performance.pluck_fret[k])
        loud = FORTE * float(performance.pluck_speed_m_s[k]) / LOUD_M_S
        notes.append(
            Note(
                onset_s,
                string,
                0 if fret == DEAD else max(0, fret - asked.capo),
                round(max(SHORTEST_S, _end_s(performance, k) - onset_s), 6),
                techniques=(Technique.DEAD,) if fret == DEAD else (),
                right_finger="pima"[int(performance.pluck_finger[k])],
                velocity=min(127, max(1, round(loud))),
            )
        )
    in_order = {note.place[:2]: _in_bar(note, asked) for note in notes}
    return validate(replace(asked, notes=tuple(sorted(in_order.values(), key=lambda n: n.place))))


def _end_s(performance: Performance, pluck: int) -> float:
    """When a plucked note ends."""
    start_s = performance.pluck_time_s[pluck]
    string, fret = performance.pluck_string[pluck], performance.pluck_fret[pluck]
    assert 1 <= string <= N_STRINGS
    again = performance.pluck_time_s[performance.pluck_string == string]
    again = again[again > start_s]
    later = performance.time_s > start_s + 1 / performance.control_hz
    other = performance.time_s[later & (performance.sounding_fret[:, string - 1] != fret)]
    return float(min([*again[:1], *other[:1], performance.time_s[-1]]))


def _in_bar(note: Note, asked: Tablature) -> Note:
    """The note with the bar and the beat that it falls in."""
    starts_s = np.array([bar.onset_s for bar in asked.bars] or [0.0])
    k = max(0, int(np.searchsorted(starts_s, note.onset_s, side="right")) - 1)
    tempo = max((t for t in asked.tempi if t.onset_s <= note.onset_s), default=asked.tempi[0],
                key=lambda t: t.onset_s)  # fmt: skip
    beat = 1 + (note.onset_s - starts_s[k]) * tempo.quarters_per_minute / 60
    number = asked.bars[k].number if asked.bars else 1
    return replace(note, bar=number, beat=round(float(beat), 6))
