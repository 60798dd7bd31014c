"""Notes of a beat that PyGuitarPro read."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from roboguitarist.formats.linked import Linked
from roboguitarist.formats.musicxml_part import GRACE_LENGTH
from roboguitarist.formats.written import WrittenNote
from roboguitarist.tablature import MAX_BEND, Technique

_FLAGS = {
    "letRing": Technique.LET_RING,
    "palmMute": Technique.PALM_MUTE,
    "staccato": Technique.STACCATO,
    "vibrato": Technique.VIBRATO,
    "tremoloPicking": Technique.TREMOLO,
    "trill": Technique.TRILL,
    "bend": Technique.BEND,
}
_SLIDES_OUT = {"outDownwards", "outUpwards"}
_SLIDES_IN = {"intoFromAbove", "intoFromBelow"}
_SLIDES_ON = {"shiftSlideTo", "legatoSlideTo"}
_STROKES = {"up": Technique.STRUM_UP, "down": Technique.STRUM_DOWN}
_LEFT = {"index": 1, "middle": 2, "annular": 3, "little": 4}
_RIGHT = {"thumb": "p", "index": "i", "middle": "m", "annular": "a", "little": "c"}
_POSITIONS = 12
"""Steps in the duration of a note in which bends are written; their heights are semitones."""


def notes_of(
    beat: Any, place: tuple[int, int], time: tuple[Fraction, Fraction]
) -> Iterator[Linked]:
    """Notes of a beat, and grace notes before them.

    Args:
        beat: As PyGuitarPro has it.
        place: Index of the bar, and voice.
        time: Offset in the bar and length in quarter notes.
    """
    common = _beat_techniques(beat)
    for note in beat.notes:
        if note.type.name == "rest":
            continue
        offset, length = time
        grace = note.effect.grace
        if grace is not None:
            late = GRACE_LENGTH if grace.isOnBeat else Fraction(0)
            offset, length = offset + late, max(GRACE_LENGTH, length - late)
            yield _grace(note, place, offset - GRACE_LENGTH)
        yield _linked(note, place, (offset, length), common)


def _grace(note: Any, place: tuple[int, int], offset: Fraction) -> Linked:
    grace = note.effect.grace
    kinds = {Technique.GRACE} | ({Technique.DEAD} if grace.isDead else set())
    written = WrittenNote(
        bar=place[0],
        offset=offset,
        length=GRACE_LENGTH,
        string=note.string,
        fret=grace.fret,
        voice=place[1],
        techniques=tuple(sorted(kinds)),
        velocity=_velocity(grace.velocity),
    )
    transition = grace.transition.name
    return Linked(written, slurs=transition == "hammer", slides=transition == "slide")


def _linked(
    note: Any, place: tuple[int, int], time: tuple[Fraction, Fraction], common: set[Technique]
) -> Linked:
    effect = note.effect
    slides = {slide.name for slide in effect.slides}
    kinds = common | {kind for name, kind in _FLAGS.items() if getattr(effect, name)}
    kinds |= {Technique.DEAD} if note.type.name == "dead" else set()
    kinds |= {Technique.SLIDE_OUT} if slides & _SLIDES_OUT else set()
    kinds |= {Technique.SLIDE_IN} if slides & _SLIDES_IN else set()
    if effect.harmonic is not None:
        natural = type(effect.harmonic).__name__ == "NaturalHarmonic"
        kinds.add(Technique.HARMONIC if natural else Technique.ARTIFICIAL_HARMONIC)
    written = WrittenNote(
        bar=place[0],
        offset=time[0],
        length=time[1],
        string=note.string,
        fret=note.value,
        voice=place[1],
        tied=note.type.name == "tie",
        techniques=tuple(sorted(kinds)),
        left_finger=_LEFT.get(effect.leftHandFinger.name),
        right_finger=_RIGHT.get(effect.rightHandFinger.name),
        bend=_curve(effect.bend),
        velocity=_velocity(note.velocity),
    )
    return Linked(written, slurs=effect.hammer, slides=bool(slides & _SLIDES_ON))


def _beat_techniques(beat: Any) -> set[Technique]:
    stroke = beat.effect.stroke  # None in broken files
    name = stroke.direction.name if stroke else ""
    kinds = {_STROKES[name]} if name in _STROKES else set()
    kinds |= {Technique.RASGUEADO} if beat.effect.hasRasgueado else set()
    return kinds | ({Technique.VIBRATO} if beat.effect.vibrato else set())


def _curve(bend: Any) -> tuple[tuple[float, float], ...]:
    if bend is None:
        return ()
    points = {
        round(min(1.0, max(0.0, point.position / _POSITIONS)), 4): point.value
        for point in bend.points
    }
    return tuple(
        (share, float(min(MAX_BEND, max(0, value)))) for share, value in sorted(points.items())
    )


def _velocity(velocity: int) -> int:
    return min(127, max(1, velocity))
