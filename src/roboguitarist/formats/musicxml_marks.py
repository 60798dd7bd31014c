"""Marks on a MusicXML note: techniques and fingers."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from roboguitarist.formats.xml_tree import text
from roboguitarist.tablature import Technique

_NOTATIONS = {
    "technical/bend": Technique.BEND,
    "technical/harmonic": Technique.HARMONIC,
    "technical/vibrato": Technique.VIBRATO,
    "ornaments/tremolo": Technique.TREMOLO,
    "ornaments/trill-mark": Technique.TRILL,
    "articulations/staccato": Technique.STACCATO,
    "articulations/staccatissimo": Technique.STACCATO,
    "tied[@type='let-ring']": Technique.LET_RING,
    # Written on both notes that they join; the second is the one played that way.
    "technical/hammer-on[@type='stop']": Technique.HAMMER_ON,
    "technical/pull-off[@type='stop']": Technique.PULL_OFF,
    "slide[@type='stop']": Technique.SLIDE,
    "glissando[@type='stop']": Technique.SLIDE,
}
_DEAD_HEADS = ("x", "cross", "cluster", "circle-x")
_RIGHT_FINGERS = ("p", "i", "m", "a", "c")


def techniques(note: Element) -> tuple[Technique, ...]:
    """How a note is to be played, in alphabetical order."""
    found: set[Technique] = set()
    for notations in note.iterfind("notations"):
        found |= {kind for path, kind in _NOTATIONS.items() if notations.find(path) is not None}
        trill_line = notations.find("ornaments/trill-mark") is not None
        if notations.find("ornaments/wavy-line") is not None and not trill_line:
            found.add(Technique.VIBRATO)
        found |= _strum(notations)
    if text(note, "notehead") in _DEAD_HEADS:
        found.add(Technique.DEAD)
    for mute in note.iterfind("play/mute"):
        if text(mute) in ("palm", "straight"):
            found.add(Technique.PALM_MUTE if text(mute) == "palm" else Technique.DEAD)
    if note.find("grace") is not None:
        found.add(Technique.GRACE)
    return tuple(sorted(found))


def _strum(notations: Element) -> set[Technique]:
    """An arpeggio upwards in pitch is a stroke downwards, from the bass string on."""
    arpeggio = notations.find("arpeggiate")
    if arpeggio is None:
        return set()
    down = arpeggio.get("direction", "up") == "up"
    return {Technique.STRUM_DOWN if down else Technique.STRUM_UP}


def fingers(note: Element) -> tuple[int | None, str | None]:
    """Left finger 0 to 4 and right finger p, i, m, a or c as marked, None where not."""
    left = [text(mark) for mark in note.iterfind("notations/technical/fingering")]
    right = [text(mark).lower() for mark in note.iterfind("notations/technical/pluck")]
    return (
        next((int(mark) for mark in left if mark in ("0", "1", "2", "3", "4")), None),
        next((mark for mark in right if mark in _RIGHT_FINGERS), None),
    )
