"""How well the planner plays the eight pieces with each way of fingering them.

Usage: python benchmarks/fingering.py
Writes results/fingering.json, the same for the same versions, and prints a table of it.
"""

from __future__ import annotations

import record
from tqdm import tqdm

from roboguitarist import cli_report, formats, pieces
from roboguitarist.cli_play import Playing, assess
from roboguitarist.fingering import METHODS, assign
from roboguitarist.performance import PerformConfig, perform

PIECES = pieces.names()[:8]


def played(name: str, method: str) -> Playing:
    """One piece as the planner plays it."""
    fingering = assign(formats.load(pieces.path(name)), method=method)
    return assess(name, perform(fingering, PerformConfig()))


def main() -> None:
    """Play everything, print the tables, write the file."""
    results = []
    for method in METHODS:
        playings = [played(name, method) for name in tqdm(PIECES, method, disable=None)]
        print(f"Fingering: {method}\n")
        print(cli_report.metrics_table([playing.row() for playing in playings]), end="\n\n")
        results += [{"method": method, **playing.as_dict()} for playing in playings]
    print(record.write("fingering", results))


if __name__ == "__main__":
    main()
