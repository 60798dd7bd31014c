"""Notes of a tablature sorted into bars, and into lines of notes that do not overlap."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import groupby, pairwise

from roboguitarist.formats.musicxml_part import GRACE_LENGTH
from roboguitarist.formats.ticks import Ticked, TickedBar, TickedNote
from roboguitarist.tablature import Bar, Note, Technique


@dataclass(frozen=True, slots=True)
class Piece:
    """The part of a note that lies in one bar, and what joins it to its neighbours."""

    start: int
    end: int
    note: Note
    from_before: bool
    goes_on: bool


@dataclass(slots=True)
class Lane:
    """Pieces that follow each other without overlapping, chords in one list."""

    name: str
    chords: list[list[Piece]] = field(default_factory=list)

    def has_room(self, piece: Piece) -> bool:
        """Whether a piece that starts no earlier than the last one fits behind or on it."""
        if not self.chords:
            return True
        last = self.chords[-1][0]
        return last.end <= piece.start or (last.start, last.end) == (piece.start, piece.end)


def next_on_string(notes: Iterable[Note]) -> Iterator[tuple[tuple, Note]]:
    """Place of each note but the last of a string, and the note that follows it there."""
    in_order = sorted(notes, key=lambda note: (note.string, note.onset_s))
    for note, following in pairwise(in_order):
        if note.string == following.string:
            yield note.place, following


Grace = dict[tuple[int, int], list[list[TickedNote]]]


def grace_notes(ticked: Ticked) -> Grace:
    """Grace notes that stand where one is expected, by the voice and tick that they lead to."""
    length = GRACE_LENGTH * ticked.per_quarter
    small: dict[tuple[int, int], list[TickedNote]] = {}
    plain: dict[int, set[int]] = defaultdict(set)
    for note in ticked.notes:
        voice = note.note.voice
        if Technique.GRACE in note.note.techniques and note.end - note.start == length:
            small.setdefault((voice, note.start), []).append(note)
        else:
            plain[note.start].add(voice)
    leads_to: dict[tuple[int, int], tuple[int, int]] = {}
    found: Grace = {}
    for voice, tick in sorted(small, key=lambda key: -key[1]):
        beat = tick + int(length)
        target = leads_to.get((voice, beat))
        if beat in plain:
            target = (voice if voice in plain[beat] else min(plain[beat])), beat
        others = found.get(target, []) if target else []
        if target and all(other[0].note.voice == voice for other in others):
            leads_to[voice, tick] = target
            found[target] = [small[voice, tick], *others]
    return found


def from_the_start(ticked: Ticked, notes: list[TickedNote]) -> tuple[TickedBar, ...]:
    """The bars, with a pick-up bar before if notes other than grace notes begin before them."""
    first = ticked.bars[0]
    early = any(note.start < first.start for note in notes)
    if not early:
        return ticked.bars
    number = max(0, first.bar.number - 1)
    bar = Bar(0.0, number, first.bar.beats, first.bar.beat_type)
    return (TickedBar(0, first.start, bar), *ticked.bars)


def in_bars(bars: tuple[TickedBar, ...], notes: list[TickedNote]) -> list[list[Piece]]:
    """What sounds in each bar."""
    pieces: list[list[Piece]] = [[] for _ in bars]
    k = 0
    for ticked in notes:
        while k < len(bars) - 1 and bars[k].end <= ticked.start:
            k += 1
        here = k
        while here < len(bars) and bars[here].start < ticked.end:
            start, end = max(ticked.start, bars[here].start), min(ticked.end, bars[here].end)
            before, after = start > ticked.start, end < ticked.end
            pieces[here].append(Piece(start, end, ticked.note, before, after))
            here += 1
    return pieces


def lanes(pieces: list[Piece]) -> list[Lane]:
    """Pieces of one bar by voice; what overlaps within a voice goes to "1.2" and so on."""
    found: list[Lane] = []
    by_voice = sorted(pieces, key=lambda p: (p.note.voice, p.start, -p.end, p.note.string))
    for voice, group in groupby(by_voice, key=lambda piece: piece.note.voice):
        own: list[Lane] = []
        for piece in group:
            lane = next((lane for lane in own if lane.has_room(piece)), None)
            if lane is None:
                lane = Lane(f"{voice}.{len(own) + 1}" if own else f"{voice}")
                own.append(lane)
            if lane.chords and lane.chords[-1][0].start == piece.start:
                lane.chords[-1].append(piece)
            else:
                lane.chords.append([piece])
        found.extend(own)
    return found
