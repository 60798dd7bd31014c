"""Marks on a MusicXML note: techniques and fingers."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from roboguitarist.formats.xml_tree import decimal, descendants, number, text
from roboguitarist.tablature import MAX_BEND, Technique

_NOTATIONS = {
    "technical/bend": Technique.BEND,
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
    for notations in note.findall("notations"):
        marks = _marks(notations)
        found |= {_NOTATIONS[mark] for mark in marks if mark in _NOTATIONS}
        if "ornaments/wavy-line" in marks and "ornaments/trill-mark" not in marks:
            found.add(Technique.VIBRATO)
        found |= _strum(notations) | _harmonic(notations) | _in_words(notations)
    if text(note, "notehead") in _DEAD_HEADS:
        found.add(Technique.DEAD)
    for mute in descendants(note, "play/mute"):
        if text(mute) in ("palm", "straight"):
            found.add(Technique.PALM_MUTE if text(mute) == "palm" else Technique.DEAD)
    if note.find("grace") is not None:
        found.add(Technique.GRACE)
    return tuple(sorted(found))


def _marks(notations: Element) -> set[str]:
    """Paths of what stands in a `<notations>`, one and two deep, without and with their type."""
    marks = set()
    for group in notations:
        marks |= {group.tag, f"{group.tag}[@type='{group.get('type')}']"}
        for mark in group:
            path = f"{group.tag}/{mark.tag}"
            marks |= {path, f"{path}[@type='{mark.get('type')}']"}
    return marks


def _harmonic(notations: Element) -> set[Technique]:
    artificial = {
        harmonic.find("artificial") is not None
        for harmonic in descendants(notations, "technical/harmonic")
    }
    kinds = {True: Technique.ARTIFICIAL_HARMONIC, False: Technique.HARMONIC}
    return {kinds[kind] for kind in artificial}


def _in_words(notations: Element) -> set[Technique]:
    """What MusicXML has no element for, by its name in `Technique`."""
    words = descendants(notations, "technical/other-technical")
    said = {text(mark).casefold() for mark in words}
    return {kind for kind in Technique if kind.value in said} if said else set()


def _strum(notations: Element) -> set[Technique]:
    """An arpeggio upwards in pitch is a stroke downwards, from the bass string on."""
    arpeggio = notations.find("arpeggiate")
    if arpeggio is None:
        return set()
    down = arpeggio.get("direction", "up") == "up"
    return {Technique.STRUM_DOWN if down else Technique.STRUM_UP}


def fingers(note: Element) -> tuple[int | None, str | None]:
    """Left finger 0 to 4 and right finger p, i, m, a or c as marked, None where not."""
    left = [text(mark) for mark in descendants(note, "notations/technical/fingering")]
    right = [text(mark).lower() for mark in descendants(note, "notations/technical/pluck")]
    return (
        next((int(mark) for mark in left if mark in ("0", "1", "2", "3", "4")), None),
        next((mark for mark in right if mark in _RIGHT_FINGERS), None),
    )


DYNAMICS = {
    "pppp": 10, "ppp": 23, "pp": 36, "p": 49, "mp": 64, "mf": 80, "f": 96, "ff": 112,
    "fff": 122, "ffff": 127,
}  # fmt: skip
"""MIDI velocities of the marks, evenly spread."""
_FORTE = 0.90  # MusicXML counts in per cent of a forte, which has MIDI velocity 90


def velocity(percent: str | None) -> int | None:
    """MIDI velocity from a `dynamics` attribute, which is a percentage of forte.

    Raises:
        TabError: If it is not a number.
    """
    if percent is None:
        return None
    return min(127, max(1, round(float(decimal(percent, "dynamics")) * _FORTE)))


def bend(note: Element) -> tuple[tuple[float, float], ...]:
    """Curve of a bend: shares of the duration, and semitones above the fret.

    Each element is a rise or a release by so many semitones; those that do not say when share
    the time of the note evenly.
    """
    bends = descendants(note, "notations/technical/bend")
    curve: list[tuple[float, float]] = []
    for k, element in enumerate(bends):
        height = curve[-1][1] if curve else 0.0
        step = float(number(element, "bend-alter") or 0)
        if element.find("release") is not None:
            step = -abs(step) or -height
        start, end = _times(element, k, len(bends))
        start = max(start, curve[-1][0] if curve else 0.0)
        after = min(MAX_BEND, max(0.0, height + step))
        if element.find("pre-bend") is not None:
            curve.append((start, after))
            continue
        if not curve or curve[-1] != (start, height):
            curve.append((start, height))
        curve.append((max(start, end), after))
    return _rounded(curve) if any(height for _, height in curve) else ()


def _times(bend: Element, k: int, n_bends: int) -> tuple[float, float]:
    times = []
    for name, usual in (("first-beat", k / n_bends), ("last-beat", (k + 1) / n_bends)):
        written = bend.get(name)
        share = usual if written is None else float(decimal(written, name)) / 100
        times.append(min(1.0, max(0.0, share)))
    return times[0], times[1]


def _rounded(curve: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    return tuple((round(share, 4), round(height, 4)) for share, height in curve)
