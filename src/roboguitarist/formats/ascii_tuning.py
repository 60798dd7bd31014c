"""How the strings of an ASCII tab are tuned, by its labels or in words."""

from __future__ import annotations

import re
from collections.abc import Sequence

from roboguitarist.errors import TabError
from roboguitarist.tablature import STANDARD_TUNING

NOTE = re.compile(r"([A-Ga-g])([#b♯♭]?)")
_STEPS = {"c": 0, "d": 2, "e": 4, "f": 5, "g": 7, "a": 9, "b": 11}
_SIX_NOTES = re.compile(r"(?<![A-Za-z])(?:[A-Ga-g][#b♯♭]?[\s,/-]*){6}(?![A-Za-z])")
_ABOUT_TUNING = re.compile(r"tun(?:ing|ed)\b|\bdrop(?:ped)?[ -]?[a-g]\b|step down", re.IGNORECASE)
_NAMED = {
    r"double drop(ped)?[ -]?d": "D A D G B D",
    r"drop(ped)?[ -]?d": "D A D G B E",
    r"drop(ped)?[ -]?c": "C G C F A D",
    r"open[ -]?d": "D A D F# A D",
    r"open[ -]?g": "D G D G B D",
    r"open[ -]?e": "E B E G# B E",
    r"open[ -]?a": "E A E A C# E",
    r"open[ -]?c": "C G C G C E",
    r"(half|1/2|½)[ -]?(a )?step (down|lower)|down (a )?(half|1/2|½)": "Eb Ab Db Gb Bb Eb",
    r"(whole|full|one|1|a) step (down|lower)|down (a )?(whole|full|one|1) ": "D G C F A D",
}
"""Tunings by the words that guitarists use for them, lowest string first."""


def by_labels(labels: Sequence[str]) -> tuple[tuple[int, ...], bool]:
    """Open strings, string 1 first, and whether the lines stand upside down."""
    if not all(labels) or labels[0].isdigit():
        return STANDARD_TUNING, labels[0] == str(len(labels))
    ways = []
    for upside_down in (False, True):
        ordered = list(reversed(labels)) if upside_down else list(labels)
        strings = list(zip(ordered, STANDARD_TUNING, strict=True))
        pitches = [nearest(label, usual) for label, usual in strings]
        away = sum(abs(p - usual) for p, (_, usual) in zip(pitches, strings, strict=True))
        capital_first = upside_down != (labels[0].islower() and not labels[-1].islower())
        ways.append((away, not capital_first, upside_down, tuple(pitches)))
    _, _, upside_down, pitches = min(ways)
    return pitches, upside_down


def stated(said: str, lines: Sequence[str]) -> tuple[int, ...] | None:
    """A tuning in words: after `Tuning:`, or in a line that speaks of tuning."""
    for text in filter(None, (said, *(line for line in lines if _ABOUT_TUNING.search(line)))):
        notes = _SIX_NOTES.search(text[:200])
        named = (t for words, t in _NAMED.items() if re.search(rf"\b{words}\b", text[:200], re.I))
        names = NOTE.findall(notes[0] if notes else next(named, ""))
        if len(names) == len(STANDARD_TUNING):
            strings = zip(reversed(names), STANDARD_TUNING, strict=True)
            return tuple(nearest("".join(name), usual) for name, usual in strings)
    return None


def nearest(name: str, usual: int) -> int:
    """MIDI pitch of a note's name nearest to the usual one; rather lower than higher.

    Raises:
        TabError: If it is no name of a note.
    """
    found = NOTE.fullmatch(name)
    if found is None:
        raise TabError(f"{name[:9]!r} is not a note", hint="such as E, A, D, F# or Bb")
    step = _STEPS[found[1].casefold()] + {"#": 1, "♯": 1, "b": -1, "♭": -1, "": 0}[found[2]]
    return usual + (step - usual + 7) % 12 - 7
