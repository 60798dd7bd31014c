"""How fast the right hand can pluck: patterns of notes at growing speed, in physics.

Usage: python benchmarks/strokes.py
Writes results/strokes.json, the same for the same versions, and prints a table of it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
import record

from roboguitarist.fingering import assign
from roboguitarist.performance import perform
from roboguitarist.tablature import Note, Tablature

GAPS_S = (0.06, 0.09, 0.125, 0.2, 0.375)
PATTERNS: dict[str, tuple[tuple[int, ...], ...]] = {
    **{f"string {string}": ((string,),) for string in range(1, 7)},
    "p i m a": ((4,), (3,), (2,), (1,)),
    "6 5 4": ((6,), (5,), (4,)),
    "4 5 6": ((4,), (5,), (6,)),
    "6 4": ((6,), (4,)),
    "5 with 4": ((5, 4),),
    "6 with 4": ((6, 4),),
    "all six": ((6, 5, 4, 3, 2, 1),),
}
REPEATS = 9
TOLERANCE_S = 0.05


@dataclass(frozen=True)
class Result:
    """How a pattern was plucked; errors are absolute, in milliseconds, of the notes plucked."""

    pattern: str
    gap_s: float
    asked: int
    missed: int
    extra: int
    median_ms: float | None
    largest_ms: float | None


def play(name: str, gap_s: float) -> Result:
    """Pluck a pattern of open strings `REPEATS` times."""
    steps = PATTERNS[name]
    notes = [
        Note(round(0.5 + index * gap_s, 6), string, 0, gap_s)
        for index in range(REPEATS)
        for string in steps[index % len(steps)]
    ]
    performance = perform(assign(Tablature(tuple(sorted(notes, key=lambda note: note.place)))))
    plucks = list(zip(performance.pluck_time_s, performance.pluck_string, strict=True))
    errors_s = []
    for note in notes:
        own = [(abs(t - note.onset_s), i) for i, (t, s) in enumerate(plucks) if s == note.string]
        if own and min(own)[0] <= TOLERANCE_S:
            error_s, index = min(own)
            errors_s.append(error_s)
            del plucks[index]
    median, largest = (
        round(1000 * float(f(errors_s)), 1) if errors_s else None for f in (np.median, max)
    )
    missed = len(notes) - len(errors_s)
    return Result(name, gap_s, len(notes), missed, len(plucks), median, largest)


def main() -> None:
    """Play every pattern at every speed."""
    results = [play(name, gap_s) for name in PATTERNS for gap_s in GAPS_S]
    print(
        "| pattern | gap ms | missed | extra | median ms | largest ms |\n|---|--:|--:|--:|--:|--:|"
    )
    for r in results:
        cells = (r.pattern, f"{1000 * r.gap_s:g}", f"{r.missed}/{r.asked}", r.extra)
        print("|", " | ".join(map(str, (*cells, r.median_ms, r.largest_ms))), "|")
    print(record.write("strokes", [asdict(result) for result in results]))


if __name__ == "__main__":
    main()
