"""Marks that a file puts on the note where a hammer-on, pull-off or slide begins.

A tablature has them on the note that is played that way, which is the next one on the string.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from roboguitarist.formats.written import WrittenNote
from roboguitarist.tablature import Technique


@dataclass(frozen=True, slots=True)
class Linked:
    """A note, and whether the next one on its string is slurred or slid to."""

    note: WrittenNote
    slurs: bool = False
    slides: bool = False


def linked(notes: Sequence[Linked]) -> Iterator[WrittenNote]:
    """The notes in order of time with the marks on the second note of each pair."""
    before: dict[tuple[int, int | None], Linked] = {}
    for link in sorted(notes, key=lambda link: (link.note.bar, link.note.offset)):
        note = link.note
        key = note.voice, note.string
        origin = before.get(key)
        kinds = set(note.techniques)
        if origin is not None and not note.tied:
            kinds |= _kinds(origin, note)
        before[key] = link if not note.tied or origin is None else _going_on(origin, link)
        yield replace(note, techniques=tuple(sorted(kinds)))


def _kinds(origin: Linked, note: WrittenNote) -> set[Technique]:
    kinds = {Technique.SLIDE} if origin.slides else set()
    if origin.slurs:
        up = (note.fret or 0) >= (origin.note.fret or 0)
        kinds.add(Technique.HAMMER_ON if up else Technique.PULL_OFF)
    return kinds


def _going_on(origin: Linked, link: Linked) -> Linked:
    """A tied note takes over the marks of the one it continues."""
    return replace(link, slurs=link.slurs or origin.slurs, slides=link.slides or origin.slides)
