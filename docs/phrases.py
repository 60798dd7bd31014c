"""Phrases whose fingerings are explained on the fingering page."""

from __future__ import annotations

from dataclasses import replace

from roboguitarist import engraving, formats, pieces
from roboguitarist.fingering import assign
from roboguitarist.tablature import Bar, Note, Tablature

WIDTH = 84
Events = list[tuple[float, dict[int, int]]]
"""Length in quarter notes, and fret of each string, of one chord after the other."""


def phrase(title: str, events: Events, ring: float = 1.0) -> Tablature:
    """One bar at 60 quarters a minute; notes last `ring` times as long as their place."""
    notes, time_s = [], 0.0
    for length_s, frets in events:
        for string, fret in sorted(frets.items()):
            notes.append(Note(round(time_s, 6), string, fret, round(length_s * ring, 6)))
        time_s += length_s
    return Tablature(tuple(notes), (Bar(0.0, 1),), title=title)


def excerpt(name: str, first: int, last: int) -> Tablature:
    """Bars `first` to `last` of a piece of the repertoire."""
    piece = formats.load(pieces.path(name))
    start_s = min(bar.onset_s for bar in piece.bars if bar.number == first)
    bars = [b for b in piece.bars if first <= b.number <= last]
    notes = [n for n in piece.notes if first <= n.bar <= last]
    return replace(
        piece,
        bars=tuple(replace(bar, onset_s=bar.onset_s - start_s) for bar in bars),
        notes=tuple(replace(note, onset_s=round(note.onset_s - start_s, 6)) for note in notes),
        composer="",
    )


BARRE_CHORD = [{6: 1}, {3: 2}, {2: 1}, {1: 1}, {5: 3}, {3: 2}, {2: 1}, {1: 1}]
SHIFT = [{1: 0}, {1: 3}, {1: 5}, {1: 0}, {1: 8}, {1: 10}, {1: 12}, {1: 10}, {1: 8}, {1: 7}]
RUN = [{2: 5}, {2: 6}, {2: 8}, {1: 5}, {1: 7}, {1: 8}, {1: 10}, {1: 12}, {1: 8}, {1: 7}, {1: 5}]
PHRASES = {
    "elise": excerpt("fur-elise", 1, 4),
    "changes": excerpt("chord-transition", 1, 4),
    "arpeggio": phrase("Broken F chord", [(0.25, frets) for frets in BARRE_CHORD], ring=4.0),
    "shift": phrase("Shift on an open string", [(0.25, frets) for frets in SHIFT]),
    "run": phrase("Run across two positions", [(0.2, frets) for frets in RUN]),
}


def rendered(name: str) -> str:
    """The phrase as text, without the legend."""
    blocks = engraving.render(assign(PHRASES[name], method="search"), WIDTH).split("\n\n")
    return "\n\n".join([blocks[0].splitlines()[0], *blocks[1:]])
