"""One phrase played by both hand variants: coupled finger joints, and tendons as published."""

from roboguitarist.alignment import misses
from roboguitarist.fingering import assign
from roboguitarist.hands import VARIANTS
from roboguitarist.metrics import evaluate
from roboguitarist.performance import PerformConfig, perform
from roboguitarist.tablature import Note, Tablature

# Up the first frets of string 2, half a second a note.
phrase = Tablature(tuple(Note(0.5 * k, 2, fret, 0.5) for k, fret in enumerate((1, 3, 5, 3, 1, 0))))

for hand in VARIANTS:
    performance = perform(assign(phrase), PerformConfig(hand=hand))
    counts = evaluate(performance).counts
    print(f"{hand}: {counts.right} of {counts.asked} notes right")
    for miss in misses(performance):
        print(f"  {miss}")
