"""The left hand: which finger presses what, when, and how it gets there."""
