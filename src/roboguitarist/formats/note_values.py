"""Lengths as music is written: note values with dots, and tuplets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

NAMES = {
    Fraction(32): "maxima",
    Fraction(16): "long",
    Fraction(8): "breve",
    Fraction(4): "whole",
    Fraction(2): "half",
    Fraction(1): "quarter",
    Fraction(1, 2): "eighth",
    Fraction(1, 4): "16th",
    Fraction(1, 8): "32nd",
    Fraction(1, 16): "64th",
    Fraction(1, 32): "128th",
}
"""Names of the lengths in quarter notes, as MusicXML spells them."""
_TUPLETS = ((1, 1), (3, 2), (5, 4), (6, 4), (7, 4), (9, 8), (11, 8), (13, 8))
_MAX_DOTS = 2


@dataclass(frozen=True, slots=True)
class NoteValue:
    """A name with dots; in a tuplet `actual` notes take the time of `normal`."""

    name: str
    dots: int = 0
    actual: int = 1
    normal: int = 1


def dotted(base: Fraction, dots: int) -> Fraction:
    """Length of a note with dots."""
    return base * (2 - Fraction(1, 2**dots))


_VALUES = {
    dotted(base, dots) * normal / actual: NoteValue(name, dots, actual, normal)
    for (actual, normal), dots, (base, name) in reversed(
        list(product(_TUPLETS, range(_MAX_DOTS + 1), NAMES.items()))
    )
}
"""Where two values are equally long, the simpler one."""
_PLAIN = sorted((length for length, value in _VALUES.items() if value.actual == 1), reverse=True)


def split(ticks: int, per_quarter: int) -> Iterator[tuple[int, NoteValue | None]]:
    """Lengths that can be written and together are the given one; None for what cannot.

    Args:
        ticks: The length, 0 or more.
        per_quarter: Ticks in a quarter note.
    """
    while ticks:
        length = Fraction(ticks, per_quarter)
        if length not in _VALUES:
            fitting = (p for p in _PLAIN if p <= length and not per_quarter % p.denominator)
            length = next(fitting, length)
        part = int(length * per_quarter)
        yield part, _VALUES.get(length)
        ticks -= part
