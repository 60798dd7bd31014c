"""Exercises of one finger after another: scales, lines, shifts, a melody over a bass."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, repeat
from math import ceil

from roboguitarist.exercises.sheet import Sheet, Stroke, joined
from roboguitarist.tablature import STANDARD_TUNING

Place = tuple[int, int]
"""String and fret."""

MAJOR, MINOR = (0, 2, 4, 5, 7, 9, 11), (0, 2, 3, 5, 7, 8, 10)
SCALES = (MAJOR, MINOR, (0, 2, 3, 5, 7, 8, 11), tuple(range(12)))
"""Major, natural and harmonic minor, chromatic: semitones above the tonic."""
FASTEST_PER_S = 6.0


def tones(tonic: int, scale: tuple[int, ...]) -> frozenset[int]:
    """Pitch classes of a scale, 0 for C."""
    return frozenset((tonic + step) % 12 for step in scale)


KEPT_OUT = (tones(0, MAJOR), tones(7, MAJOR))


def pitch_class(place: Place) -> int:
    """Pitch class of a place, 0 for C."""
    return (STANDARD_TUNING[place[0] - 1] + place[1]) % 12


def in_position(tonic: int, scale: tuple[int, ...], position: int, stretch: bool) -> list[Place]:
    """Notes of a scale under a hand that stays, from the lowest pitch to the highest.

    Args:
        tonic: Pitch class, 0 for C.
        scale: Semitones above the tonic.
        position: Fret of the index finger, 0 for the open strings and frets 1 to 3.
        stretch: The little finger also takes the fret after its own, where the next string does
            not have that pitch, so that no note of the scale is left out.
    """
    wanted = tones(tonic, scale)
    reach = {string: 5 if stretch and string not in (1, 3) else 4 for string in range(1, 7)}
    places = (
        (string, fret)
        for string in range(6, 0, -1)
        for fret in range(position, position + reach[string])
    )
    return [place for place in places if pitch_class(place) in wanted]


def scales(sheet: Sheet) -> Iterator[Stroke]:
    """A scale over all strings in one position, in one of several orders, from its tonic.

    The notes of C and G major with open strings are left to the repertoire.
    """
    scale, tonic = sheet.pick(SCALES), sheet.between(0, 11)
    lowest = 1 if tones(tonic, scale) in KEPT_OUT else 0
    position = sheet.between(lowest, sheet.highest_fret - 4)
    places = in_position(tonic, scale, position, stretch=True)
    order = _order(sheet, len(places))
    start = next(i for i, k in enumerate(order) if pitch_class(places[k]) == tonic)
    notes = cycle(order[start:] + order[:start])
    for (beat, value), k in zip(sheet.rhythm(0.7, FASTEST_PER_S), notes, strict=False):
        yield Stroke(beat, *places[k], value)


def _order(sheet: Sheet, size: int) -> list[int]:
    """A way up and down a scale of this many notes."""
    group = sheet.pick(((0,), (0,), (0, 2), (0, 1, 2), (0, 1, 2, 3)))
    up = [k + step for k in range(size - max(group)) for step in group]
    down = [size - 1 - k for k in up]
    return sheet.pick((up + down[1:-1], down + up[1:-1], up, down))


def low_lines(sheet: Sheet) -> Iterator[Stroke]:
    """A wandering single line in the first positions, up to six notes a second."""
    highest = min(3, sheet.highest_fret - 4)
    return joined(sheet, lambda part: _line(part, 0, highest), sheet.pick((1, 2, 4)))


def high_lines(sheet: Sheet) -> Iterator[Stroke]:
    """A wandering single line in the upper half of the neck, up to six notes a second."""
    highest = sheet.highest_fret - 3
    lowest = min(max(1, sheet.highest_fret // 2), highest)
    return joined(sheet, lambda part: _line(part, lowest, highest), sheet.pick((1, 2, 4)))


def _line(sheet: Sheet, lowest: int, highest: int) -> Iterator[Stroke]:
    position = sheet.between(lowest, highest)
    places = in_position(sheet.between(0, 11), sheet.pick(SCALES), position, stretch=False)
    walk = _wander(sheet, len(places))
    for (beat, value), k in zip(sheet.rhythm(0.7, FASTEST_PER_S), walk, strict=False):
        yield Stroke(beat, *places[k], value)


def _wander(sheet: Sheet, size: int) -> Iterator[int]:
    """Steps and leaps over 0 to `size` - 1 that turn round at both ends."""
    k = sheet.between(0, size - 1)
    while True:
        yield k
        k += sheet.pick((-4, -2, -1, -1, 1, 1, 2, 4))
        k = size - 1 - abs(size - 1 - abs(k))


def repeated_notes(sheet: Sheet) -> Iterator[Stroke]:
    """One note two to eight times, then another not far from it."""
    places = _again_and_again(sheet)
    for (beat, value), place in zip(sheet.rhythm(1.5, FASTEST_PER_S), places, strict=False):
        yield Stroke(beat, *place, value)


def _again_and_again(sheet: Sheet) -> Iterator[Place]:
    position = sheet.between(1, sheet.highest_fret - 3)
    while True:
        place = sheet.between(1, 6), position + sheet.between(0, 3)
        yield from repeat(place, sheet.between(2, 8))
        position = min(max(1, position + sheet.between(-3, 3)), sheet.highest_fret - 3)


def position_shifts(sheet: Sheet) -> Iterator[Stroke]:
    """The same phrase with the same fingers in one position after another, with time to jump."""
    phrase = [(sheet.between(1, 6), sheet.between(0, 3)) for _ in range(sheet.between(2, 6))]
    value, jump = sheet.value(0.7, 4.0), sheet.value(1.0, 3.0)
    highest = min(12, sheet.highest_fret - 3)
    beat, position = 0.0, 0
    while beat < sheet.quarters:
        position = sheet.pick([p for p in range(1, highest + 1) if p != position])
        for string, offset in phrase:
            yield Stroke(beat, string, position + offset, value, offset + 1)
            beat += value
        beat += jump


def melody_over_bass(sheet: Sheet) -> Iterator[Stroke]:
    """A melody on strings 1 to 3 over two alternating basses, the hand still for a phrase."""
    return joined(sheet, _melody_phrase, sheet.pick((1, 2, 4)))


def _melody_phrase(sheet: Sheet) -> Iterator[Stroke]:
    position = sheet.between(0, sheet.highest_fret - 3)
    places = in_position(sheet.between(0, 11), sheet.pick(SCALES[:3]), position, stretch=False)
    basses = _basses(sheet, [place for place in places if place[0] > 3])
    pulse = sheet.value(0.5, 2.5)
    for k in range(ceil(sheet.quarters / pulse)):
        bass = basses[k % 2]
        yield Stroke(k * pulse, *bass, pulse, finger_at(bass, position))
    tune = [place for place in places if place[0] < 4]
    walk = _wander(sheet, len(tune))
    for (beat, value), k in zip(sheet.rhythm(0.7, 5.0), walk, strict=False):
        held = min(value, pulse)
        moments = (beat, beat + held - 1e-3)
        under = (basses[int(moment / pulse + 1e-6) % 2] for moment in moments)
        busy = {finger_at(bass, position) for bass in under} - {0}
        free = [n for n, place in enumerate(tune) if finger_at(place, position) not in busy]
        if free:
            place = tune[min(free, key=lambda n: abs(n - k))]
            yield Stroke(beat, *place, held, finger_at(place, position))


def _basses(sheet: Sheet, places: list[Place]) -> tuple[Place, Place]:
    """Two places on different strings, open strings now and then."""
    first = sheet.pick(places)
    second = sheet.pick([place for place in places if place[0] != first[0]])
    return _or_open(sheet, first), _or_open(sheet, second)


def _or_open(sheet: Sheet, place: Place) -> Place:
    return (place[0], 0) if sheet.chance(0.25) else place


def finger_at(place: Place, position: int) -> int:
    """The finger for a place in a position: one for each fret, 0 for an open string."""
    return place[1] - max(position, 1) + 1 if place[1] else 0
