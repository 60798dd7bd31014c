"""Write a few chords down as a tablature and print it with the fingers of both hands."""

from roboguitarist import engraving
from roboguitarist.fingering import assign
from roboguitarist.tablature import Bar, Note, Tablature

# Frets on strings 1 to 6; a missing string is not played.
CHORDS = {
    "C": {1: 0, 2: 1, 3: 0, 4: 2, 5: 3},
    "Am": {1: 0, 2: 1, 3: 2, 4: 2, 5: 0},
    "Dm": {1: 1, 2: 3, 3: 2, 4: 0},
    "E7": {1: 0, 2: 0, 3: 1, 4: 0, 5: 2, 6: 0},
}
BAR_S = 2.0

notes = tuple(
    Note(BAR_S * k, string, fret, BAR_S, bar=k + 1)
    for k, chord in enumerate(CHORDS.values())
    for string, fret in chord.items()
)
bars = tuple(Bar(BAR_S * k, k + 1) for k in range(len(CHORDS)))
fingering = assign(Tablature(notes, bars, title=" ".join(CHORDS)))

print(engraving.render(fingering))
