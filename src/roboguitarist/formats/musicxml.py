"""MusicXML, partwise and timewise, to the score as written.

Format: https://www.w3.org/2021/06/musicxml40/
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from xml.etree.ElementTree import Element, SubElement

from roboguitarist.errors import TabError
from roboguitarist.formats import xml_tree
from roboguitarist.formats.musicxml_bars import RawBar, merge
from roboguitarist.formats.musicxml_part import PartReader
from roboguitarist.formats.musicxml_staves import one_staff
from roboguitarist.formats.written import WrittenPart, WrittenScore
from roboguitarist.formats.xml_tree import text
from roboguitarist.tablature import STANDARD_TUNING, Technique

_DRUM_CHANNEL = 10
_BASS_PROGRAMS = range(33, 41)  # General MIDI, counted from 1
_KEYBOARD_PROGRAMS = range(1, 9)
_HIGHEST_BASS_STRING = 52  # string 1 of a bass with six strings is a C3


def read(source: bytes | Element) -> WrittenScore:
    """Read a MusicXML document, from its text or its root.

    Raises:
        TabError: If it is not MusicXML, or an element makes no sense.
    """
    root = xml_tree.parse(source) if isinstance(source, bytes) else source
    if root.tag == "score-timewise":
        root = _partwise(root)
    if root.tag != "score-partwise":
        raise TabError(f"not a MusicXML score: the root element is {root.tag[:40]!r}")
    headers = {header.get("id"): header for header in root.iterfind("part-list/score-part")}
    parts, bars = [], []
    for k, element in enumerate(root.iterfind("part"), 1):
        header = headers.get(element.get("id"), Element("score-part"))
        name = text(header, "part-name") or element.get("id") or str(k)
        try:
            part, part_bars = _read_part(element, header, name)
        except TabError as error:
            raise TabError(
                error.reason, part=name, bar=error.bar, beat=error.beat, hint=error.hint
            ) from error
        parts.append(part)
        bars.append(part_bars)
    return WrittenScore(
        bars=merge(bars),
        parts=tuple(parts),
        title=text(root, "work/work-title") or text(root, "movement-title"),
        composer=text(root, "identification/creator[@type='composer']"),
        source=text(root, "identification/source"),
        grade=text(root, "identification/miscellaneous/miscellaneous-field[@name='grade']"),
    )


def _partwise(timewise: Element) -> Element:
    """The same score with parts outside and measures inside."""
    root = Element("score-partwise")
    root.extend(child for child in timewise if child.tag != "measure")
    parts: dict[str, Element] = {}
    for measure in timewise.iterfind("measure"):
        for entry in measure.iterfind("part"):
            name = entry.get("id", "")
            if name not in parts:
                parts[name] = SubElement(root, "part", {"id": name})
            SubElement(parts[name], "measure", measure.attrib).extend(entry)
    return root


def _read_part(element: Element, header: Element, name: str) -> tuple[WrittenPart, list[RawBar]]:
    reader = PartReader()
    for measure in element.iterfind("measure"):
        reader.read(measure)
    details, notes = reader.details, reader.notes
    keyboard = xml_tree.integer(header, "midi-instrument/midi-program") in _KEYBOARD_PROGRAMS
    if not details.tab_staves and (keyboard or len({note.staff for note in notes}) > 1):
        notes = [replace(note, left_finger=None, right_finger=None) for note in notes]
    part = WrittenPart(
        name=name,
        notes=one_staff(notes, details.tab_staves),
        n_strings=details.n_strings(max((note.string or 0 for note in notes), default=0)),
        tuning=details.tuning(),
        capo=details.capo,
        warnings=reader.warnings(),
    )
    part = replace(
        part,
        obstacle=_obstacle(header, part, reader.n_unpitched),
        warnings=(*part.warnings, *_contradictions(part, reader.bars)),
    )
    return part, reader.bars


def _contradictions(part: WrittenPart, bars: list[RawBar]) -> Iterator[str]:
    """Say whether string and fret, which are followed, give other notes than the pitches."""
    tuning = part.tuning or STANDARD_TUNING
    wrong = [
        note
        for note in part.notes
        if note.string is not None
        and note.fret is not None
        and note.pitch is not None
        and 1 <= note.string <= len(tuning)
        and (tuning[note.string - 1] + part.capo + note.fret - note.pitch) % 12
        and Technique.HARMONIC not in note.techniques
    ]
    if wrong:
        first = f"bar {bars[wrong[0].bar].number}, beat {float(wrong[0].offset + 1):g}"
        yield f"{first}: string and fret contradict the pitch in {len(wrong)} notes, the tab counts"


def _obstacle(header: Element, part: WrittenPart, n_unpitched: int) -> str:
    channel = xml_tree.integer(header, "midi-instrument/midi-channel")
    if channel == _DRUM_CHANNEL or (n_unpitched and not part.notes):
        return "it is a drum part"
    program = xml_tree.integer(header, "midi-instrument/midi-program")
    sound = text(header, "score-instrument/instrument-sound")
    named = re.search(r"\bbass\b", part.name, re.IGNORECASE)
    low = part.tuning is not None and part.tuning[0] < _HIGHEST_BASS_STRING
    is_bass = program in _BASS_PROGRAMS or sound.startswith("pluck.bass") or named
    if low or (is_bass and not part.tuning):
        return "it is a bass part"
    return ""
