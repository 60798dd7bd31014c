"""What every exercise is written with: a sheet of paper, strokes on it, and rhythm."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from typing import NamedTuple, TypeVar

import numpy as np

from roboguitarist.fingering import UNPLAYABLE, assign
from roboguitarist.tablature import Bar, Note, Tablature, Tempo

QUARTERS_PER_BAR = 4
MIN_HOLD_S = 0.1
"""No note is made shorter than this by staccato."""
VALUES = (1 / 8, 1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 1.0, 2.0, 4.0, 8.0)
"""Note values in quarters, triplets among them."""
CELLS = ((1,), (1,), (1,), (2, 1, 1), (1, 1, 2), (1, 2, 1), (3, 1), (2, 1), (1, 1, 1, 3))
"""Rhythms as multiples of a note value."""

T = TypeVar("T")


class Stroke(NamedTuple):
    """A note on the sheet: times in quarters from its start, left finger 1 to 4 if marked."""

    beat: float
    string: int
    fret: int
    quarters: float
    finger: int | None = None


@dataclass(frozen=True)
class Sheet:
    """An empty sheet, and the dice that fill it.

    Attributes:
        rng: Source of every choice.
        tempo: Quarters a minute.
        quarters: Length in quarters.
        highest_fret: No note is above it.
    """

    rng: np.random.Generator
    tempo: float
    quarters: float
    highest_fret: int

    def pick(self, items: Sequence[T]) -> T:
        """One of the items, each as likely."""
        return items[self.between(0, len(items) - 1)]

    def between(self, low: int, high: int) -> int:
        """A whole number from `low` to `high`, each as likely."""
        return int(self.rng.integers(low, high + 1))

    def chance(self, probability: float) -> bool:
        """True with this probability."""
        return bool(self.rng.random() < probability)

    def value(self, least_per_s: float, most_per_s: float) -> float:
        """A note value in quarters that gives so many notes a second, or the nearest to it."""
        per_s = self.tempo / 60.0
        fitting = [v for v in VALUES if least_per_s <= per_s / v <= most_per_s]
        slow_enough = [v for v in VALUES if per_s / v <= most_per_s]
        return self.pick(fitting) if fitting else slow_enough[0]

    def rhythm(self, least_per_s: float, most_per_s: float) -> Iterator[tuple[float, float]]:
        """Beat and value of notes in a repeated rhythm, up to the end of the sheet."""
        value = self.value(least_per_s, most_per_s)
        beat = 0.0
        for multiple in cycle(self.pick(CELLS)):
            if beat > self.quarters - 1e-6:
                return
            yield beat, value * multiple
            beat += value * multiple


Writer = Callable[[Sheet], Iterable[Stroke]]
"""Fills a sheet. What is beyond the end is cut off."""


def joined(sheet: Sheet, phrase: Writer, bars: int) -> Iterator[Stroke]:
    """Phrases of so many bars one after the other, each on a sheet of its own."""
    length = bars * QUARTERS_PER_BAR
    for start in np.arange(0.0, sheet.quarters, length).tolist():
        part = replace(sheet, quarters=min(length, sheet.quarters - start))
        for stroke in phrase(part):
            if stroke.beat < part.quarters - 1e-6:
                ringing = min(stroke.quarters, part.quarters - stroke.beat)
                yield stroke._replace(beat=start + stroke.beat, quarters=ringing)


def written(sheet: Sheet, strokes: Iterable[Stroke], title: str) -> Tablature:
    """The strokes as a tablature with rests and articulation; a string ends its own notes."""
    groups: dict[float, list[Stroke]] = defaultdict(list)
    for stroke in strokes:
        if stroke.beat < sheet.quarters - 1e-6:
            groups[round(stroke.beat, 9)].append(stroke)
    onsets = _rested(sheet, sorted(groups))
    touches = _touches(sheet, len(onsets))
    ends: dict[int, float] = defaultdict(lambda: sheet.quarters)
    notes: list[Note] = []
    for beat, touch in zip(onsets[::-1], touches, strict=True):
        for stroke in groups[beat]:
            legato = min(stroke.quarters, ends[stroke.string] - beat)
            held = min(legato, max(touch * legato, MIN_HOLD_S * sheet.tempo / 60.0))
            notes.append(_note(stroke, beat, held, sheet.tempo))
        ends |= {stroke.string: beat for stroke in groups[beat]}
    notes.sort(key=lambda note: note.place)
    count = int(np.ceil(sheet.quarters / QUARTERS_PER_BAR - 1e-9))
    bars = (Bar(_seconds(QUARTERS_PER_BAR * i, sheet.tempo), i + 1) for i in range(count))
    return Tablature(tuple(notes), tuple(bars), (Tempo(0.0, sheet.tempo),), title=title)


def _rested(sheet: Sheet, onsets: list[float]) -> list[float]:
    """The onsets without those that a rest takes, the first always kept."""
    share = sheet.pick((0.0, 0.0, 0.1, 0.25))
    kept = sheet.rng.random(len(onsets)) >= share
    return [beat for i, (beat, keep) in enumerate(zip(onsets, kept, strict=True)) if keep or not i]


def _touches(sheet: Sheet, count: int) -> list[float]:
    """Share of its written value that each onset is held: legato, staccato or both in turns."""
    low, high = sheet.pick(((1.0, 1.0), (1.0, 1.0), (0.3, 0.5), (0.6, 0.9), (0.3, 1.0)))
    return sheet.rng.uniform(low, high, count).tolist()


def _seconds(beat: float, tempo: float) -> float:
    return round(beat * 60.0 / tempo, 6)


def _note(stroke: Stroke, beat: float, held: float, tempo: float) -> Note:
    onset_s = _seconds(beat, tempo)
    duration_s = round(_seconds(beat + held, tempo) - onset_s, 6)
    bar, in_bar = divmod(beat, QUARTERS_PER_BAR)
    return Note(
        onset_s,
        stroke.string,
        stroke.fret,
        max(duration_s, 1e-6),
        int(bar) + 1,
        round(in_bar + 1, 6),
        left_finger=stroke.finger if stroke.fret else None,
    )


def playable(tablature: Tablature) -> Tablature:
    """The tablature without notes that no finger can stop and marks that cannot be kept.

    Each pass takes a note or a mark away, so there is an end, and a first note always stays.
    """
    while (fingering := assign(tablature)).problems:
        notes = (
            note if note.left_finger in (None, finger) else replace(note, left_finger=None)
            for note, finger in zip(tablature.notes, fingering.left.tolist(), strict=True)
            if finger != UNPLAYABLE
        )
        tablature = replace(tablature, notes=tuple(notes))
    return tablature
