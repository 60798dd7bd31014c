"""Exercises for the left hand, made from a seed: what to practise apart from the repertoire."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.exercises import chords, lines
from roboguitarist.exercises.sheet import (
    QUARTERS_PER_BAR,
    Sheet,
    Stroke,
    Writer,
    joined,
    playable,
    written,
)
from roboguitarist.tablature import Tablature, validate


class Kind(StrEnum):
    """What an exercise trains."""

    SCALES = "scales"
    LOW_LINES = "low-lines"
    HIGH_LINES = "high-lines"
    REPEATED_NOTES = "repeated-notes"
    POSITION_SHIFTS = "position-shifts"
    MELODY_OVER_BASS = "melody-over-bass"
    DYADS = "dyads"
    ARPEGGIOS = "arpeggios"
    OPEN_CHORDS = "open-chords"
    BARRE_CHORDS = "barre-chords"
    POWER_CHORDS = "power-chords"
    RANDOM_SHAPES = "random-shapes"
    SLOW_CHANGES = "slow-changes"
    FAST_CHANGES = "fast-changes"
    MIXED = "mixed"


KINDS = tuple(Kind)


@dataclass(frozen=True)
class ExerciseConfig:
    """Limits within which the seed chooses.

    Attributes:
        tempo: Least and most quarters a minute, 40 to 200 or within.
        bars: Least and most bars of four quarters, 1 to 64.
        duration_s: Length in seconds, 1 to 600, instead of a number of bars.
        highest_fret: 5 to 20; no note is above it.
    """

    tempo: tuple[int, int] = (40, 200)
    bars: tuple[int, int] = (4, 16)
    duration_s: float | None = None
    highest_fret: int = 15

    def __post_init__(self) -> None:
        """Refuse what no exercise can be written within.

        Raises:
            RoboGuitaristError: If a limit is out of its range.
        """
        (slow, fast), (short, long) = self.tempo, self.bars
        rules = (
            (40 <= slow <= fast <= 200, f"tempo {slow} to {fast} (40 to 200)"),
            (1 <= short <= long <= 64, f"{short} to {long} bars (1 to 64)"),
            (self.duration_s is None or 1 <= self.duration_s <= 600, "duration (1 to 600 s)"),
            (5 <= self.highest_fret <= 20, f"highest fret {self.highest_fret} (5 to 20)"),
        )
        for holds, reason in rules:
            if not holds:
                raise RoboGuitaristError(f"exercise out of range: {reason}")


def generate(kind: Kind | str, seed: int, config: ExerciseConfig = ExerciseConfig()) -> Tablature:
    """Write one exercise.

    The left hand can play it all: `fingering.assign` finds a finger for every note, and that
    which the exercise marks where it does.

    Args:
        kind: One of `KINDS`.
        seed: At least 0. The same kind, seed and config give the same tablature.
        config: Limits of tempo, length and frets.

    Raises:
        RoboGuitaristError: If there is no such kind, or the seed is negative.
    """
    if kind not in KINDS:
        raise RoboGuitaristError(f"no exercise {str(kind)!r} (there are {', '.join(KINDS)})")
    if seed < 0:
        raise RoboGuitaristError(f"seed {seed} (0 or more)")
    rng = np.random.default_rng([seed, *str(kind).encode()])
    sheet = _sheet(rng, config)
    tablature = written(sheet, WRITERS[Kind(kind)](sheet), f"{kind}, seed {seed}")
    return validate(playable(tablature))


def stream(
    seed: int, kinds: Iterable[Kind | str] | None = None, config: ExerciseConfig = ExerciseConfig()
) -> Iterator[Tablature]:
    """Exercises without end, each of a kind and with a seed of its own that its title says.

    Args:
        seed: At least 0. The same arguments give the same exercises.
        kinds: Those to choose from, all as likely; a kind that comes twice is twice as likely.
            All if None.
        config: As for `generate`.

    Raises:
        RoboGuitaristError: If there is no kind, an unknown one, or the seed is negative.
    """
    chosen = KINDS if kinds is None else tuple(kinds)
    unknown = [str(kind) for kind in chosen if kind not in KINDS]
    if unknown or not chosen:
        names = ", ".join(unknown) or "of no kind"
        raise RoboGuitaristError(f"no exercises {names} (there are {', '.join(KINDS)})")
    if seed < 0:
        raise RoboGuitaristError(f"seed {seed} (0 or more)")
    return _stream(np.random.default_rng(seed), chosen, config)


def _stream(
    rng: np.random.Generator, kinds: tuple[Kind | str, ...], config: ExerciseConfig
) -> Iterator[Tablature]:
    while True:
        kind = kinds[rng.integers(len(kinds))]
        yield generate(kind, int(rng.integers(2**32)), config)


def _sheet(rng: np.random.Generator, config: ExerciseConfig) -> Sheet:
    tempo = int(rng.integers(config.tempo[0], config.tempo[1] + 1))
    quarters = float(QUARTERS_PER_BAR * rng.integers(config.bars[0], config.bars[1] + 1))
    if config.duration_s is not None:
        quarters = config.duration_s * tempo / 60.0
    return Sheet(rng, tempo, quarters, config.highest_fret)


def _mixed(sheet: Sheet) -> Iterator[Stroke]:
    """Phrases of all other kinds in turn, one or two bars each."""
    writers = tuple(writer for kind, writer in WRITERS.items() if kind != Kind.MIXED)

    def phrase(part: Sheet) -> Iterable[Stroke]:
        return part.pick(writers)(part)

    return joined(sheet, phrase, sheet.pick((1, 2)))


WRITERS: dict[Kind, Writer] = {
    Kind.SCALES: lines.scales,
    Kind.LOW_LINES: lines.low_lines,
    Kind.HIGH_LINES: lines.high_lines,
    Kind.REPEATED_NOTES: lines.repeated_notes,
    Kind.POSITION_SHIFTS: lines.position_shifts,
    Kind.MELODY_OVER_BASS: lines.melody_over_bass,
    Kind.DYADS: chords.dyads,
    Kind.ARPEGGIOS: chords.arpeggios,
    Kind.OPEN_CHORDS: chords.open_chords,
    Kind.BARRE_CHORDS: chords.barre_chords,
    Kind.POWER_CHORDS: chords.power_chords,
    Kind.RANDOM_SHAPES: chords.random_shapes,
    Kind.SLOW_CHANGES: chords.slow_changes,
    Kind.FAST_CHANGES: chords.fast_changes,
    Kind.MIXED: _mixed,
}
