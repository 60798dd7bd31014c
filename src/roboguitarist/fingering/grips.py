"""Grips: every way in which four fingers can stop the notes of one chord."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations

MOST_FRETS_APART = {(1, 2): 3, (1, 3): 4, (1, 4): 5, (2, 3): 2, (2, 4): 3, (3, 4): 2}
"""Frets that two fingers can be apart: one more than their natural distance, two for the index."""
LEFT_OUT = -1
Place = tuple[int, int]
"""String and fret; fret 0 is the open string."""
Grip = tuple[int, ...]
"""Finger of each note: 1 to 4, 0 for an open string, or `LEFT_OUT`."""


def together(lower: int, lower_fret: int, higher: int, higher_fret: int) -> bool:
    """Whether two fingers, the lower-numbered first, can be down at these frets at once."""
    return 0 <= higher_fret - lower_fret <= MOST_FRETS_APART[lower, higher]


def grips(places: tuple[Place, ...], marks: tuple[int | None, ...]) -> tuple[Grip, ...]:
    """Every way to stop the notes of a chord, leaving out as few as can be.

    Fingers never cross frets, but may on one fret. The index finger may lie flat over notes of
    one fret (barre), other fingers where marks say so. A flat finger comes from the treble side,
    so no string from there to its tip may be open or stopped by another finger at or below its
    fret. Of all ways only those that break the fewest marks are offered.

    Args:
        places: On different strings.
        marks: Finger that the score asks for, or None, for each note.
    """
    lowest = min((fret for _, fret in places if fret), default=1)
    # The same shape higher up has the same grips.
    return _grips(tuple((s, f and f - lowest + 1) for s, f in places), marks)


@lru_cache(maxsize=1 << 16)
def _grips(places: tuple[Place, ...], marks: tuple[int | None, ...]) -> tuple[Grip, ...]:
    stopped = [k for k, (_, fret) in enumerate(places) if fret]
    for size in range(len(stopped), -1, -1):
        found = [
            grip for kept in combinations(stopped, size) for grip in _assigned(places, marks, kept)
        ]
        if found:
            broken = [_broken_marks(grip, marks) for grip in found]
            best = min(broken)
            return tuple(g for g, count in zip(found, broken, strict=True) if count == best)
    return ()


def _broken_marks(grip: Grip, marks: tuple[int | None, ...]) -> int:
    return sum(m not in (None, f) for f, m in zip(grip, marks, strict=True) if f != LEFT_OUT)


def _assigned(
    places: tuple[Place, ...], marks: tuple[int | None, ...], kept: tuple[int, ...]
) -> Iterator[Grip]:
    """All grips that stop the kept notes and leave out the other stopped ones."""

    def extend(grip: dict[int, int], rest: tuple[int, ...]) -> Iterator[Grip]:
        if not rest:
            yield tuple(
                grip.get(k, 0 if fret == 0 else LEFT_OUT) for k, (_, fret) in enumerate(places)
            )
            return
        k = rest[0]
        for finger in (1, 2, 3, 4):
            if _fits(k, finger, grip, places, marks):
                yield from extend({**grip, k: finger}, rest[1:])

    yield from (grip for grip in extend({}, kept) if _barres_lie_free(grip, places))


def _fits(
    k: int,
    finger: int,
    grip: dict[int, int],
    places: tuple[Place, ...],
    marks: tuple[int | None, ...],
) -> bool:
    fret = places[k][1]
    for other, used in grip.items():
        if used == finger:
            flat = finger == 1 or marks[k] == marks[other] == finger
            if not flat or places[other][1] != fret:
                return False
        elif not (
            together(finger, fret, used, places[other][1])
            if finger < used
            else together(used, places[other][1], finger, fret)
        ):
            return False
    return True


def _barres_lie_free(grip: Grip, places: tuple[Place, ...]) -> bool:
    for finger in {f for f in grip if f > 0 and grip.count(f) > 1}:
        under = [place for place, f in zip(places, grip, strict=True) if f == finger]
        tip, fret = max(under)
        for (string, other), f in zip(places, grip, strict=True):
            if string < tip and f not in (finger, LEFT_OUT) and other <= fret:
                return False
    return True
