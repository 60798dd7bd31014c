"""Where on the neck a note of given pitch is played: the cheapest way through the piece.

A beam search goes from onset to onset. It keeps the cheapest ways to have come so far, where the
hand stands in each and which strings still ring, and prices every shape that the next notes can
take. The idea follows path search over fretboard positions (Sayegh, "Fingering for string
instruments with the optimum path paradigm", Computer Music Journal 13(3), 1989).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from roboguitarist.tablature import N_STRINGS, STANDARD_TUNING

N_FRETS = 20
"""Frets of the default guitar, counted from the nut."""
SPAN, STRETCH = 3, 4
"""Highest minus lowest fret of a shape: in one hand position, and stretched."""
BEAM_WIDTH = 16
N_SHAPES = 12
N_FINGERS = 4
MAX_CHORD = 24
"""Notes of one onset that are considered at all."""

# Costs in frets of hand movement.
_SHIFT = 1.0
_HEIGHT = 0.15  # for each fret up the neck, for each note
_STOPPED = 0.3  # for each note that needs a finger
_STRETCHED = 4.0
_CUT = 2.5  # a ringing string is taken for another pitch
_TORN = 3.0  # held notes and new notes are out of one hand's reach
_DOUBLED = 1.5  # a ringing pitch is played again on another string


class Place(NamedTuple):
    """A string, 1 to 6, and a fret counted from the capo."""

    string: int
    fret: int


@dataclass(frozen=True, slots=True)
class Sound:
    """A note to place.

    Attributes:
        onset, end: In any unit of time.
        pitch: MIDI pitch.
        string, fret: Given in advance, or None.
        finger: Left finger marked in the score: 0 asks for an open string.
    """

    onset: float
    end: float
    pitch: int
    string: int | None = None
    fret: int | None = None
    finger: int | None = None


class _Ringing(NamedTuple):
    end: float
    fret: int
    pitch: int


class _Way(NamedTuple):
    """A way to have come so far: its cost, the index finger's fret, what rings, all shapes."""

    cost: float
    position: int
    ringing: tuple[_Ringing | None, ...]
    past: tuple | None


_Shape = tuple[Place | None, ...]


def fold(
    pitch: int, tuning: Sequence[int] = STANDARD_TUNING, capo: int = 0, n_frets: int = N_FRETS
) -> int:
    """The same pitch class moved by octaves into the guitar's range."""
    lowest, highest = min(tuning) + capo, max(tuning) + n_frets
    while pitch < lowest:
        pitch += 12
    while pitch > highest:
        pitch -= 12
    return pitch


def arrange(
    sounds: Sequence[Sound],
    tuning: Sequence[int] = STANDARD_TUNING,
    capo: int = 0,
    n_frets: int = N_FRETS,
) -> list[Place | None]:
    """Give every note a string and a fret.

    Notes of one onset take different strings and frets within one hand position, stretched by
    one fret where nothing else will do. Low positions, short ways of the hand and strings that
    do not ring are preferred. Places given in advance are kept.

    Args:
        sounds: Sorted by onset.
        tuning: MIDI pitches of the six open strings, string 1 first.
        capo: Fret of the capo.
        n_frets: Number of frets counted from the nut.

    Returns:
        A place for each note; None where the notes of that onset leave no string in reach. The
        highest and then the lowest note of a chord are the last to go.
    """
    frets = range(n_frets - capo + 1)
    open_pitches = [pitch + capo for pitch in tuning]
    beam = [_Way(0.0, 1, (None,) * N_STRINGS, None)]
    for onset, group in groupby(sounds, key=lambda sound: sound.onset):
        chord = tuple(group)
        shapes = _shapes([_candidates(sound, open_pitches, frets) for sound in chord], chord)
        beam = _advance(beam, onset, chord, shapes)
    return _retrace(min(beam, key=lambda way: way.cost))


def _candidates(sound: Sound, open_pitches: Sequence[int], frets: range) -> list[Place]:
    if sound.string is not None and sound.fret is not None:
        return [Place(sound.string, sound.fret)]
    places = [
        Place(string, sound.pitch - pitch)
        for string, pitch in enumerate(open_pitches, 1)
        if sound.pitch - pitch in frets
    ]
    wanted = [
        place
        for place in places
        if sound.string in (None, place.string) and sound.fret in (None, place.fret)
    ]
    if sound.finger is not None:
        wanted = [p for p in wanted if (p.fret == 0) == (sound.finger == 0)] or wanted
    return wanted or places


