"""A tablature's times in ticks, for the writers: from seconds back to quarter notes."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise

from roboguitarist.tablature import Bar, Note, Tablature

TOLERANCE_S = 1.1e-6
"""A tablature's times are whole microseconds, its durations differences of two of them."""
_QUARTERS_S = 60.0


@dataclass(frozen=True, slots=True)
class TickedNote:
    """A note from tick `start` to tick `end`."""

    start: int
    end: int
    note: Note


@dataclass(frozen=True, slots=True)
class TickedBar:
    """A played bar from tick `start` to tick `end`."""

    start: int
    end: int
    bar: Bar

    @property
    def full(self) -> tuple[int, int]:
        """Length that the time signature says, as quarter notes' numerator and denominator."""
        return 4 * self.bar.beats, self.bar.beat_type


@dataclass(frozen=True, slots=True)
class Ticked:
    """A tablature in ticks.

    Attributes:
        per_quarter: Ticks in a quarter note.
        notes: In the order of the tablature.
        bars: Without gaps, the last one behind the end of all notes.
        tempi: Tick and quarter notes a minute of each tempo mark, the first at 0.
    """

    per_quarter: int
    notes: tuple[TickedNote, ...]
    bars: tuple[TickedBar, ...]
    tempi: tuple[tuple[int, float], ...]


class _Clock:
    """From seconds to ticks, at one resolution.

    Attributes:
        error_s: Largest distance of a time that was asked for from its tick.
    """

    def __init__(self, tablature: Tablature, per_quarter: int) -> None:
        self._starts_s: list[float] = []
        self._marks: list[tuple[int, float, float]] = []
        self.error_s = 0.0
        self.per_quarter = per_quarter
        for mark in tablature.tempi:
            tick = self(mark.onset_s) if self._marks else 0
            at_s = self.seconds(tick) if self._marks else 0.0
            self._marks.append((tick, at_s, _QUARTERS_S / mark.quarters_per_minute / per_quarter))
            self._starts_s.append(mark.onset_s)

    def __call__(self, time_s: float) -> int:
        start, at_s, tick_s = self._marks[max(0, bisect_right(self._starts_s, time_s) - 1)]
        tick = start + round((time_s - at_s) / tick_s)
        self.error_s = max(self.error_s, abs(at_s + (tick - start) * tick_s - time_s))
        return tick

    def seconds(self, tick: int) -> float:
        """Time of a tick at or after the last tempo mark."""
        start, at_s, tick_s = self._marks[-1]
        return at_s + (tick - start) * tick_s


def in_ticks(tablature: Tablature, resolutions: Sequence[int]) -> Ticked:
    """The times of a tablature in ticks.

    Args:
        tablature: What is written.
        resolutions: Ticks in a quarter note, in ascending order. The first at which every time
            is a whole number of ticks is taken, else the last; then times are rounded.
    """
    times_s = sorted(_times_s(tablature))
    for per_quarter in resolutions[:-1]:
        clock = _Clock(tablature, per_quarter)
        whole = all(4 * bar.beats * per_quarter % bar.beat_type == 0 for bar in tablature.bars)
        if whole and all(_fits(clock, time_s) for time_s in times_s):
            return _ticked(tablature, per_quarter)
    return _ticked(tablature, resolutions[-1])


def _times_s(tablature: Tablature) -> set[float]:
    marks = chain(tablature.bars, tablature.tempi, tablature.notes)
    return {mark.onset_s for mark in marks} | {note.end_s for note in tablature.notes}


def _fits(clock: _Clock, time_s: float) -> bool:
    clock(time_s)
    return clock.error_s <= TOLERANCE_S


def _ticked(tablature: Tablature, per_quarter: int) -> Ticked:
    clock = _Clock(tablature, per_quarter)
    notes = []
    for note in tablature.notes:
        start = clock(note.onset_s)
        notes.append(TickedNote(start, max(start + 1, clock(note.end_s)), note))
    ends = max((note.end for note in notes), default=0)
    starts = [clock(bar.onset_s) for bar in tablature.bars] or [0]
    bars = tablature.bars or (Bar(0.0, 1),)
    closed = [TickedBar(*ends_, bar) for bar, ends_ in zip(bars, pairwise(starts), strict=False)]
    closed.extend(_last_bars(TickedBar(starts[-1], 0, bars[-1]), ends, per_quarter))
    tempi = tuple((clock(mark.onset_s), mark.quarters_per_minute) for mark in tablature.tempi)
    lasting = tuple(bar for bar in closed if bar.end > bar.start)
    return Ticked(per_quarter, tuple(notes), lasting, ((0, tempi[0][1]), *tempi[1:]))


def _last_bars(bar: TickedBar, end: int, per_quarter: int) -> Iterator[TickedBar]:
    """The last bar; if the piece goes on for more than one bar's length, as many as it takes.

    A bar that is a little too long is one that the score wrote so.
    """
    quarters, beat_type = bar.full
    length = max(1, quarters * per_quarter // beat_type)
    while end - bar.start >= 2 * length:
        yield replace(bar, end=bar.start + length)
        following = replace(bar.bar, number=bar.bar.number + 1)
        bar = TickedBar(bar.start + length, 0, following)
    yield replace(bar, end=max(bar.start + length, end))
