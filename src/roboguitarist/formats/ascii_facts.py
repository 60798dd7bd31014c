"""What the words above an ASCII tab say: title, tempo, grid, capo and tuning."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from roboguitarist.errors import TabError
from roboguitarist.formats.ascii_tuning import stated

DEFAULT_GRID, DEFAULT_TEMPO = 16, 120
GRIDS = range(4, 193)
TEMPI = range(10, 1001)
CAPOS = range(13)
_FACT = re.compile(r"\s*(tempo|bpm|grid|capo|tuning|title|composer|artist)\s*[:=]\s*(.*)", re.I)
_LOOSE = (
    re.compile(r"\W*(?P<name>capo)\W+(?:\w+\W+){0,2}?(?P<value>\d{1,2}(?!\d)|[IVX]+\b).*", re.I),
    re.compile(r"\W*(?P<value>\d{2,3})\s*(?P<name>bpm)\b.*", re.I),
)
_ROMAN: tuple[str, ...] = tuple("I II III IV V VI VII VIII IX X XI XII".split())


@dataclass(frozen=True, slots=True)
class Facts:
    """What holds for a whole tab.

    Attributes:
        tempo: Quarter notes a minute.
        grid: A column is the grid-th part of a whole note.
        tuning: Open strings, string 1 first, if words say so.
        warnings: What could not be understood.
    """

    title: str
    composer: str
    tempo: Fraction
    grid: int
    capo: int
    tuning: tuple[int, ...] | None
    warnings: tuple[str, ...]


def facts(lines: Sequence[str], tempo: float | None, grid: int | None) -> Facts:
    """Facts from the lines above the first system; tempo and grid that are given hold instead.

    Raises:
        TabError: If a number is out of range.
    """
    found = _named(lines)
    warnings: list[str] = []
    said = tempo or found.get("tempo") or found.get("bpm")
    quarters = _in_range("tempo", said, TEMPI, DEFAULT_TEMPO, warnings)
    columns = _in_range("grid", grid or found.get("grid"), GRIDS, DEFAULT_GRID, warnings)
    capo = found.get("capo", "").split(maxsplit=1)[:1]
    fret = _ROMAN.index(capo[0].upper()) + 1 if capo and capo[0].upper() in _ROMAN else None
    return Facts(
        found.get("title", ""),
        found.get("composer") or found.get("artist", ""),
        quarters,
        int(columns),
        int(fret or _in_range("capo", found.get("capo"), CAPOS, 0, [])),
        stated(found.get("tuning", ""), lines),
        tuple(warnings),
    )


def _named(lines: Sequence[str]) -> dict[str, str]:
    exact = (_FACT.fullmatch(line) for line in lines)
    named = {fact[1].casefold(): fact[2].strip()[:200] for fact in exact if fact}
    for pattern in _LOOSE:
        for loose in filter(None, (pattern.fullmatch(line[:200]) for line in lines)):
            named.setdefault(loose["name"].casefold(), loose["value"])
    return named


def _in_range(
    name: str, value: object, allowed: range, usual: int, warnings: list[str]
) -> Fraction:
    """The first number in a text, or a number; the usual one, with a warning, if there is none."""
    if value is None or value == "":
        return Fraction(usual)
    digits = re.search(r"-?\d{1,6}(\.\d{1,6})?", str(value))
    if digits is None:
        warnings.append(f"{name} {str(value)[:20]!r} is no number, {usual} is taken")
        return Fraction(usual)
    number = Fraction(digits[0])
    if not allowed.start <= number < allowed.stop:
        raise TabError(f"{name} {str(value)[:20]}", hint=f"{allowed.start} to {allowed.stop - 1}")
    return number
