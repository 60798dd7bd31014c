"""Beats and notes of a GPIF document."""

from __future__ import annotations

import re
from fractions import Fraction
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats.linked import Linked
from roboguitarist.formats.musicxml_marks import DYNAMICS
from roboguitarist.formats.note_values import NAMES, dotted
from roboguitarist.formats.written import WrittenNote
from roboguitarist.formats.xml_tree import integer, number, text
from roboguitarist.tablature import MAX_BEND, Technique

_VALUES = {name: length for length, name in NAMES.items()} | {"256th": Fraction(1, 64)}
_ENABLED = {
    "Muted": Technique.DEAD,
    "PalmMuted": Technique.PALM_MUTE,
    "Bended": Technique.BEND,
}
_SLIDES_ON = 1 | 2
_SLIDES_OUT = 4 | 8
_SLIDES_IN = 16 | 32
_STACCATO = 1
_LEFT = {"Open": 0, "I": 1, "M": 2, "A": 3, "C": 4}
_SEMITONES = 1 / 50
"""Bends are written in per cent of a whole tone."""
_BEND_POINTS = (
    ("BendOriginOffset", "BendOriginValue", 0.0),
    ("BendMiddleOffset1", "BendMiddleValue", 0.5),
    ("BendMiddleOffset2", "BendMiddleValue", 0.5),
    ("BendDestinationOffset", "BendDestinationValue", 1.0),
)


def is_grace(beat: Element) -> bool:
    """Whether a beat is a grace note, which takes no time of the bar."""
    return beat.find("GraceNotes") is not None


def rhythm(element: Element | None) -> Fraction:
    """Length in quarter notes.

    Raises:
        TabError: If it is not a note value, or a tuplet of nothing.
    """
    if element is None:
        raise TabError("a beat without a rhythm")
    name = text(element, "NoteValue")
    base = _VALUES.get(name.lower())
    if base is None:
        raise TabError(f"note value {name[:20]!r}", hint="such as Quarter or 16th")
    dot = element.find("AugmentationDot")
    dots = dot.get("count", "1") if dot is not None else "0"
    length = dotted(base, int(dots) if dots in ("1", "2", "3") else 0)
    for kind in ("PrimaryTuplet", "SecondaryTuplet"):
        tuplet = element.find(kind)
        if tuplet is not None:
            actual, normal = (_tuplet(tuplet, part) for part in ("num", "den"))
            length *= Fraction(normal, actual)
    return length


def _tuplet(tuplet: Element, part: str) -> int:
    written = tuplet.get(part) or text(tuplet, part.capitalize())
    if not re.fullmatch(r"[1-9]\d{0,2}", written):
        raise TabError(f"tuplet of {written[:9]!r}")
    return int(written)


class NoteReader:
    """Reads the notes of one beat.

    Args:
        beat: What they have in common.
        place: Index of the bar, and voice.
        time: Offset in the bar and length in quarter notes.
        n_strings: Number of strings; the document counts them from 0, the lowest.
    """

    def __init__(
        self,
        beat: Element,
        place: tuple[int, int],
        time: tuple[Fraction, Fraction],
        n_strings: int,
    ) -> None:
        self._place, self._time, self._n_strings = place, time, n_strings
        self._velocity = DYNAMICS.get(text(beat, "Dynamic").lower())
        self._techniques = _beat_techniques(beat)

    def read(self, note: Element) -> Linked:
        """One note of the beat."""
        properties = {prop.get("name", ""): prop for prop in note.iterfind("Properties/Property")}
        string, fret, pitch = (
            integer(properties[name], value) if name in properties else None
            for name, value in (("String", "String"), ("Fret", "Fret"), ("Midi", "Number"))
        )
        if string is not None and not 0 <= string < self._n_strings:
            raise TabError(f"string {string + 1} (1 to {self._n_strings})")
        slide = _flags(properties.get("Slide"))
        tie = note.find("Tie")
        techniques = self._techniques | _techniques(note, properties, slide)
        written = WrittenNote(
            bar=self._place[0],
            offset=self._time[0],
            length=self._time[1],
            pitch=pitch if pitch is not None and 0 <= pitch <= 127 else None,
            string=None if string is None else self._n_strings - string,
            fret=fret,
            voice=self._place[1],
            tied=tie is not None and tie.get("destination") == "true",
            techniques=tuple(sorted(techniques)),
            left_finger=_LEFT.get(text(note, "LeftFingering")),
            right_finger=_right(text(note, "RightFingering")),
            bend=_bend(properties) if Technique.BEND in techniques else (),
            velocity=self._velocity,
        )
        slurs = _is_enabled(properties.get("HopoOrigin"))
        return Linked(written, slurs=slurs, slides=bool(slide & _SLIDES_ON))


def _right(name: str) -> str | None:
    return name.lower() if name.lower() in ("p", "i", "m", "a", "c") else None


def _is_enabled(prop: Element | None) -> bool:
    return prop is not None and prop.find("Enable") is not None


def _flags(prop: Element | None) -> int:
    return 0 if prop is None else (integer(prop, "Flags") or 0)


def _beat_techniques(beat: Element) -> set[Technique]:
    properties = {prop.get("name", ""): prop for prop in beat.iterfind("Properties/Property")}
    kinds: set[Technique] = set()
    brush = properties.get("Brush")
    ways = {text(beat, "Arpeggio"), "" if brush is None else text(brush, "Direction")}
    if "Down" in ways:
        kinds.add(Technique.STRUM_DOWN)
    elif "Up" in ways:
        kinds.add(Technique.STRUM_UP)
    if "Rasgueado" in properties:
        kinds.add(Technique.RASGUEADO)
    if beat.find("Tremolo") is not None:
        kinds.add(Technique.TREMOLO)
    if is_grace(beat):
        kinds.add(Technique.GRACE)
    return kinds


def _techniques(note: Element, properties: dict[str, Element], slide: int) -> set[Technique]:
    kinds = {kind for name, kind in _ENABLED.items() if _is_enabled(properties.get(name))}
    if _is_enabled(properties.get("Harmonic")) or "HarmonicType" in properties:
        kind = properties.get("HarmonicType")
        natural = kind is None or text(kind, "HType") == "Natural"
        kinds.add(Technique.HARMONIC if natural else Technique.ARTIFICIAL_HARMONIC)
    if slide & _SLIDES_OUT:
        kinds.add(Technique.SLIDE_OUT)
    if slide & _SLIDES_IN:
        kinds.add(Technique.SLIDE_IN)
    if text(note, "Vibrato"):
        kinds.add(Technique.VIBRATO)
    if note.find("LetRing") is not None:
        kinds.add(Technique.LET_RING)
    if note.find("Trill") is not None:
        kinds.add(Technique.TRILL)
    if (integer(note, "Accent") or 0) & _STACCATO:
        kinds.add(Technique.STACCATO)
    return kinds


def _bend(properties: dict[str, Element]) -> tuple[tuple[float, float], ...]:
    """Curve through origin, one or two middle points and destination."""
    curve: dict[float, float] = {}
    for offset, value, usual in _BEND_POINTS:
        height = _float(properties.get(value))
        if height is None or (value == "BendMiddleValue" and offset not in properties):
            continue
        written = _float(properties.get(offset))
        share = usual if written is None else min(1.0, max(0.0, written / 100))
        curve[round(share, 4)] = round(min(MAX_BEND, max(0.0, height * _SEMITONES)), 4)
    return tuple(sorted(curve.items()))


def _float(prop: Element | None) -> float | None:
    found = None if prop is None else number(prop, "Float")
    return None if found is None else float(found)
