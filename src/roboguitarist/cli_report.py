"""What the command line prints: tables and lists of misses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from roboguitarist import pieces
from roboguitarist.tablature import Tablature, Technique

if TYPE_CHECKING:
    from roboguitarist.alignment import Miss
    from roboguitarist.metrics import Metrics

HEADER = (
    "piece", "note", "onset", "frame", "free", "median ms", "95 % ms", "power W", "right", "missed",
)  # fmt: skip
"""F1 of the four scores, onset errors, the left hand's power, right notes of those asked, and
why the others were missed."""
MAX_MISSES = 12


def table(rows: Sequence[Sequence[str]], text_columns: int = 1) -> str:
    """A table in Markdown, aligned to be read as it is.

    Args:
        rows: Header first, all of one length.
        text_columns: How many columns are aligned to the left; the others are to the right.
    """
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]

    def line(row: Sequence[str]) -> str:
        cells = [
            cell.ljust(width) if k < text_columns else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        return f"| {' | '.join(cells)} |"

    rule = ["-" * w if k < text_columns else "-" * (w - 1) + ":" for k, w in enumerate(widths)]
    return "\n".join(line(row) for row in (rows[0], rule, *rows[1:]))


def metrics_table(rows: Sequence[Sequence[str]]) -> str:
    """The rows of `metrics_row` under their header."""
    return table([HEADER, *rows])


def metrics_row(name: str, metrics: Metrics, misses: Sequence[Miss]) -> tuple[str, ...]:
    """One row under `HEADER`; a dash where there is nothing to measure."""
    scores = (metrics.note, metrics.onset, metrics.frame, metrics.frame_free)
    timing, motion, counts = metrics.timing_ms, metrics.motion, metrics.counts
    return (
        name,
        *(f"{score.f1:.3f}" if score else "-" for score in scores),
        f"{timing.median:.1f}" if timing else "-",
        f"{timing.p95:.1f}" if timing else "-",
        f"{motion.power_w:.2f}" if motion else "-",
        f"{counts.right}/{counts.asked}",
        causes(misses) or "-",
    )


def causes(misses: Sequence[Miss]) -> str:
    """How many notes were missed for each reason, the most frequent first."""
    counted = Counter(miss.cause.value for miss in misses).most_common()
    return ", ".join(f"{count} {cause}" for cause, count in counted)


PLAYED = {Technique.GRACE, Technique.LET_RING}
"""Techniques that are in the times of the notes."""


def simplified(tablature: Tablature) -> list[str]:
    """One line that says which techniques are played as plain notes, none if there are none."""
    counted = Counter(kind for note in tablature.notes for kind in note.techniques)
    listed = [f"{count} {kind}" for kind, count in counted.most_common() if kind not in PLAYED]
    return [f"played as plain notes: {', '.join(listed)}"] if listed else []


def shortened(lines: Iterable[str]) -> list[str]:
    """The first lines, and how many more there are."""
    lines = list(lines)
    return lines[:MAX_MISSES] + _rest(len(lines))


def _rest(count: int) -> list[str]:
    return [f"  and {count - MAX_MISSES} more"] if count > MAX_MISSES else []


def repertoire() -> str:
    """The repertoire as a table."""
    rows = [(piece.name, piece.title, piece.composer, piece.grade) for piece in pieces.PIECES]
    return table([("name", "title", "composer", "grade"), *rows], text_columns=4)
