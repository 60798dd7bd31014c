"""From a score to what two robotic hands make of it.

Usage: python examples/01_play_a_piece.py [SCORE]
"""

import sys

from roboguitarist import formats, pieces, sound
from roboguitarist.fingering import assign
from roboguitarist.metrics import evaluate
from roboguitarist.performance import perform

# What is asked: the notes with their strings, frets and times.
score = sys.argv[1] if len(sys.argv) > 1 else pieces.path("twinkle")
tablature = formats.load(score)
print(f"{tablature.title}: {len(tablature.notes)} notes, {tablature.duration_s:.0f} s")

# Which finger plays which note.
fingering = assign(tablature)

# What the physics makes of it. Only the servos move the hands.
performance = perform(fingering)

# How good it was: F1 of the notes that were plucked in time, at the right fret, and held.
note = evaluate(performance).note
print(f"note F1 {note.f1:.3f}" if note else "nothing to play")

# What it sounds like; the recording can be loaded and examined later.
sound.write_wav("performance.wav", sound.synthesize(performance))
performance.save("performance.npz")
