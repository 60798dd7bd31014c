"""GPIF, the document inside files of Guitar Pro 6 to 8, to the score as written.

It is XML in which bars, voices, beats, notes and rhythms stand in lists of their own and refer to
each other by number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats import xml_tree
from roboguitarist.formats.gpif_bars import bars_of
from roboguitarist.formats.gpif_notes import NoteReader, is_grace, rhythm
from roboguitarist.formats.linked import Linked, linked
from roboguitarist.formats.midi import BASS_PROGRAMS
from roboguitarist.formats.musicxml_part import GRACE_LENGTH
from roboguitarist.formats.written import WrittenBar, WrittenPart, WrittenScore
from roboguitarist.formats.xml_tree import integer, text

_LISTS = {"Bars": "Bar", "Voices": "Voice", "Beats": "Beat", "Notes": "Note", "Rhythms": "Rhythm"}
MAX_BEATS = 100_000
_HIGHEST_BASS_STRING = 52


@dataclass(frozen=True, slots=True)
class _Staff:
    """One staff of a track: where its bars stand in the list of each master bar."""

    column: int
    tuning: tuple[int, ...] | None
    capo: int


class _Document:
    """The lists of the document by number, and the staves in order."""

    def __init__(self, root: Element) -> None:
        self.lists = {
            kind: {element.get("id", ""): element for element in root.iterfind(f"{name}/{kind}")}
            for name, kind in _LISTS.items()
        }
        self.master_bars = root.findall("MasterBars/MasterBar")
        self.beats_read = 0

    def get(self, kind: str, number: str) -> Element | None:
        """An element by its number; -1 and what is missing give None."""
        return self.lists[kind].get(number)


def read(source: bytes | Element) -> WrittenScore:
    """Read a GPIF document, from its text or its root.

    Raises:
        TabError: If it is not one, or something in it makes no sense.
    """
    root = xml_tree.parse(source) if isinstance(source, bytes) else source
    if root.tag != "GPIF":
        raise TabError(f"not a Guitar Pro score: the root element is {root.tag[:40]!r}")
    document = _Document(root)
    bars = bars_of(root)
    parts, column = [], 0
    for number, track in enumerate(root.iterfind("Tracks/Track"), 1):
        staves = list(_staves(track, column))
        column += len(staves)
        name = text(track, "Name") or f"track {number}"
        try:
            parts.append(_part(document, track, name, staves, bars))
        except TabError as error:
            raise TabError(
                error.reason, part=name, bar=error.bar, beat=error.beat, hint=error.hint
            ) from error
    bars = _with_pick_up(root, bars, parts)
    composer = text(root, "Score/Music") or text(root, "Score/WordsAndMusic")
    return WrittenScore(
        bars=bars,
        parts=tuple(parts),
        title=text(root, "Score/Title"),
        composer=composer or text(root, "Score/Artist"),
    )


def _staves(track: Element, column: int) -> Iterator[_Staff]:
    found = track.findall("Staves/Staff") or [track]
    for k, staff in enumerate(found):
        pitches = text(staff, "Properties/Property[@name='Tuning']/Pitches").split()
        tuning = tuple(int(p) for p in reversed(pitches) if p.isdecimal() and len(p) < 4)
        capo = integer(staff, "Properties/Property[@name='CapoFret']/Fret") or 0
        yield _Staff(column + k, tuning or None, capo)


def _part(
    document: _Document,
    track: Element,
    name: str,
    staves: Sequence[_Staff],
    bars: Sequence[WrittenBar],
) -> WrittenPart:
    """A track; staves of one tuning are one part, as those of a piano are."""
    links: list[Linked] = []
    staff = staves[0]
    for number, other in enumerate(staves):
        found = _notes(document, other, bars, 8 * number)
        if found and not links:
            staff, links = other, found
        elif (other.tuning, other.capo) == (staff.tuning, staff.capo):
            links.extend(found)
    tuning = staff.tuning
    return WrittenPart(
        name=name,
        notes=tuple(linked(links)),
        n_strings=len(tuning) if tuning else None,
        tuning=tuning if tuning and len(tuning) == 6 else None,
        capo=staff.capo,
        obstacle=_obstacle(track, tuning),
    )


def _obstacle(track: Element, tuning: tuple[int, ...] | None) -> str:
    kind = text(track, "InstrumentSet/Type").casefold()
    table = track.find("GeneralMidi")
    percussion = table is not None and table.get("table", "").casefold() == "percussion"
    if percussion or "drum" in kind or "percussion" in kind:
        return "it is a drum part"
    program = integer(track, "Sounds/Sound/MIDI/Program")
    program = integer(track, "GeneralMidi/Program") if program is None else program
    low = tuning is not None and tuning[0] < _HIGHEST_BASS_STRING
    if low or (program in BASS_PROGRAMS and not tuning):
        return "it is a bass part"
    return ""


def _notes(
    document: _Document, staff: _Staff, bars: Sequence[WrittenBar], voices_before: int
) -> list[Linked]:
    found: list[Linked] = []
    for index, master in enumerate(document.master_bars[: len(bars)]):
        numbers = text(master, "Bars").split()
        bar = document.get("Bar", numbers[staff.column]) if staff.column < len(numbers) else None
        for voice, number in enumerate(text(bar, "Voices").split()[:8], 1 + voices_before):
            element = document.get("Voice", number)
            beats = text(element, "Beats").split()
            try:
                found.extend(_voice(document, staff, (index, voice), beats))
            except TabError as error:
                raise TabError(error.reason, bar=bars[index].number, hint=error.hint) from error
    return found


def _voice(
    document: _Document, staff: _Staff, place: tuple[int, int], numbers: Sequence[str]
) -> Iterator[Linked]:
    """Notes of one voice in one bar; grace beats stand just before the beat that they lead to."""
    now = Fraction(0)
    grace: list[Element] = []
    for number in numbers:
        document.beats_read += 1
        if document.beats_read > MAX_BEATS:
            raise TabError(f"more than {MAX_BEATS} beats")
        beat = document.get("Beat", number)
        if beat is None:
            continue
        if is_grace(beat):
            grace.append(beat)
            continue
        reference = beat.find("Rhythm")
        length = rhythm(
            document.get("Rhythm", "" if reference is None else reference.get("ref", ""))
        )
        late = _grace_on_the_beat(grace)
        for k, small in enumerate(grace):
            offset = now + late - (len(grace) - k) * GRACE_LENGTH
            yield from _beat(document, staff, place, small, (offset, GRACE_LENGTH))
        grace = []
        yield from _beat(
            document, staff, place, beat, (now + late, max(GRACE_LENGTH, length - late))
        )
        now += length


def _grace_on_the_beat(grace: Sequence[Element]) -> Fraction:
    """How much later the main note begins because grace notes take its beat."""
    return sum(
        (GRACE_LENGTH for beat in grace if text(beat, "GraceNotes") == "OnBeat"), Fraction(0)
    )


def _beat(
    document: _Document,
    staff: _Staff,
    place: tuple[int, int],
    beat: Element,
    time: tuple[Fraction, Fraction],
) -> Iterator[Linked]:
    reader = NoteReader(beat, place, time, len(staff.tuning or ()) or 6)
    for number in text(beat, "Notes").split()[:12]:
        note = document.get("Note", number)
        if note is not None:
            yield reader.read(note)


def _with_pick_up(
    root: Element, bars: tuple[WrittenBar, ...], parts: Sequence[WrittenPart]
) -> tuple[WrittenBar, ...]:
    """The bars; a first one that is marked as a pick-up lasts as long as what it holds."""
    if root.find("MasterTrack/Anacrusis") is None or not bars:
        return bars
    ends = (n.offset + n.length for part in parts for n in part.notes if n.bar == 0)
    held = max(ends, default=bars[0].length)
    return (replace(bars[0], length=held), *bars[1:])
