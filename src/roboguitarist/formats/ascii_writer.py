"""Writing ASCII tab: every column is one step of a grid, which a line above says."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from roboguitarist.formats.ascii_signs import text_of
from roboguitarist.formats.ticks import Ticked, TickedNote, in_ticks
from roboguitarist.tablature import N_STRINGS, Tablature, Technique

NAMES = "C C# D Eb E F F# G G# A Bb B".split()
RESOLUTIONS = (1, 2, 3, 4, 6, 8, 12, 24, 48)
"""Columns in a quarter note."""
WIDTH = 78


def write(tablature: Tablature) -> bytes:
    """A tablature as ASCII tab.

    It keeps order, strings, frets and the techniques that have a sign, and times where a grid of
    at most 48 columns in a quarter note has them. It has no durations, voices, fingers and
    changes of tempo; the tempo is that of the beginning.
    """
    ticked = _spaced(tablature)
    width = max(len(NAMES[pitch % 12]) for pitch in tablature.tuning)
    margin = [NAMES[pitch % 12].ljust(width) for pitch in tablature.tuning]
    margin[0] = margin[0].lower() if margin[0].strip() in ("E", "D", "B") else margin[0]
    blocks = ["\n".join(_facts(tablature, ticked.per_quarter))]
    system = list(margin)
    for rows in _bars(ticked):
        full = len(system[0]) + len(rows[0]) + 2 > WIDTH
        if full and system != margin:
            blocks.append("\n".join(f"{row}|" for row in system))
            system = list(margin)
        system = [f"{row}|{more}" for row, more in zip(system, rows, strict=True)]
    blocks.append("\n".join(f"{row}|" for row in system))
    return ("\n\n".join(blocks) + "\n").encode()


def _facts(tablature: Tablature, per_quarter: int) -> Iterator[str]:
    for name, text in (("Title", tablature.title), ("Composer", tablature.composer)):
        if text:
            yield f"{name}: {' '.join(text.split())}"
    names = [NAMES[pitch % 12] for pitch in reversed(tablature.tuning)]
    yield f"Tuning: {' '.join(names)}"
    if tablature.capo:
        yield f"Capo: {tablature.capo}"
    yield f"Tempo: {tablature.tempi[0].quarters_per_minute:.4f}".rstrip("0").rstrip(".")
    yield f"Grid: {4 * per_quarter}"


def _spaced(tablature: Tablature) -> Ticked:
    """Times in columns, so many in a quarter note that no two signs on a string touch."""
    onsets = (replace(note, duration_s=0.0) for note in tablature.notes)
    tablature = replace(tablature, notes=tuple(onsets))  # durations need no columns
    ticked = in_ticks(tablature, RESOLUTIONS)
    for factor in (1, 2, 3, 4, 6):
        per_quarter = ticked.per_quarter * factor
        if per_quarter > RESOLUTIONS[-1]:
            break
        ticked = in_ticks(tablature, (per_quarter,))
        if _has_room(ticked) and all(_fits(*pair) for pair in _neighbours(ticked)):
            break
    return ticked


def _has_room(ticked: Ticked) -> bool:
    """Whether every sign ends before the bar does."""
    ends = [bar.end for bar in ticked.bars]
    for note in ticked.notes:
        end = ends[min(bisect_right(ends, note.start), len(ends) - 1)]
        if note.start + len(text_of(note.note)[1]) > end:
            return False
    return True


def _neighbours(ticked: Ticked) -> Iterator[tuple[TickedNote, TickedNote]]:
    in_order = sorted(ticked.notes, key=lambda note: (note.note.string, note.start))
    for before, after in pairwise(in_order):
        if before.note.string == after.note.string:
            yield before, after
    yield from pairwise(sorted(ticked.notes, key=lambda note: note.start))


def _fits(before: TickedNote, after: TickedNote) -> bool:
    if before.note.string != after.note.string:
        return before.start == after.start or after.start - before.start >= _width(before)
    lead = len(text_of(after.note)[0])
    return len(text_of(before.note)[1]) + max(1, lead) <= after.start - before.start


def _width(note: TickedNote) -> int:
    """Columns of the fret's number, under which a reader takes all notes as one chord."""
    brackets = 2 * (Technique.HARMONIC in note.note.techniques)
    return len(str(note.note.fret)) + brackets


def _bars(ticked: Ticked) -> Iterator[list[str]]:
    """The strings of each bar, a dash between bar line and music."""
    notes = sorted(ticked.notes, key=lambda note: note.start)
    k = 0
    for bar in ticked.bars:
        rows = [["-"] * (bar.end - bar.start + 1) for _ in range(N_STRINGS)]
        while k < len(notes) and (notes[k].start < bar.end or bar is ticked.bars[-1]):
            _put(rows[notes[k].note.string - 1], max(0, notes[k].start - bar.start), notes[k])
            k += 1
        width = max(map(len, rows))
        yield ["".join(row).ljust(width, "-") for row in rows]


def _put(row: list[str], column: int, note: TickedNote) -> None:
    """Write a fret at a column, the sign of what leads to it before, other signs behind."""
    before, sign = text_of(note.note)
    at = column + 1
    row[max(0, at - len(before)) : at] = before
    row[at : at + len(sign)] = sign
