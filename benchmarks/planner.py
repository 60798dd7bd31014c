"""How well the planner plays the eight pieces, with both hand variants.

Usage: python benchmarks/planner.py
Writes results/planner.json, the same for the same versions, and prints a table of it.
"""

from __future__ import annotations

import record

from roboguitarist import cli_report, formats, pieces
from roboguitarist.cli_play import Playing, assess
from roboguitarist.fingering import assign
from roboguitarist.hands import VARIANTS, Variant
from roboguitarist.performance import PerformConfig, perform

PIECES = pieces.names()[:8]


def played(name: str, hand: Variant) -> Playing:
    """One piece as the planner plays it."""
    fingering = assign(formats.load(pieces.path(name)))
    return assess(name, perform(fingering, PerformConfig(hand=hand)))


def main() -> None:
    """Play everything, print the tables, write the file."""
    results = []
    for hand in VARIANTS:
        playings = [played(name, hand) for name in PIECES]
        print(f"Hand variant: {hand}\n")
        print(cli_report.metrics_table([playing.row() for playing in playings]), end="\n\n")
        results += [playing.as_dict() for playing in playings]
    print(record.write("planner", results))


if __name__ == "__main__":
    main()
