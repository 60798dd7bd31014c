"""What stands on one string of an ASCII tab: frets, and signs for how they are played."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from roboguitarist.errors import TabError
from roboguitarist.tablature import MAX_FRET, Note, Technique

HINT = f"frets 0 to {MAX_FRET} and h p / \\ s b r t x ~ ( ) < > are read"
_TOKEN = re.compile(r"<(?P<harmonic>\d{1,2})>|(?P<frets>\d+)|(?P<sign>.)", re.DOTALL)
_JOINS = {
    "h": Technique.HAMMER_ON,
    "p": Technique.PULL_OFF,
    "/": Technique.SLIDE,
    "\\": Technique.SLIDE,
    "s": Technique.SLIDE,
}
_SILENT = set("-()[]{}<>.,'`^*+=_:")
_FULL_BEND = 2.0


@dataclass
class Sign:
    """A fret on a string.

    Attributes:
        column: Where it begins.
        fret: 0 for a dead note.
        techniques: How it is played.
        bend: Heights in semitones one after the other.
        width: Columns that its number takes.
        bracketed: A bracket stands before it.
    """

    column: int
    fret: int
    techniques: set[Technique] = field(default_factory=set)
    bend: list[float] = field(default_factory=list)
    width: int = 1
    bracketed: bool = False

    def curve(self) -> tuple[tuple[float, float], ...]:
        """The bend as a curve over the note's duration."""
        heights = [0.0, *self.bend] if self.bend else []
        last = max(1, len(heights) - 1)
        return tuple((round(k / last, 4), height) for k, height in enumerate(heights))


def signs(row: str) -> list[Sign]:
    """Frets on one string, from left to right.

    Args:
        row: The string between two bar lines.

    Raises:
        TabError: On a sign that means nothing in a tab, or a fret that is out of range.
    """
    found: list[Sign] = []
    join = ""
    for token in _TOKEN.finditer(row):
        if token["frets"]:
            bracketed = row[token.start() - 1 : token.start()] == "("
            join = _read_frets(found, join, token["frets"], token.start())
            found[-1].bracketed = bracketed and len(token["frets"]) < 3
        elif token["harmonic"]:
            fret = _checked(token["harmonic"])
            kinds = {Technique.HARMONIC}
            found.append(Sign(token.start(), fret, kinds, width=len(token[0])))
            join = ""
        else:
            join = _read_sign(found, join, token["sign"], token.start())
    _leave(found, join)
    return found


def together(rows: Sequence[Sequence[Sign]]) -> None:
    """Let chords begin at once whose frets of one and two digits stand flush right, or in brackets.

    Under the second digit of a fret no other note begins, and a bracket does not delay a note.
    """
    all_signs = [sign for row in rows for sign in row]
    inside = {sign.column + k: sign.column for sign in all_signs for k in range(1, sign.width)}
    plain = {sign.column for sign in all_signs if not sign.bracketed}
    for row in rows:
        taken = {sign.column for sign in row}
        for sign in row:
            column = inside.get(sign.column, sign.column)
            if sign.bracketed and column not in plain and column - 1 in plain:
                column -= 1
            if column not in taken:
                taken.add(column)
                sign.column = column


def _read_frets(found: list[Sign], join: str, digits: str, column: int) -> str:
    for offset, fret in _frets(digits):
        if join in ("b", "r") and found:
            found[-1].bend[-1] = float(max(0, fret - found[-1].fret))
        else:
            found.append(Sign(column + offset, fret, width=len(str(fret))))
            if join in _JOINS:
                near = len(found) > 1
                slide_in = Technique.SLIDE_IN if join in "/\\s" else None
                kind = _JOINS[join] if near else slide_in
                found[-1].techniques |= {kind} if kind else set()
        join = ""
    return join


def _frets(digits: str) -> Iterator[tuple[int, int]]:
    """Frets in a run of digits: two together where that is a fret, else one by one."""
    if len(digits) == 2:
        yield 0, _checked(digits)
        return
    k = 0
    while k < len(digits):
        size = 2 if int(digits[k : k + 2]) in range(10, MAX_FRET + 1) else 1
        yield k, int(digits[k : k + size])
        k += size


def _checked(digits: str) -> int:
    if int(digits) > MAX_FRET:
        raise TabError(f"fret {digits} (0 to {MAX_FRET})")
    return int(digits)


def _read_sign(found: list[Sign], join: str, written: str, column: int) -> str:
    """Take over a sign; returns the one that waits for the next fret."""
    sign = written.casefold()
    if sign in _JOINS:
        return sign
    if sign in _SILENT:
        if sign == "-":
            _leave(found, join)
        return "" if sign == "-" else join
    if sign == "x":
        found.append(Sign(column, 0, {Technique.DEAD}))
    elif sign in "~v" and found:
        found[-1].techniques.add(Technique.VIBRATO)
    elif sign in "br" and found:
        found[-1].techniques.add(Technique.BEND)
        found[-1].bend.append(_FULL_BEND if sign == "b" else 0.0)
        return sign
    elif sign not in "tv~":
        raise TabError(f"sign {written!r} in a tab line", hint=HINT)
    return ""


def _leave(found: list[Sign], join: str) -> None:
    """A slide that leads nowhere."""
    if join in ("/", "\\", "s") and found:
        found[-1].techniques.add(Technique.SLIDE_OUT)


_LEADING = {
    Technique.HAMMER_ON: "h",
    Technique.PULL_OFF: "p",
    Technique.SLIDE: "/",
    Technique.SLIDE_IN: "/",
}


def text_of(note: Note) -> tuple[str, str]:
    """What is written before a note's column, and from it on.

    Raises:
        TabError: Never; what has no sign is left out.
    """
    kinds = set(note.techniques)
    before = next((sign for kind, sign in _LEADING.items() if kind in kinds), "")
    if Technique.DEAD in kinds:
        return before, "x"
    fret = f"<{note.fret}>" if Technique.HARMONIC in kinds else str(note.fret)
    if Technique.BEND in kinds:
        heights = [height for _, height in note.bend[1:]] or [_FULL_BEND]
        for low, high in zip([0.0, *heights], heights, strict=False):
            fret += ("b" if high > low else "r") + str(note.fret + round(high))
    fret += "~" * (Technique.VIBRATO in kinds)
    return before, fret + "/" * (Technique.SLIDE_OUT in kinds)
