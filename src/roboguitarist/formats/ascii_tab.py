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
from roboguitarist.formats.ascii_signs import Sign, signs
from roboguitarist.formats.ascii_system import System, is_string, nearest, systems
from roboguitarist.formats.written import (
    MAX_NOTES,
    WrittenBar,
    WrittenNote,
    WrittenPart,
    WrittenScore,
)
from roboguitarist.tablature import STANDARD_TUNING

DEFAULT_GRID, DEFAULT_TEMPO = 16, 120
GRIDS = range(4, 193)
TEMPI = range(10, 1001)
MAX_LENGTH = Fraction(4)
"""Quarter notes; a note that nothing follows lasts no longer."""
MAX_CHARACTERS = 2_000_000
_MAX_LINES = 100_000
_CONFLICT = re.compile(r"(<{7}|>{7})( |$)")
_FACT = re.compile(r"\s*(tempo|bpm|grid|capo|tuning|title|composer|artist)\s*[:=]\s*(.*)", re.I)
_REPEAT_SIGNS = set(":*oO")


def is_tab(text: str) -> bool:
    """Whether a text has at least three lines that look like strings."""
    return sum(is_string(line) for line in text.splitlines()[:_MAX_LINES]) >= 3


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
    lines = [line.expandtabs() for line in text.splitlines()]
    for number, line in enumerate(lines, 1):
        if _CONFLICT.match(line):
            raise TabError(f"line {number}: a conflict marker of git", hint="merge the file first")
    found, tuning = systems(lines)
    facts = _facts(lines[: found[0].line - 1])
    columns = _in_range("grid", grid or facts.get("grid"), GRIDS, DEFAULT_GRID)
    tempo = _in_range(
        "tempo", tempo or facts.get("tempo") or facts.get("bpm"), TEMPI, DEFAULT_TEMPO
    )
    bars, notes = _bars(found, Fraction(4, int(columns)))
    bars[:1] = [replace(bar, tempi=((Fraction(0), _fraction(tempo)),)) for bar in bars[:1]]
    part = WrittenPart(
        name="Guitar",
        notes=tuple(_until_the_next(bars, notes)),
        tuning=_stated_tuning(facts) or tuning,
        capo=int(_in_range("capo", facts.get("capo"), range(13), 0)),
    )
    composer = facts.get("composer") or facts.get("artist", "")
    return WrittenScore(tuple(bars), (part,), title=facts.get("title", ""), composer=composer)


def _fraction(number: float) -> Fraction:
    return Fraction(repr(number))


def _facts(lines: Sequence[str]) -> dict[str, str]:
    found = (_FACT.fullmatch(line) for line in lines)
    return {fact[1].casefold(): fact[2].strip()[:200] for fact in found if fact}


def _in_range(name: str, value: object, allowed: range, usual: int) -> int | float:
    """The first number in a text, or a number."""
    if value is None or value == "":
        return usual
    digits = re.search(r"\d{1,6}(\.\d{1,6})?", str(value))
    number = float(digits[0]) if digits else -1.0
    if not allowed.start <= number < allowed.stop:
        raise TabError(f"{name} {str(value)[:20]}", hint=f"{allowed.start} to {allowed.stop - 1}")
    return int(number) if number.is_integer() else number


def _stated_tuning(facts: dict[str, str]) -> tuple[int, ...] | None:
    """A tuning in words, lowest string first."""
    names = re.findall(r"[A-Ga-g][#b♯♭]?", facts.get("tuning", ""))
    if len(names) != len(STANDARD_TUNING):
        return None
    strings = zip(reversed(names), STANDARD_TUNING, strict=True)
    return tuple(nearest(name, usual) for name, usual in strings)


def _bars(found: Sequence[System], column: Fraction) -> tuple[list[WrittenBar], list[WrittenNote]]:
    """Bars and notes; all notes have the length of one column as yet."""
    bars: list[WrittenBar] = []
    notes: list[WrittenNote] = []
    cut = [(system, _cut(system)) for system in found]
    padded = all(slice_.is_padded for _, slices in cut for slice_ in slices)
    for system, slices in cut:
        for slice_ in slices:
            is_last = slice_ is slices[-1]
            bar = _bar(len(bars) + 1, slice_, padded, column, system.times if is_last else 0)
            bars.append(bar)
            for string, row in enumerate(slice_.rows, 1):
                try:
                    on_string = signs(row[padded:])
                except TabError as error:
                    where = f"line {system.line + string - 1}: {error.reason}"
                    raise TabError(where, bar=bar.number, hint=error.hint) from error
                notes.extend(_note(len(bars) - 1, string, sign, column) for sign in on_string)
                if len(notes) > MAX_NOTES:
                    raise TabError(f"more than {MAX_NOTES} notes")
    return bars, sorted(notes, key=lambda note: (note.bar, note.offset, note.string))


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
            if rows[0] and not (slices and stray):
                slices.append(_slice(rows))
            start = column + 1
    return slices


def _slice(rows: list[str]) -> _Slice:
    starts, ends = (sum(row[k] in _REPEAT_SIGNS for row in rows) > 1 for k in (0, -1))
    inside = slice(int(starts), -1 if ends else None)
    rows = [row[inside] or "-" for row in rows]
    return _Slice(tuple(rows), starts, ends)


def _bar(number: int, cut: _Slice, padded: bool, column: Fraction, times: int) -> WrittenBar:
    length = (len(cut.rows[0]) - padded) * column
    beat_type = max(4, (length / 4).denominator)
    return WrittenBar(
        number,
        length,
        int(length / 4 * beat_type),
        beat_type,
        repeat_start=cut.starts,
        repeat_times=(times or 2) if cut.ends or times else 0,
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
    following = dict(zip(onsets, [*onsets[1:], starts[-1]], strict=True))
    for note in notes:
        onset = starts[note.bar] + note.offset
        yield replace(note, length=min(MAX_LENGTH, following[onset] - onset))