def _shapes(options: list[list[Place]], chord: Sequence[Sound]) -> list[_Shape]:
    """The cheapest shapes for the notes of one onset, leaving out notes only if need be."""
    fixed = [k for k, s in enumerate(chord) if s.string is not None and s.fret is not None]
    free = sorted(set(range(len(chord))) - set(fixed), key=lambda k: -chord[k].pitch)
    wanted = fixed + free[:1] + free[-1:] * (len(free) > 1) + free[1:-1]
    given = [options[k][0] for k in fixed]
    chosen: list[int] = []
    for k in wanted[:MAX_CHORD]:
        if next(_fits(options, [*chosen, k], given, STRETCH), None) is not None:
            chosen.append(k)
    fits = list(_fits(options, chosen, given, SPAN)) or list(_fits(options, chosen, given, STRETCH))
    return sorted(fits, key=_shape_cost)[:N_SHAPES]


def _fits(
    options: list[list[Place]], chosen: list[int], given: list[Place], span: int
) -> Iterator[_Shape]:
    """All ways to place the chosen notes on different strings within a hand's reach.

    Places given in advance may ask for more reach or fingers than a hand has.
    """
    reach = max(span, _span(given))
    fingers = max(N_FINGERS, _fingers(given))

    def extend(shape: dict[int, Place], rest: list[int]) -> Iterator[_Shape]:
        if not rest:
            yield tuple(shape.get(k) for k in range(len(options)))
            return
        used = {place.string for place in shape.values()}
        for place in options[rest[0]]:
            trial = {**shape, rest[0]: place}
            places = list(trial.values())
            if place.string not in used and _span(places) <= reach and _fingers(places) <= fingers:
                yield from extend(trial, rest[1:])

    yield from extend({}, chosen)


def _span(places: Sequence[Place]) -> int:
    stopped = [place.fret for place in places if place.fret]
    return max(stopped) - min(stopped) if stopped else 0


def _fingers(places: Sequence[Place]) -> int:
    """Fingers that a shape needs; the index may lie across all strings if none is open."""
    stopped = [place.fret for place in places if place.fret]
    if len(stopped) < len(places) or not stopped:
        return len(stopped)
    return 1 + sum(fret > min(stopped) for fret in stopped)


def _shape_cost(shape: _Shape) -> float:
    places = [place for place in shape if place is not None]
    cost = sum(_HEIGHT * place.fret + _STOPPED * (place.fret > 0) for place in places)
    return cost + _STRETCHED * max(0, _span(places) - SPAN)


def _advance(
    beam: list[_Way], onset: float, chord: Sequence[Sound], shapes: list[_Shape]
) -> list[_Way]:
    """The cheapest ways one onset further, one for each state of the hand."""
    best: dict[tuple, _Way] = {}
    for shape in shapes:
        static = _shape_cost(shape)
        for way in beam:
            step = _step(way, onset, chord, shape, static)
            state = step.position, step.ringing
            if state not in best or step.cost < best[state].cost:
                best[state] = step
    return sorted(best.values(), key=lambda way: way.cost)[:BEAM_WIDTH]


def _step(way: _Way, onset: float, chord: Sequence[Sound], shape: _Shape, static: float) -> _Way:
    ringing = [r if r is not None and r.end > onset else None for r in way.ringing]
    cost = way.cost + static
    sounding = {r.pitch: string for string, r in enumerate(ringing, 1) if r is not None}
    placed = [(s, place) for s, place in zip(chord, shape, strict=True) if place is not None]
    for sound, place in placed:
        before = ringing[place.string - 1]
        cost += _CUT * (before is not None and before.pitch != sound.pitch)
        cost += _DOUBLED * (sounding.get(sound.pitch, place.string) != place.string)
    for sound, place in placed:
        ringing[place.string - 1] = _Ringing(sound.end, place.fret, sound.pitch)
    stopped = [place.fret for _, place in placed if place.fret]
    position = way.position
    if stopped:
        position = max(1, min(max(position, max(stopped) - SPAN), *stopped))
        held = [r.fret for r in ringing if r is not None and r.fret]
        cost += _TORN * (max(held) - min(held) > SPAN) + _SHIFT * abs(position - way.position)
    return _Way(cost, position, tuple(ringing), (way.past, shape))


def _retrace(way: _Way) -> list[Place | None]:
    shapes: list[_Shape] = []
    past = way.past
    while past is not None:
        past, shape = past
        shapes.append(shape)
    return [place for shape in reversed(shapes) for place in shape]
