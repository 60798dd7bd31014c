"""Which finger plays which note: left hand 1 to 4, right hand p, i, m, a."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, permutations, product
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.guitar import PRESETS, Guitar
from roboguitarist.tablature import Note, Tablature

OPEN = 0
"""Left finger of an open string."""
UNPLAYABLE = -1
"""Left finger of a note that no finger can stop; the right hand still plucks it."""
LEFT_FINGERS = ("open", "index", "middle", "ring", "little")
RIGHT_FINGERS = ("p", "i", "m", "a")
SIMULTANEOUS_S = 5e-6
"""Times nearer than this are one moment: note times are rounded to whole microseconds."""
REACH_FRETS, STRETCH_FRETS = 1, 2
"""How far from its own fret (index P, middle P + 1, ...) a finger stops a string, and at most."""


@dataclass(frozen=True)
class Fingering:
    """A tablature with a finger of each hand for every note.

    Attributes:
        tablature: What is asked, with n notes.
        left: (n,) int8, 1 index to 4 little finger, `OPEN` or `UNPLAYABLE`.
        right: (n,) int8, 0 to 3 for p, i, m, a.
        barre: (n,) bool, the left finger lies flat over several strings.
        hold_position: (n,) int8, fret at which the index finger stands, from 1.
        problems: One line, with bar and beat, for each note that cannot be fingered and for
            each left finger marked in the file that had to be changed.
        method: Name of the method that chose the fingers.
    """

    tablature: Tablature
    left: np.ndarray
    right: np.ndarray
    barre: np.ndarray
    hold_position: np.ndarray
    problems: tuple[str, ...] = ()
    method: str = "paper"

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self, {"tablature": Tablature.to_json})

    @classmethod
    def load(cls, path: str | Path) -> Fingering:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        loaded = storage.load(path, cls, {"tablature": Tablature.from_json})
        return replace(loaded, problems=tuple(str(line) for line in loaded.problems))


def describe(note: Note) -> str:
    """A note's place in words, such as `bar 3, beat 2: string 5 fret 4`."""
    return f"bar {note.bar}, beat {note.beat:g}: string {note.string} fret {note.fret}"


def assign(
    tablature: Tablature, guitar: Guitar = PRESETS["classical"], method: str = "paper"
) -> Fingering:
    """Choose a finger of each hand for every note.

    The method `paper` goes through the notes in order of onset and never looks ahead, after
    section 4 of "Learning to Play Guitar with Robotic Hands":

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

    Args:
        tablature: What is asked.
        guitar: Its number of frets is the limit.
        method: `paper`.

    Raises:
        RoboGuitaristError: If there is no such method.
    """
    if method not in METHODS:
        raise RoboGuitaristError(f"no fingering method {method!r} (there is {', '.join(METHODS)})")
    return METHODS[method](tablature, guitar)


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


def _paper(tablature: Tablature, guitar: Guitar) -> Fingering:
    count = len(tablature.notes)
    left, barre = np.zeros(count, np.int8), np.zeros(count, bool)
    hold_position = np.ones(count, np.int8)
    problems: list[str] = []
    released_s = _released(tablature)
    frets = range(tablature.capo + 1, guitar.n_frets + 1)
    position, last = _opening_position(tablature, frets), {}
    for chord in _chords(tablature):
        excluded = _excluded(tablature, chord, frets)
        kept = [index for index in chord if index not in excluded]
        hand = _Hand.at(tablature.notes[chord[0]].onset_s, position, frets, last)
        fingers, position = _finger(tablature, _stops(tablature, kept, released_s), kept, hand)
        for finger, stop in fingers.items():
            left[list(stop.notes)] = finger
            barre[list(stop.notes)] = len(stop.strings) > 1
        hold_position[chord] = position
        last |= fingers
        for index in chord:
            note = tablature.notes[index]
            if index in excluded or (note.fret and not left[index]):
                left[index] = UNPLAYABLE
            reason = excluded.get(index) or _complaint(note, int(left[index]), hand.held | fingers)
            if reason:
                problems.append(f"{describe(note)}: {reason}")
    right = _right(tablature)
    return Fingering(tablature, left, right, barre, hold_position, tuple(problems), "paper")


METHODS = {"paper": _paper}


def _chords(tablature: Tablature) -> Iterator[list[int]]:
    """Indices of the notes that start together, in order of time."""
    chord: list[int] = []
    for index, note in enumerate(tablature.notes):
        if chord and note.onset_s - tablature.notes[chord[0]].onset_s > SIMULTANEOUS_S:
            yield chord
            chord = []
        chord.append(index)
    if chord:
        yield chord


def _released(tablature: Tablature) -> list[float]:
    """When each note lets go of its finger: at its end, or when its string plays on."""
    released, next_onset = [], {}
    for note in reversed(tablature.notes):
        released.append(min(note.end_s, next_onset.get(note.string, np.inf)))
        next_onset[note.string] = note.onset_s
    return released[::-1]


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


def _excluded(tablature: Tablature, chord: list[int], frets: range) -> dict[int, str]:
    """Notes of a chord that no hand could stop, each with the reason."""
    excluded, taken = {}, set()
    for index in reversed(chord):  # the highest fret of a string comes last, and is what sounds
        note = tablature.notes[index]
        fret = tablature.stopped_fret(note)
        if note.string in taken:
            excluded[index] = "the string has another note at this moment"
        elif fret and fret not in frets:
            excluded[index] = f"the guitar has {frets.stop - 1} frets"
        else:
            taken.add(note.string)
    return excluded


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


def _right(tablature: Tablature) -> np.ndarray:
    """Right fingers (n,): p on strings 6 to 4, i, m, a on 3, 2, 1, or as marked."""
    rule = np.array([-1, 3, 2, 1, 0, 0, 0], np.int8)
    right = rule[[note.string for note in tablature.notes]]
    for chord in _chords(tablature):
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
