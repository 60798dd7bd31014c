"""A fingered tablature as plain text: six lines of frets with the fingers of both hands."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from roboguitarist.fingering import RIGHT_FINGERS, SIMULTANEOUS_S, UNPLAYABLE, Fingering
from roboguitarist.tablature import N_STRINGS, Note, Technique

PITCH_NAMES = ("C", "C#", "D", "Eb", "E", "F", "F#", "G", "G#", "A", "Bb", "B")
LEGEND = (
    "Over the strings: right-hand fingers, and the fret of the index finger where it changes "
    "(C: barre). Under the strings: left-hand fingers."
)
RIGHT_ROWS, LEFT_ROWS = 4, 5
"""Rows for the fingers of each hand, one finger a row; on the left there is also `?`."""
MAX_SPACE = 8
"""Most dashes after a fret, however long the time to the next."""

Column = list[str]
"""The texts of one moment, all of one width, a row each: bar number, hold position, right hand
(`RIGHT_ROWS`), strings 1 to 6, left hand (`LEFT_ROWS`)."""


def render(fingering: Fingering, width: int = 80) -> str:
    """Plain-text tablature with bar numbers, hold positions and the fingers of both hands.

    String 1 is on top. Frets are the tablature's, counted from the capo; hold positions are
    Roman numerals, counted from the nut. Spacing grows with the logarithm of time. A dead note
    is `x`, harmonics stand in angle brackets, `?` is the finger of a note that has none.

    Args:
        fingering: What to show.
        width: Characters in a line; only a single moment wider than this exceeds it.

    Returns:
        Lines ending in a newline; the difficulty of each bar and the problems come last.
    """
    names = [PITCH_NAMES[pitch % 12] for pitch in fingering.tablature.tuning]
    margin = _column(strings=[name.ljust(2) for name in names])
    blocks = [_header(fingering, width)]
    for system in _systems(list(_columns(fingering)), width - len(margin[0])):
        rows = ["".join(texts).rstrip() for texts in zip(margin, *system, strict=True)]
        blocks.append("\n".join(row for row in rows if row))
    if fingering.difficulty.any():
        blocks.append(textwrap.fill(_difficulty(fingering), width, subsequent_indent="  "))
    if fingering.problems:
        blocks.append("\n".join(("Not as asked:", *fingering.problems)))
    return "\n\n".join(blocks) + "\n"


def _header(fingering: Fingering, width: int) -> str:
    tablature = fingering.tablature
    tempi = [round(tempo.quarters_per_minute) for tempo in tablature.tempi]
    tempo = f"{min(tempi)} to {max(tempi)}" if len(set(tempi)) > 1 else f"{tempi[0]}"
    facts = [
        f"tempo {tempo}",
        "tuning " + " ".join(PITCH_NAMES[pitch % 12] for pitch in reversed(tablature.tuning)),
        f"capo at fret {tablature.capo}" if tablature.capo else "",
        f"fingering {fingering.method}",
    ]
    lines = [tablature.title, tablature.composer, ", ".join(fact for fact in facts if fact)]
    return "\n".join((*(line for line in lines if line), textwrap.fill(LEGEND, width)))


def _columns(fingering: Fingering) -> Iterator[Column]:
    """Bar lines and moments of the whole piece, in order."""
    tablature = fingering.tablature
    onset_s = np.array([note.onset_s for note in tablature.notes])
    starts_s = [*(bar.onset_s for bar in tablature.bars), max(tablature.duration_s, 0.0)]
    unit_s = _usual_step_s(onset_s)
    position = None
    for bar, (start_s, end_s) in zip(tablature.bars, pairwise(starts_s), strict=True):
        yield _column(bar=str(bar.number), strings="|" * N_STRINGS, fill="-")
        first, last = np.searchsorted(onset_s, np.array([start_s, end_s]) - SIMULTANEOUS_S)
        chords = _chords(onset_s, int(first), int(last))
        times_s = [*(onset_s[chord[0]] for chord in chords), end_s]
        if times_s[0] - start_s > SIMULTANEOUS_S:
            yield _column(space=_space(times_s[0] - start_s, unit_s), fill="-")
        for chord, (now_s, next_s) in zip(chords, pairwise(times_s), strict=True):
            space = _space(next_s - now_s, unit_s)
            column, position = _moment(fingering, chord, position, space)
            yield column
    yield _column(strings="|" * N_STRINGS, space=0)


def _difficulty(fingering: Fingering) -> str:
    """The cost of the left hand's steps, summed for every bar in playing order."""
    tablature = fingering.tablature
    onset_s = np.array([note.onset_s for note in tablature.notes])
    new = np.diff(onset_s, prepend=-np.inf) > SIMULTANEOUS_S  # a chord is one step
    starts_s = [bar.onset_s - SIMULTANEOUS_S for bar in tablature.bars]
    bar = np.maximum(np.searchsorted(starts_s, onset_s, side="right") - 1, 0)
    sums = np.bincount(bar, fingering.difficulty * new, minlength=len(starts_s))
    cells = (f"{bar.number}:{cost:.1f}" for bar, cost in zip(tablature.bars, sums, strict=True))
    return "Difficulty of each bar: " + " ".join(cells)


