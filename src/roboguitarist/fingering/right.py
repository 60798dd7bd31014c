"""The right hand: p on strings 6 to 4, i, m, a on 3, 2, 1, and what fast notes make of that.

The paper's rule is the base. Notes that follow each other faster than a finger recovers go to
different fingers, and a note repeated on its string alternates. Of all ways the cheapest is found.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product

import numpy as np

from roboguitarist.fingering.onsets import chords
from roboguitarist.fingering.result import RIGHT_FINGERS, SIMULTANEOUS_S
from roboguitarist.tablature import Note, Tablature, Technique

THUMB = 0
STRUMS = (Technique.STRUM_DOWN, Technique.STRUM_UP)
RULE = (0, 3, 2, 1, 0, 0, 0)
"""Finger of each string; the first is unused."""
STRUM_S = 0.06
"""Four or more strings within this time are a strum."""
RECOVERY_S, THUMB_RECOVERY_S = 0.12, 0.15
"""Time that a finger needs between two strokes, and the thumb if it changes strings: measured
with the simulated hand, where faster thumbs miss."""
REPEAT_S = 0.25
"""Notes repeated on one string at least this fast alternate."""
MARKED, RUSHED, TOGETHER, AWAY, REPEATED = 100.0, 10.0, 4.0, 1.0, 1.2
"""Costs: a mark not kept; a finger used again too soon; the thumb on two strings at once; a
finger one string from its own; a fast repeated note with the same finger."""

Fingers = Strings = tuple[int, ...]


def by_string(tablature: Tablature) -> np.ndarray:
    """Right fingers (n,): p on strings 6 to 4, i, m, a on 3, 2, 1, or as marked."""
    rule = np.array([-1, 3, 2, 1, 0, 0, 0], np.int8)
    right = rule[[note.string for note in tablature.notes]]
    for chord in chords(tablature.notes):
        notes = [tablature.notes[index] for index in chord]
        marks = [str(note.right_finger) for note in notes]
        wish = [
            RIGHT_FINGERS.index(m) if m in RIGHT_FINGERS else int(f)
            for m, f in zip(marks, right[chord], strict=True)
        ]
        treble = [f for f, note in zip(wish, notes, strict=True) if note.string <= 3]
        bass = [f for f, note in zip(wish, notes, strict=True) if note.string > 3]
        in_order = all(a > b for a, b in pairwise(treble))
        if in_order and not any(bass) and all(treble):
            right[chord] = wish
    return right


def right_hand(tablature: Tablature) -> tuple[np.ndarray, np.ndarray]:
    """Right fingers (n,) of all notes, and strums (n,): 1 down, -1 up, 0 none."""
    notes = tablature.notes
    right, strum = np.zeros(len(notes), np.int8), np.zeros(len(notes), np.int8)
    for group in _strums(notes):
        strum[group] = _direction([notes[index] for index in group])
    groups = [sorted(chord, key=lambda k: -notes[k].string) for chord in chords(notes)]
    options = [_options([notes[index] for index in g], bool(strum[g].any())) for g in groups]
    for group, fingers in zip(groups, _cheapest(notes, groups, options), strict=True):
        right[group] = fingers
    return right, strum


def _strums(notes: Sequence[Note]) -> list[list[int]]:
    """Groups of notes that are strummed."""
    groups: list[list[int]] = []
    for index, note in enumerate(notes):
        last = groups[-1] if groups else []
        fresh = note.string not in {notes[k].string for k in last}
        if last and fresh and note.onset_s - notes[last[0]].onset_s <= STRUM_S:
            last.append(index)
        else:
            groups.append([index])
    return [g for g in groups if len(g) >= 4 or _marked(notes[k] for k in g)]


def _marked(notes: Iterable[Note]) -> bool:
    return any(mark in note.techniques for note in notes for mark in STRUMS)


def _direction(notes: Sequence[Note]) -> int:
    """1 towards string 1, -1 towards string 6: as marked, or as the strings follow."""
    if _marked(notes):
        return -1 if any(Technique.STRUM_UP in note.techniques for note in notes) else 1
    return 1 if notes[-1].string <= notes[0].string or _at_once(notes) else -1


def _at_once(notes: Sequence[Note]) -> bool:
    return notes[-1].onset_s - notes[0].onset_s <= SIMULTANEOUS_S


@dataclass(frozen=True)
class _Options:
    """Ways to pluck the strings of one onset, from the bass up, each with its cost."""

    strings: tuple[int, ...]
    fingers: tuple[Fingers, ...]
    cost: np.ndarray


def _options(notes: Sequence[Note], strum: bool) -> _Options:
    marks = tuple(
        RIGHT_FINGERS.index(n.right_finger) if n.right_finger in RIGHT_FINGERS else None
        for n in notes
    )
    return _ways(tuple(note.string for note in notes), marks, strum)


@lru_cache(maxsize=1 << 14)
def _ways(strings: tuple[int, ...], marks: tuple[int | None, ...], strum: bool) -> _Options:
    """All ways in which fingers do not cross, and only the thumb plays more than one string."""
    wish = tuple(RULE[s] if m is None else m for s, m in zip(strings, marks, strict=True))
    found = [wish] if strum and _in_order(wish) else []
    found = found or [way for way in product(range(4), repeat=len(strings)) if _in_order(way)]
    return _Options(strings, tuple(found), np.array([_alone(w, strings, marks) for w in found]))


def _in_order(way: Fingers) -> bool:
    return all(a < b or a == b == THUMB for a, b in pairwise(way))


def _alone(way: Fingers, strings: tuple[int, ...], marks: tuple[int | None, ...]) -> float:
    own = (4, 3, 2, 1)
    cost = TOGETHER * max(way.count(THUMB) - 1, 0)
    for finger, string, mark in zip(way, strings, marks, strict=True):
        away = abs(own[finger] - string)
        if finger == THUMB:
            away = 2 * max(own[finger] - string, 0)
        cost += AWAY * away**2 + MARKED * (mark not in (None, finger))
    return cost


@lru_cache(maxsize=1 << 14)
def _following(
    before: tuple[int, ...],
    ways: tuple[Fingers, ...],
    after: tuple[int, ...],
    then: tuple[Fingers, ...],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fingers, thumbs that change strings, and single repeated strings that two ways share."""
    shared, moved, same = (np.zeros((len(ways), len(then))) for _ in range(3))
    for (i, first), (j, second) in product(enumerate(ways), enumerate(then)):
        common = {*first} & {*second}
        shared[i, j] = bool(common)
        thumbs = [
            [s for s, f in zip(strings, way, strict=True) if f == THUMB]
            for strings, way in ((before, first), (after, second))
        ]
        moved[i, j] = THUMB in common and thumbs[0] != thumbs[1]
        same[i, j] = len(before) == 1 and before == after and first == second != (THUMB,)
    return shared, moved, same


def _cheapest(
    notes: Sequence[Note], groups: Sequence[list[int]], options: Sequence[_Options]
) -> list[Fingers]:
    """The way of least cost through all onsets, by dynamic programming."""
    if not options:
        return []
    value, origins = options[0].cost, []
    for (here, now), (there, then) in pairwise(zip(groups, options, strict=True)):
        gap_s = notes[there[0]].onset_s - notes[here[0]].onset_s
        shared, moved, same = _following(now.strings, now.fingers, then.strings, then.fingers)
        step = RUSHED * shared * max(0.0, 1.0 - gap_s / RECOVERY_S)
        step = step + RUSHED * moved * max(0.0, 1.0 - gap_s / THUMB_RECOVERY_S)
        total = value[:, None] + step + REPEATED * same * (gap_s < REPEAT_S) + then.cost
        origins.append(total.argmin(axis=0))
        value = total.min(axis=0)
    chosen = [int(value.argmin())]
    for origin in reversed(origins):
        chosen.append(int(origin[chosen[-1]]))
    return [o.fingers[k] for o, k in zip(options, reversed(chosen), strict=True)]
