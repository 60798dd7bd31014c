"""What stands at a note of a MusicXML file that is written: place, fingers, techniques."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from xml.etree.ElementTree import Element, SubElement

from roboguitarist.tablature import Note, Technique

FORTE = 90
"""MIDI velocity that MusicXML counts as 100 %."""
_ORNAMENTS = {
    Technique.TRILL: ("trill-mark", {}, ""),
    Technique.TREMOLO: ("tremolo", {"type": "single"}, "3"),
}
_TECHNICAL = {
    Technique.HARMONIC: "natural",
    Technique.ARTIFICIAL_HARMONIC: "artificial",
}
_JOINED = {
    Technique.HAMMER_ON: ("hammer-on", "H"),
    Technique.PULL_OFF: ("pull-off", "P"),
}
_OWN_ELEMENT = {
    *_ORNAMENTS, *_TECHNICAL, *_JOINED, Technique.BEND, Technique.SLIDE, Technique.STACCATO,
    Technique.LET_RING, Technique.DEAD, Technique.PALM_MUTE, Technique.STRUM_DOWN,
}  # fmt: skip
_ARPEGGIO = {Technique.STRUM_DOWN: "up", Technique.STRUM_UP: "down"}


def play(note: Note) -> Element | None:
    """How a palm-muted note is played back."""
    if Technique.PALM_MUTE not in note.techniques:
        return None
    element = Element("play")
    SubElement(element, "mute").text = "palm"
    return element


def notations(note: Note, following: Sequence[Technique] = (), *, grace: bool = False) -> Element:
    """Notations of the first or only part of a note.

    Args:
        note: The note.
        following: Techniques of the next note on its string, where joining marks begin.
        grace: Whether the note is written as a grace note.
    """
    element = Element("notations")
    kinds = set(note.techniques) - ({Technique.GRACE} if grace else set())
    if Technique.LET_RING in kinds:
        SubElement(element, "tied", {"type": "let-ring"})
    for kind, techniques in (("stop", kinds), ("start", following)):
        if Technique.SLIDE in techniques:
            SubElement(element, "slide", {"type": kind})
    ornaments = _ornaments(kinds)
    if len(ornaments):
        element.append(ornaments)
    element.append(_technical(note, kinds, following))
    if Technique.STACCATO in kinds:
        SubElement(SubElement(element, "articulations"), "staccato")
    for kind, direction in _ARPEGGIO.items():
        if kind in kinds:
            SubElement(element, "arpeggiate", {"direction": direction})
            break
    return element


def _ornaments(kinds: set[Technique]) -> Element:
    element = Element("ornaments")
    for kind, (name, attributes, text) in _ORNAMENTS.items():
        if kind in kinds:
            SubElement(element, name, attributes).text = text or None
    if Technique.VIBRATO in kinds and Technique.TRILL not in kinds:
        for kind in ("start", "stop"):
            SubElement(element, "wavy-line", {"type": kind})
    return element


def _technical(note: Note, kinds: set[Technique], following: Sequence[Technique]) -> Element:
    element = Element("technical")
    place = {"string": note.string, "fret": note.fret}
    fingers = {"fingering": note.left_finger, "pluck": note.right_finger}
    for name, value in {**fingers, **place}.items():
        if value is not None:
            SubElement(element, name).text = str(value)
    for kind, name in _TECHNICAL.items():
        if kind in kinds:
            SubElement(SubElement(element, "harmonic"), name)
    for kind, (name, letter) in _JOINED.items():
        if kind in kinds:
            SubElement(element, name, {"type": "stop"})
        if kind in following:
            SubElement(element, name, {"type": "start"}).text = letter
    if Technique.BEND in kinds:
        element.extend(_bend(note.bend))
    for kind in sorted(kind for kind in kinds if not _is_written(kind, kinds)):
        SubElement(element, "other-technical").text = kind.value
    return element


def _is_written(kind: Technique, kinds: set[Technique]) -> bool:
    """Whether another element than `other-technical` says it."""
    if kind == Technique.VIBRATO:
        return Technique.TRILL not in kinds
    if kind == Technique.STRUM_UP:
        return Technique.STRUM_DOWN not in kinds
    return kind in _OWN_ELEMENT


def _bend(curve: Sequence[tuple[float, float]]) -> Iterator[Element]:
    """One element for each stretch in which the curve rises or falls."""
    if curve and curve[0][1]:
        bend = _stretch(curve[0][0], curve[0][0], curve[0][1])
        SubElement(bend, "pre-bend")
        yield bend
    for (start, low), (end, high) in pairwise(curve):
        bend = _stretch(start, end, high - low)
        if high < low:
            SubElement(bend, "release")
        yield bend
    if len(curve) < 2 and not (curve and curve[0][1]):
        yield _stretch(0.0, 1.0, curve[0][1] if curve else 0.0)


def _stretch(start: float, end: float, semitones: float) -> Element:
    bend = Element("bend", {"first-beat": f"{100 * start:g}", "last-beat": f"{100 * end:g}"})
    SubElement(bend, "bend-alter").text = f"{semitones:g}"
    return bend
