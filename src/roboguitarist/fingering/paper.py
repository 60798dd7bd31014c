"""The paper's way to choose fingers: onset by onset, without looking ahead."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, permutations, product

import numpy as np

from roboguitarist.fingering.onsets import chords, excluded, released
from roboguitarist.fingering.result import (
    SIMULTANEOUS_S,
    UNPLAYABLE,
    Fingering,
    describe,
)
from roboguitarist.fingering.right import by_string
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Note, Tablature

REACH_FRETS, STRETCH_FRETS = 1, 2
"""How far from its own fret (index P, middle P + 1, ...) a finger stops a string, and at most."""


@dataclass(frozen=True, slots=True)
class _Stop:
    """A place that one finger stops: a fret on one string, or on several under a barre."""

    notes: tuple[int, ...]
    fret: int
    strings: tuple[int, ...]
    until_s: float
    mark: int | None

    @property
    def place(self) -> tuple[int, tuple[int, ...]]:
        return self.fret, self.strings


@dataclass(frozen=True, slots=True)
class _Hand:
    """The left hand at one onset: where it stands and what its fingers do."""

    position: int
    frets: range
    held: dict[int, _Stop]
    resting: dict[tuple[int, tuple[int, ...]], int]
    """Fingers that have just stopped a place and are free, by place."""

    @classmethod
    def at(cls, onset_s: float, position: int, frets: range, last: dict[int, _Stop]) -> _Hand:
        late, early = onset_s + SIMULTANEOUS_S, onset_s - SIMULTANEOUS_S
        held = {finger: stop for finger, stop in last.items() if stop.until_s > late}
        resting = {s.place: finger for finger, s in last.items() if early < s.until_s <= late}
        return cls(position, frets, held, resting)


def paper(tablature: Tablature, guitar: Guitar) -> Fingering:
    """Fingers by the rules of section 4 of "Learning to Play Guitar with Robotic Hands".

    - A finger is busy until the end of its note, or until another note on the same string ends
      that one.
    - The hand stands at hold position P, its fingers at the frets P to P + 3. A note goes to
      the free finger nearest to its fret. All notes of one onset are decided together, by
      trying every assignment.
    - Fingers do not cross: a higher fret never has a lower-numbered finger, and on one fret the
      lower-numbered finger takes the lower-pitched string.

    The paper leaves open how P moves. Here it starts at the nut (or capo), or at the lowest fret
    of the opening notes if these do not lie within the first four; from there it shifts as
    little as brings the stopped frets into P to P + 3. All fingers in use stay within
    `REACH_FRETS` of their own frets, so a held note also holds the hand. Where that leaves a note
    out, the index finger lies flat across the lowest fret of the onset (barre), or fingers
    stretch by `STRETCH_FRETS`. A finger that has just stopped a string and fret plays it again.
    Left fingers marked in the score are kept where a free finger can do what they say; right
    fingers where p stays on strings 6 to 4, and i, m, a on 3 to 1 in this order.
    """
    count = len(tablature.notes)
    left, barre = np.zeros(count, np.int8), np.zeros(count, bool)
    hold_position = np.ones(count, np.int8)
    problems: list[str] = []
    released_s = released(tablature)
    frets = range(tablature.capo + 1, guitar.n_frets + 1)
    position, last = _opening_position(tablature, frets), {}
    for chord in chords(tablature.notes):
        left_out = excluded(tablature, chord, frets)
        kept = [index for index in chord if index not in left_out]
        hand = _Hand.at(tablature.notes[chord[0]].onset_s, position, frets, last)
        fingers, position = _finger(tablature, _stops(tablature, kept, released_s), kept, hand)
        for finger, stop in fingers.items():
            left[list(stop.notes)] = finger
            barre[list(stop.notes)] = len(stop.strings) > 1
        hold_position[chord] = position
        last |= fingers
        for index in chord:
            note = tablature.notes[index]
            if index in left_out or (note.fret and not left[index]):
                left[index] = UNPLAYABLE
            reason = left_out.get(index) or _complaint(note, int(left[index]), hand.held | fingers)
            if reason:
                problems.append(f"{describe(note)}: {reason}")
    return Fingering(
        tablature,
        left,
        by_string(tablature),
        barre,
        hold_position,
        release_s=np.array(released_s, float),
        strum=np.zeros(count, np.int8),
        difficulty=np.zeros(count, np.float32),
        problems=tuple(problems),
        method="paper",
    )


def _opening_position(tablature: Tablature, frets: range) -> int:
    """First position if the opening lies in it, else that of the opening's lowest fret."""
    opening: set[int] = set()
    for note in tablature.notes:
        fret = tablature.stopped_fret(note)
        if fret in frets:
            if opening and max(opening | {fret}) - min(opening | {fret}) > 3:
                break
            opening.add(fret)
    return min(opening) if opening and max(opening) > frets.start + 3 else frets.start


