"""Hand shapes as data: what the left hand of a guitarist holds, with its usual fingers."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

from roboguitarist.fingering import REACH_FRETS


@dataclass(frozen=True)
class Shape:
    """What is plucked of one chord, and which finger stops it.

    Attributes:
        name: Name of the chord, of a movable shape that of the chord with its lowest fret at 1.
        stops: String (1 to 6), fret (0 open) and left finger (0 open, 1 to 4) of each sounding
            string, string 1 first. A finger that comes twice lies flat (barre).
    """

    name: str
    stops: tuple[tuple[int, int, int], ...]

    @cached_property
    def highest_fret(self) -> int:
        """Highest fret that it stops, 0 if it stops none."""
        return max(fret for _, fret, _ in self.stops)

    @cached_property
    def barres(self) -> frozenset[int]:
        """Fingers that stop several strings."""
        count = Counter(finger for _, _, finger in self.stops if finger)
        return frozenset(finger for finger, n in count.items() if n > 1)

    @cached_property
    def positions(self) -> range:
        """Frets where the index finger can stand with every finger in easy reach of its fret."""
        homes = [
            (fret - finger + 1, 0 if finger in self.barres else REACH_FRETS)
            for _, fret, finger in self.stops
            if finger
        ]
        lowest = max(home - slack for home, slack in homes)
        return range(max(1, lowest), min(home + slack for home, slack in homes) + 1)

    def at(self, fret: int) -> Shape:
        """The movable shape with its lowest fret at `fret`."""
        moved = ((string, place + fret - 1, finger) for string, place, finger in self.stops)
        return Shape(self.name, tuple(moved))


def read(line: str) -> Shape:
    """Shape of a line such as `C x32010 x32010`: name, then frets and fingers from string 6 to 1.

    Raises:
        ValueError: If it is not such a line.
    """
    name, frets, fingers = line.split()
    diagram = zip(range(6, 0, -1), frets, fingers, strict=True)
    stops = ((string, int(fret), int(finger)) for string, fret, finger in diagram if fret != "x")
    return Shape(name, tuple(stops)[::-1])


def _table(text: str) -> tuple[Shape, ...]:
    return tuple(read(line) for line in text.strip().splitlines())


OPEN_CHORDS = _table("""
C      x32010 x32010
C/G    332010 342010
C7     x32310 x32410
Cmaj7  x32000 x32000
Cadd9  x32030 x21030
D      xx0232 xx0132
D/F#   200232 100243
D7     xx0212 xx0213
Dmaj7  xx0222 xx0123
Dm     xx0231 xx0231
Dm7    xx0211 xx0211
Dsus2  xx0230 xx0130
Dsus4  xx0233 xx0134
E      022100 023100
E7     020100 020100
Emaj7  021100 031200
Em     022000 023000
Em7    022030 023040
Esus4  022200 012300
Fmaj7  xx3210 xx3210
G      320003 210003
G      320033 210034
G7     320001 320001
Gmaj7  320002 310002
A      x02220 x01230
A7     x02020 x01020
Amaj7  x02120 x02130
Am     x02210 x02310
Am7    x02010 x02010
Asus2  x02200 x01200
Asus4  x02230 x01240
B7     x21202 x21304
""")
"""Common chords with open strings, in the first four frets."""

BARRE_CHORDS = _table("""
F      133211 134211
Fm     133111 134111
F7     131211 131211
Fm7    131111 131111
Fmaj7  132211 142311
Fsus4  133311 123411
F7sus4 131311 131411
Bb     x13331 x12341
Bb     x13331 x13331
Bbm    x13321 x13421
Bb7    x13131 x13141
Bbm7   x13121 x13121
Bbmaj7 x13231 x13241
Bbsus2 x13311 x13411
F      xx3211 xx3211
Fm     xx3111 xx3111
Ab     xx1114 xx1114
Ebmaj7 xx1333 xx1333
Fm7    xx1111 xx1111
Fm     xxx111 xxx111
F      xxx211 xxx211
B9     x21222 x21333
""")
"""Movable shapes with a full or partial barre."""

POWER_CHORDS = _table("""
F5     13xxxx 13xxxx
F5     133xxx 134xxx
Bb5    x13xxx x13xxx
Bb5    x133xx x134xx
Eb5    xx13xx xx13xx
Eb5    xx134x xx134x
Ab5    xxx14x xxx14x
Ab5    xxx144 xxx134
""")
"""Movable roots with their fifths and octaves."""

GRIPS = _table("""
F7     1x121x 1x243x
Fmaj7  1x221x 1x342x
F#m6   2x122x 2x134x
C7     x3231x x3241x
Bbmaj7 x1323x x1324x
Bbm7   x1312x x1423x
Bbm7b5 x1212x x1324x
Bdim7  x2313x x2314x
Ebm7b5 xx1222 xx1234
Ebdim7 xx1212 xx1324
Am7b5  xx1213 xx1324
Bbm    xx3321 xx3421
Bb     xxx331 xxx341
F      xxx211 xxx312
Db     xxx121 xxx132
Bbm    xxx321 xxx321
Dm     xxx231 xxx231
""")
"""Movable shapes with a finger for every string."""
