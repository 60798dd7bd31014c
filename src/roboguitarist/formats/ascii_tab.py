"""ASCII tab, as guitarists type it, to the score as written.

A tab of this kind has no rhythm. Every column is one step of a grid, and a note lasts until the
next one. Lines before the first system may say `Tempo: 90`, `Grid: 16`, `Capo: 2`,
`Tuning: D A D G B E`, `Title: ...` and `Composer: ...`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate

from roboguitarist.errors import TabError
from roboguitarist.formats.ascii_facts import facts
from roboguitarist.formats.ascii_signs import Sign, signs, together
from roboguitarist.formats.ascii_system import System, is_string, systems
from roboguitarist.formats.written import (
    MAX_NOTES,
    WrittenBar,
    WrittenNote,
    WrittenPart,
    WrittenScore,
)

MAX_LENGTH = Fraction(4)
"""Quarter notes; a note that nothing follows lasts no longer."""
MAX_CHARACTERS = 2_000_000
_MAX_LINES = 100_000
_CONFLICT = re.compile(r"(<{7}|>{7})( |$)")
_TAGS = re.compile(r"\[/?(?:tab|ch)\]", re.IGNORECASE)
_TYPED = str.maketrans(
    dict.fromkeys("‐‑‒–—―−─━═", "-") | dict.fromkeys("│┃║¦", "|") | {"\u00a0": " "}
)
"""What word processors make of dashes, bar lines and spaces."""
_REPEAT_SIGNS = set(":*oO")


def is_tab(text: str) -> bool:
    """Whether a text has at least three lines that look like strings."""
    return sum(is_string(line) for line in _lines(text)[:_MAX_LINES]) >= 3


def _lines(text: str) -> list[str]:
    """Lines as they were typed before a word processor or a web site changed them."""
    return [line.expandtabs() for line in _TAGS.sub("", text.translate(_TYPED)).splitlines()]


def read(text: str, tempo: float | None = None, grid: int | None = None) -> WrittenScore:
    """Read an ASCII tab.

    Args:
        text: The whole file.
        tempo: Quarter notes a minute; by default as the tab says, else 120.
        grid: A column is the grid-th part of a whole note; by default as the tab says, else 16.

    Raises:
        TabError: If there is no tab, or it is not one for a guitar with six strings.
    """
    if len(text) > MAX_CHARACTERS:
        raise TabError("ASCII tab too long", hint=f"at most {MAX_CHARACTERS} characters")
    lines = _lines(text)
    for number, line in enumerate(lines, 1):
        if _CONFLICT.match(line):
            raise TabError(f"line {number}: a conflict marker of git", hint="merge the file first")
    found, tuning = systems(lines)
    said = facts(text.splitlines()[: found[0].line - 1], tempo, grid)
    bars, notes = _bars(found, Fraction(4, said.grid))
    bars[:1] = [replace(bar, tempi=((Fraction(0), said.tempo),)) for bar in bars[:1]]
    part = WrittenPart(
        name="Guitar",
        notes=tuple(_until_the_next(bars, notes)),
        tuning=said.tuning or tuning,
        capo=said.capo,
        warnings=said.warnings,
    )
    return WrittenScore(tuple(bars), (part,), title=said.title, composer=said.composer)


def _bars(found: Sequence[System], column: Fraction) -> tuple[list[WrittenBar], list[WrittenNote]]:
    """Bars and notes; all notes have the length of one column as yet."""
    bars: list[WrittenBar] = []
    notes: list[WrittenNote] = []
    cut = [(system, _cut(system)) for system in found]
    padded = all(slice_.is_padded for _, slices in cut for slice_ in slices)
    for system, slices in cut:
        alone = system.times and not slices[-1].ends and not any(s.starts for s in slices)
        for k, slice_ in enumerate(slices):
            bar = _bar(len(bars) + 1, slice_, padded, column)
            if k == 0 and alone:
                bar = replace(bar, repeat_start=True)
            if k == len(slices) - 1 and system.times:
                bar = replace(bar, repeat_times=system.times)
            for string, sign in _signs(slice_, padded, system.line, bar.number):
                notes.append(_note(len(bars), string, sign, column))
            bars.append(bar)
            if len(notes) > MAX_NOTES:
                raise TabError(f"more than {MAX_NOTES} notes")
    return bars, sorted(notes, key=lambda note: (note.bar, note.offset, note.string))


def _signs(cut: _Slice, padded: bool, line: int, bar: int) -> Iterator[tuple[int, Sign]]:
    """Strings and what is played on them in a bar."""
    rows: list[list[Sign]] = []
    for string, row in enumerate(cut.rows):
        try:
            rows.append(signs(row[padded:]))
        except TabError as error:
            where = f"line {line + string}: {error.reason}"
            raise TabError(where, bar=bar, hint=error.hint) from error
    together(rows)
    for string, on_string in enumerate(rows, 1):
        yield from ((string, sign) for sign in on_string)


@dataclass(frozen=True, slots=True)
class _Slice:
    """What stands between two bar lines on each string, and the repeat signs that were there."""

    rows: tuple[str, ...]
    starts: bool
    ends: bool

    @property
    def is_padded(self) -> bool:
        """Whether a dash stands on every string between bar line and music."""
        return len(self.rows[0]) > 1 and all(row.startswith("-") for row in self.rows)


def _cut(system: System) -> list[_Slice]:
    """The bars of a system: what stands between columns that are bar lines on most strings."""
    slices, start = [], 0
    for column, signs_ in enumerate(zip(*system.rows, strict=True)):
        if signs_.count("|") > len(signs_) // 2:
            rows = [row[start:column].replace("|", "-") for row in system.rows]
            stray = len(rows[0]) < 3 and not set("".join(rows)) - {"-"}
            if rows[0] and not stray:
                slices.append(_slice(rows))
            start = column + 1
    return slices


def _slice(rows: list[str]) -> _Slice:
    starts, ends = (sum(row[k] in _REPEAT_SIGNS for row in rows) > 1 for k in (0, -1))
    inside = slice(int(starts), -1 if ends else None)
    rows = [row[inside] or "-" for row in rows]
    return _Slice(tuple(rows), starts, ends)


def _bar(number: int, cut: _Slice, padded: bool, column: Fraction) -> WrittenBar:
    length = (len(cut.rows[0]) - padded) * column
    beat_type = max(4, (length / 4).denominator)
    return WrittenBar(
        number,
        length,
        int(length / 4 * beat_type),
        beat_type,
        repeat_start=cut.starts,
        repeat_times=2 if cut.ends else 0,
    )


def _note(bar: int, string: int, sign: Sign, column: Fraction) -> WrittenNote:
    return WrittenNote(
        bar,
        sign.column * column,
        column,
        string=string,
        fret=sign.fret,
        techniques=tuple(sorted(sign.techniques)),
        bend=sign.curve(),
    )


def _until_the_next(
    bars: Sequence[WrittenBar], notes: Sequence[WrittenNote]
) -> Iterator[WrittenNote]:
    """The notes, each as long as it is until others begin."""
    starts = [Fraction(0), *accumulate(bar.length for bar in bars)]
    onsets = sorted({starts[note.bar] + note.offset for note in notes})
    following = dict(zip(onsets, [*onsets[1:], starts[-1]], strict=False))  # none: no notes
    for note in notes:
        onset = starts[note.bar] + note.offset
        yield replace(note, length=min(MAX_LENGTH, following[onset] - onset))