def _stops(tablature: Tablature, chord: list[int], released_s: list[float]) -> list[_Stop]:
    """Places to stop: a note each, or several of one fret that the score marks for one finger."""
    groups: dict[tuple[int, int], list[int]] = {}
    for index in chord:
        note = tablature.notes[index]
        if note.fret:
            key = note.left_finger if note.left_finger else -note.string
            groups.setdefault((note.fret, key), []).append(index)
    return [_stop(tablature, tuple(group), released_s) for group in groups.values()]


def _stop(tablature: Tablature, indices: tuple[int, ...], released_s: list[float]) -> _Stop:
    notes = [tablature.notes[index] for index in indices]
    fret, mark = tablature.stopped_fret(notes[0]), notes[0].left_finger
    until_s = max(released_s[index] for index in indices)
    return _Stop(indices, fret, tuple(n.string for n in notes), until_s, mark or None)


Choice = tuple[dict[int, _Stop], int]
"""The stop of each finger newly in use, and the hold position."""


def _finger(tablature: Tablature, stops: list[_Stop], chord: list[int], hand: _Hand) -> Choice:
    """The assignment that stops most notes: with easy reach, else a barre, else a stretch."""
    open_strings = [tablature.notes[i].string for i in chord if not tablature.notes[i].fret]
    shapes = [stops, flat] if (flat := _flattened(stops, open_strings)) else [stops]
    best: Choice = {}, hand.position
    for reach, shape in product((REACH_FRETS, STRETCH_FRETS), shapes):
        if _stopped(best) == sum(len(stop.notes) for stop in stops):
            break
        best = max(best, _search(shape, hand, reach), key=_stopped)
    return best


def _stopped(choice: Choice) -> int:
    return sum(len(stop.notes) for stop in choice[0].values())


def _flattened(stops: list[_Stop], open_strings: list[int]) -> list[_Stop] | None:
    """The stops with the lowest fret's under one index finger, unless an open string is there."""
    fret = min((stop.fret for stop in stops), default=0)
    low = [stop for stop in stops if stop.fret == fret]
    strings = tuple(string for stop in low for string in stop.strings)
    if len(low) < 2 or any(min(strings) < string < max(strings) for string in open_strings):
        return None
    indices = tuple(index for stop in low for index in stop.notes)
    flat = _Stop(indices, fret, strings, max(stop.until_s for stop in low), 1)
    return [flat, *(stop for stop in stops if stop.fret > fret)]


def _search(stops: list[_Stop], hand: _Hand, reach: int) -> Choice:
    """The best of all ways to give the free fingers to as many stops as can be."""
    free = [finger for finger in (1, 2, 3, 4) if finger not in hand.held]
    for size in range(min(len(stops), len(free)), 0, -1):
        rated = [
            (cost, fingers, chosen)
            for chosen in combinations(stops, size)
            for fingers in permutations(free, size)
            if (cost := _cost(dict(zip(fingers, chosen, strict=True)), hand, reach))
        ]
        if rated:
            cost, fingers, chosen = min(rated, key=lambda item: item[:2])
            return dict(zip(fingers, chosen, strict=True)), cost[-1]
    return {}, hand.position


def _cost(given: dict[int, _Stop], hand: _Hand, reach: int) -> tuple[int, ...] | None:
    """What an assignment costs, weightiest first, ending with its hold position P.

    Returns:
        Marks not kept, crossings, fingers changed on a place, frets outside P to P + 3, shift
        of P, the paper's sum of |P_i - fret|, and P; or None if no P has all within reach.
    """
    in_use = sorted((hand.held | given).items())
    homes = [(s.fret - f + 1, reach if len(s.strings) == 1 else 0) for f, s in in_use]
    lowest = max(hand.frets.start, *(home - slack for home, slack in homes))
    highest = min(hand.frets.stop - 1, *(home + slack for home, slack in homes))
    if lowest > highest:
        return None
    marks = sum(stop.mark not in (None, finger) for finger, stop in given.items())
    order = [(stop.fret, -max(stop.strings)) for _, stop in in_use]
    crossings = sum(lower > higher for lower, higher in combinations(order, 2))
    changes = sum(hand.resting.get(stop.place, f) != f for f, stop in given.items())
    positions = (
        (
            sum(max(p - stop.fret, stop.fret - p - 3, 0) for _, stop in in_use),
            abs(p - hand.position),
            sum(abs(p + finger - 1 - stop.fret) for finger, stop in given.items()),
            p,
        )
        for p in range(lowest, highest + 1)
    )
    return marks, crossings, changes, *min(positions)


def _complaint(note: Note, finger: int, in_use: dict[int, _Stop]) -> str | None:
    """Why a note is not as it was asked, if so."""
    if finger == UNPLAYABLE:
        if len(in_use) == 4:
            return "all four fingers are in use"
        frets = ", ".join(str(fret) for fret in sorted({s.fret for s in in_use.values()}))
        return f"out of reach of a hand that holds fret {frets}"
    if note.left_finger is not None and note.left_finger != finger:
        return f"marked for finger {note.left_finger}, played by finger {finger}"
    return None