def _usual_step_s(onset_s: np.ndarray) -> float:
    steps_s = np.diff(onset_s)
    steps_s = steps_s[steps_s > SIMULTANEOUS_S]
    return float(np.median(steps_s)) if steps_s.size else 1.0


def _space(step_s: float, usual_s: float) -> int:
    """Dashes after a moment: two for the usual step, two more whenever it doubles."""
    doublings = np.log2(max(step_s, SIMULTANEOUS_S) / usual_s)
    return int(np.clip(round(2 + 2 * doublings), 1, MAX_SPACE))


def _chords(onset_s: np.ndarray, first: int, last: int) -> list[list[int]]:
    """Notes `first` to `last` - 1, those that start together in one list."""
    chords: list[list[int]] = []
    for index in range(first, last):
        if chords and onset_s[index] - onset_s[chords[-1][0]] <= SIMULTANEOUS_S:
            chords[-1].append(index)
        else:
            chords.append([index])
    return chords


def _moment(
    fingering: Fingering, chord: list[int], position: int | None, space: int
) -> tuple[Column, int | None]:
    """The column of a chord, and the hold position that was last written."""
    frets, right, left = [""] * N_STRINGS, [], []
    for index in chord:
        note, finger = fingering.tablature.notes[index], int(fingering.left[index])
        frets[note.string - 1] = _fret(note)
        right.append(RIGHT_FINGERS[fingering.right[index]])
        if finger:
            left.append("?" if finger == UNPLAYABLE else str(finger))
    mark, barre = "", bool(fingering.barre[chord].any())
    here = int(fingering.hold_position[chord[0]])
    if barre or (here != position and fingering.left[chord].any()):
        position, mark = here, "C " * barre + roman(here)
    column = _column(
        position=mark,
        right=list(dict.fromkeys(right)),
        strings=frets,
        left=list(dict.fromkeys(left)),
        space=space,
        fill="-",
    )
    return column, position


def _fret(note: Note) -> str:
    if Technique.DEAD in note.techniques:
        return "x"
    return f"<{note.fret}>" if Technique.HARMONIC in note.techniques else str(note.fret)


def roman(number: int) -> str:
    """A number from 1 to 39 in Roman numerals."""
    text = ""
    for value, numeral in ((10, "X"), (9, "IX"), (5, "V"), (4, "IV"), (1, "I")):
        count, number = divmod(number, value)
        text += numeral * count
    return text


def _column(
    *,
    bar: str = "",
    position: str = "",
    right: Sequence[str] = (),
    strings: Sequence[str] = ("",) * N_STRINGS,
    left: Sequence[str] = (),
    space: int = 1,
    fill: str = " ",
) -> Column:
    """Texts padded to one width: `space` after the strings, 1 after a number over them."""
    over = [bar, position, *[""] * (RIGHT_ROWS - len(right)), *right]
    under = [*left, *[""] * (LEFT_ROWS - len(left))]
    marks = max(len(text) + 1 for text in (*over, *under))
    width = max(*(len(text) + space for text in strings), marks if any(over) else 0)
    lines = [text.ljust(width, fill) for text in strings]
    return [text.ljust(width) for text in over] + lines + [text.ljust(width) for text in under]


def _systems(columns: list[Column], width: int) -> Iterator[list[Column]]:
    """Columns filled into lines, broken at bar lines where a bar fits into one line."""
    ending = columns.pop()
    bars: list[list[Column]] = []
    for column in columns:
        if column[2 + RIGHT_ROWS].startswith("|"):
            bars.append([])
        bars[-1].append(column)
    system: list[Column] = []
    room = width - 1
    for bar in bars:
        if system and _width(system) + _width(bar) > room:
            yield [*system, ending]
            system = []
        for column in bar:
            if system and _width(system) + _width([column]) > room:
                yield system
                system = []
            system.append(column)
    if system:
        yield [*system, ending]


def _width(columns: list[Column]) -> int:
    return sum(len(column[0]) for column in columns)
