"""Exercises of several fingers together: chords, barres, arpeggios, pairs of notes, shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import cycle, repeat
from math import ceil

from roboguitarist.exercises.lines import FASTEST_PER_S, MAJOR, MINOR, Place, pitch_class
from roboguitarist.exercises.shapes import BARRE_CHORDS, GRIPS, OPEN_CHORDS, POWER_CHORDS, Shape
from roboguitarist.exercises.sheet import Sheet, Stroke, joined
from roboguitarist.tablature import STANDARD_TUNING

HIGHEST_ROOT = 12
"""Movable shapes go with their lowest fret up to here."""
RINGING = tuple(shape for shape in OPEN_CHORDS if shape.positions and not shape.barres)
"""Open chords whose fingers can come down one by one and stay."""
PATTERNS = ("pima", "pami", "pimami", "pimaim", "pimiaimi", "pmiaimim", "paimpmia")
"""Arpeggios by the fingers of the right hand."""


def placed(sheet: Sheet, shapes: tuple[Shape, ...]) -> Shape:
    """One of the movable shapes at a fret of the neck where its fingers are in easy reach."""
    shape = sheet.pick(shapes)
    lowest = 1 if shape.positions else 2
    highest = min(HIGHEST_ROOT, sheet.highest_fret - shape.highest_fret + 1)
    return shape.at(sheet.between(lowest, highest))


def changes(
    sheet: Sheet, shapes: Iterable[Shape], changes_per_s: tuple[float, float], strikes: float
) -> Iterator[Stroke]:
    """Chords one after the other, each struck once or several times.

    Args:
        sheet: What to fill.
        shapes: The chords, as many as are needed.
        changes_per_s: How often the chord changes, least and most.
        strikes: How often a chord is struck at most, per second.
    """
    length = sheet.value(*changes_per_s)
    most = min(4, int(length * 60.0 / sheet.tempo * strikes))
    each = sheet.between(1, max(1, most))
    value = length / each
    for k, shape in zip(range(ceil(sheet.quarters / length)), shapes, strict=False):
        for strike in range(k * each, (k + 1) * each):
            for string, fret, finger in shape.stops:
                yield Stroke(strike * value, string, fret, value, finger)


def _draws(draw: Callable[[], Shape]) -> Iterator[Shape]:
    while True:
        yield draw()


def open_chords(sheet: Sheet) -> Iterator[Stroke]:
    """Common chords with open strings, at most one and a half changes a second."""
    return changes(sheet, _draws(lambda: sheet.pick(OPEN_CHORDS)), (0.25, 1.5), 4.0)


def barre_chords(sheet: Sheet) -> Iterator[Stroke]:
    """Full and partial barres at frets 1 to 12."""
    return changes(sheet, _draws(lambda: placed(sheet, BARRE_CHORDS)), (0.25, 1.2), 4.0)


def power_chords(sheet: Sheet) -> Iterator[Stroke]:
    """Roots with fifth and octave along the neck."""
    return changes(sheet, _draws(lambda: placed(sheet, POWER_CHORDS)), (0.5, 2.5), 5.0)


def random_shapes(sheet: Sheet) -> Iterator[Stroke]:
    """Shapes of one to four fingers that nobody has named."""
    return changes(sheet, _draws(lambda: random_shape(sheet)), (0.5, 2.0), 4.0)


def slow_changes(sheet: Sheet) -> Iterator[Stroke]:
    """A few chords of any sort in turns, two to four seconds each."""
    return changes(sheet, cycle(_palette(sheet)), (0.25, 0.6), 2.0)


def fast_changes(sheet: Sheet) -> Iterator[Stroke]:
    """A few chords of any sort in turns, up to three a second."""
    return changes(sheet, cycle(_palette(sheet)), (1.0, 3.0), 5.0)


def _palette(sheet: Sheet) -> list[Shape]:
    sources: tuple[Callable[[], Shape], ...] = (
        lambda: sheet.pick(OPEN_CHORDS),
        lambda: placed(sheet, BARRE_CHORDS),
        lambda: placed(sheet, POWER_CHORDS),
        lambda: placed(sheet, GRIPS),
    )
    return [sheet.pick(sources)() for _ in range(sheet.between(2, 4))]


def random_shape(sheet: Sheet) -> Shape:
    """One to four fingers within four frets, at times two or three on one fret, on any strings.

    Each finger is at its own fret or one beside it, none crosses another, and strings without
    a finger sound open now and then.
    """
    lowest = sheet.between(1, sheet.highest_fret - 3)
    fingers = sorted(sheet.rng.permutation(4)[: sheet.between(1, 4)].tolist())
    frets = sorted(lowest + min(max(f + sheet.pick((-1, 0, 0, 0, 1)), 0), 3) for f in fingers)
    strings = [s + 1 for s in sheet.rng.permutation(6).tolist()]
    stopped = sorted(zip(frets, strings, strict=False), key=lambda stop: (stop[0], -stop[1]))
    stops = [(string, fret, f + 1) for (fret, string), f in zip(stopped, fingers, strict=True)]
    stops += [(string, 0, 0) for string in strings[len(stops) :] if sheet.chance(0.15)]
    return Shape("random", tuple(sorted(stops)))


def arpeggios(sheet: Sheet) -> Iterator[Stroke]:
    """Chords without barre, their strings one by one in patterns of p, i, m and a."""
    pattern, value = sheet.pick(PATTERNS), sheet.value(1.5, FASTEST_PER_S)
    return joined(sheet, lambda part: _broken(part, pattern, value), sheet.pick((1, 2)))


def _broken(sheet: Sheet, pattern: str, value: float) -> Iterator[Stroke]:
    """One chord: p on its lower strings in turns, i, m, a on its upper three; all ring on."""
    shape = sheet.pick(RINGING) if sheet.chance(0.4) else placed(sheet, GRIPS)
    *basses, i, m, a = shape.stops[::-1]
    strings = {"p": cycle(basses or [i]), "i": repeat(i), "m": repeat(m), "a": repeat(a)}
    for k, letter in zip(range(ceil(sheet.quarters / value)), cycle(pattern), strict=False):
        string, fret, finger = next(strings[letter])
        yield Stroke(k * value, string, fret, sheet.quarters - k * value, finger)


PAIRS = {
    "thirds": (2, ((6, 5), (5, 4), (4, 3), (3, 2), (2, 1))),
    "sixths": (5, ((6, 4), (5, 3), (4, 2), (3, 1))),
    "octaves": (7, ((6, 4), (5, 3), (4, 2), (3, 1))),
}
"""Steps of the scale between the two notes, and the pairs of strings that have them in reach."""


def dyads(sheet: Sheet) -> Iterator[Stroke]:
    """Thirds, sixths or octaves of a scale, along one pair of strings."""
    return joined(sheet, _dyad_phrase, sheet.pick((2, 4)))


def _dyad_phrase(sheet: Sheet) -> Iterator[Stroke]:
    pairs = _pairs(sheet)
    k = sheet.between(0, len(pairs) - 1)
    for beat, value in sheet.rhythm(0.7, 3.0):
        for string, fret in pairs[k]:
            yield Stroke(beat, string, fret, value)
        k = min(max(0, k + sheet.pick((-2, -1, -1, 1, 1, 2))), len(pairs) - 1)


def _pairs(sheet: Sheet) -> list[tuple[Place, Place]]:
    """All such pairs of one scale from low to high, on one pair of strings."""
    steps, string_pairs = sheet.pick(tuple(PAIRS.values()))
    lower, upper = sheet.pick(string_pairs)
    tonic, scale = sheet.between(0, 11), sheet.pick((MAJOR, MINOR))
    ladder = [tone + octave for octave in (0, 12) for tone in scale]
    pairs = []
    for fret in range(sheet.highest_fret + 1):
        degree = (pitch_class((lower, fret)) - tonic) % 12
        if degree not in scale:
            continue
        rise = ladder[scale.index(degree) + steps] - degree
        above = fret + rise - STANDARD_TUNING[upper - 1] + STANDARD_TUNING[lower - 1]
        if 0 <= above <= sheet.highest_fret:
            pairs.append(((lower, fret), (upper, above)))
    return pairs
