"""Seconds of places that are given in quarter notes."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise

from roboguitarist.formats.written import WrittenBar

DEFAULT_TEMPO = Fraction(120)
"""Quarter notes a minute where a score does not say."""
_PICO = 10**12


class TempoMap:
    """Seconds of a place in quarter notes from the start of the piece.

    Args:
        marks: Place in quarter notes and quarter notes a minute, in order, the first at 0. Of
            several marks at one place the last counts.
    """

    def __init__(self, marks: Iterable[tuple[Fraction, Fraction]]) -> None:
        self.marks: list[tuple[Fraction, Fraction]] = []
        for quarter, exact in marks:
            tempo = Fraction(repr(float(exact)))  # what a tablature holds and writers write
            if self.marks and self.marks[-1][0] == quarter:
                self.marks.pop()
            if not self.marks or self.marks[-1][1] != tempo:
                self.marks.append((quarter, tempo))
        self._quarters = [quarter for quarter, _ in self.marks]
        self._seconds = [Fraction(0)]
        for (start, tempo), (end, _) in pairwise(self.marks):
            now = self._seconds[-1] + (end - start) * 60 / tempo
            # Exact sums of thousands of fractions would have thousands of digits.
            self._seconds.append(Fraction(round(now * _PICO), _PICO))
        self._known: dict[Fraction, float] = {}

    def __call__(self, quarter: Fraction) -> float:
        """Time in seconds, rounded to whole microseconds."""
        if quarter not in self._known:
            self._known[quarter] = self._time_s(quarter)
        return self._known[quarter]

    def _time_s(self, quarter: Fraction) -> float:
        k = max(0, bisect_right(self._quarters, quarter) - 1)
        start, tempo = self.marks[k]
        seconds = self._seconds[k] + (quarter - start) * 60 / tempo
        return round(seconds * 1_000_000) / 1_000_000


def bar_starts(bars: Sequence[WrittenBar], order: Sequence[int], first: Fraction) -> list[Fraction]:
    """Where each played bar starts, in quarter notes; the first at `first`."""
    starts, now = [], first
    for index in order:
        starts.append(now)
        now += bars[index].length
    return starts


def tempo_map(
    bars: Sequence[WrittenBar], order: Sequence[int], starts: Sequence[Fraction]
) -> TempoMap:
    """Tempo marks as they are met; a bar that is jumped to has the tempo it is written in."""
    in_force, tempo = [], DEFAULT_TEMPO
    for bar in bars:
        in_force.append(tempo)
        tempo = bar.tempi[-1][1] if bar.tempi else tempo
    marks = []
    for index, start in zip(order, starts, strict=True):
        marks.append((start if marks else Fraction(0), in_force[index]))
        for offset, tempo in bars[index].tempi:
            first = len(marks) == 1 and offset == 0
            marks.append((Fraction(0) if first else start + offset, tempo))
    return TempoMap(marks or [(Fraction(0), DEFAULT_TEMPO)])
