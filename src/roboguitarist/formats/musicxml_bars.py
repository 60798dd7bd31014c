"""Bars of a MusicXML file: bar lines, signatures, tempo marks, and how long each bar lasts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import zip_longest
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats.written import WrittenBar
from roboguitarist.formats.xml_tree import decimal, integer, text

_UNITS = {
    "maxima": Fraction(32),
    "long": Fraction(16),
    "breve": Fraction(8),
    "whole": Fraction(4),
    "half": Fraction(2),
    "quarter": Fraction(1),
    "eighth": Fraction(1, 2),
    "16th": Fraction(1, 4),
    "32nd": Fraction(1, 8),
    "64th": Fraction(1, 16),
}
SLOWEST, FASTEST = 1, 2000
"""Limits of tempo in quarter notes a minute."""
MAX_TIMES = 100


@dataclass
class RawBar:
    """One bar as one part writes it; lengths in quarter notes."""

    number: int
    implicit: bool = False
    held: Fraction = Fraction(0)
    signature: tuple[int, int] | None = (4, 4)
    tempi: dict[Fraction, Fraction] = field(default_factory=dict)
    repeat_start: bool = False
    repeat_times: int = 0
    endings: frozenset[int] = frozenset()
    signs: set[str] = field(default_factory=set)


def bar_number(printed: str | None, before: int) -> int:
    """Number of a bar; one without, like the second half of a divided bar, keeps the last."""
    digits = re.match(r"\d{1,6}", printed or "")
    return int(digits.group()) if digits else before


def signature(time: Element) -> tuple[int, int] | None:
    """Beats and beat type of a time signature, None for free time.

    Raises:
        TabError: If the numbers are absurd.
    """
    if time.find("senza-misura") is not None:
        return None
    pairs = []
    for beats, beat_type in zip(time.iterfind("beats"), time.iterfind("beat-type"), strict=False):
        for digits in re.findall(r"\d+", text(beats)):
            pairs.append((int(digits[:4]), integer(beat_type, "") or 4))
    smallest = max((unit for _, unit in pairs), default=4)
    total = sum(Fraction(count * smallest, unit) for count, unit in pairs if unit > 0)
    if not 0 < total <= 256 or not 0 < smallest <= 256:
        raise TabError("time signature makes no sense")
    return round(total), smallest


def read_barline(barline: Element, bar: RawBar) -> None:
    """Take over repeat signs from a bar line."""
    repeat = barline.find("repeat")
    if repeat is None:
        return
    if repeat.get("direction") == "forward":
        bar.repeat_start = True
    else:
        times = repeat.get("times", "2")
        bar.repeat_times = min(int(times), MAX_TIMES) if re.fullmatch(r"\d{1,6}", times) else 2


def ending_numbers(ending: Element) -> frozenset[int]:
    """Numbers of an ending bracket, as in "1, 2" or "1-3"."""
    numbers: set[int] = set()
    for first, last in re.findall(r"(\d{1,3})(?:\s*-\s*(\d{1,3}))?", ending.get("number", "")):
        numbers |= set(range(int(first), min(int(last or first), MAX_TIMES) + 1))
    return frozenset(numbers)


def read_sound(sound: Element, bar: RawBar, place: Fraction) -> None:
    """Take over tempo and signs from an element with playback instructions."""
    tempo = sound.get("tempo")
    if tempo is not None:
        _set_tempo(bar, place, decimal(tempo, "tempo"))
    for sign in ("segno", "coda", "tocoda", "fine", "dacapo", "dalsegno"):
        if sound.get(sign) not in (None, "no"):
            bar.signs.add(sign)


def read_metronome(metronome: Element, bar: RawBar, place: Fraction) -> str:
    """Take over a metronome mark unless the place has a tempo; returns a complaint or nothing."""
    found = re.search(r"\d{1,4}(\.\d{1,6})?", text(metronome, "per-minute"))
    units = [unit.text or "" for unit in metronome.iterfind("beat-unit")]
    if found is None or len(units) != 1 or units[0].strip() not in _UNITS:
        return "a metronome mark without a number is not followed"
    dots = len(metronome.findall("beat-unit-dot"))
    unit = _UNITS[units[0].strip()] * (2 - Fraction(1, 2 ** min(dots, 4)))
    if place not in bar.tempi:
        _set_tempo(bar, place, Fraction(found.group()) * unit)
    return ""


def _set_tempo(bar: RawBar, place: Fraction, tempo: Fraction) -> None:
    if not SLOWEST <= tempo <= FASTEST:
        hint = f"{SLOWEST} to {FASTEST} quarter notes a minute"
        raise TabError(f"tempo {float(tempo):g}", hint=hint)
    bar.tempi[place] = tempo


def merge(parts: Sequence[Sequence[RawBar]]) -> tuple[WrittenBar, ...]:
    """Bars that all parts share: signs that any of them writes, lengths that the fullest has."""
    rows = [[bar for bar in row if bar is not None] for row in zip_longest(*parts)]
    return tuple(_merged(row, after) for row, after in zip_longest(rows, rows[1:], fillvalue=[]))


def _merged(row: list[RawBar], following: list[RawBar]) -> WrittenBar:
    signs = {sign for bar in row for sign in bar.signs}
    tempi = {place: tempo for bar in reversed(row) for place, tempo in bar.tempi.items()}
    beats, beat_type = row[0].signature or (4, 4)
    return WrittenBar(
        number=row[0].number,
        length=_length(row, following),
        beats=beats,
        beat_type=beat_type,
        tempi=tuple(sorted(tempi.items())),
        repeat_start=any(bar.repeat_start for bar in row),
        repeat_times=max(bar.repeat_times for bar in row),
        endings=frozenset().union(*(bar.endings for bar in row)),
        segno="segno" in signs,
        coda="coda" in signs,
        to_coda="tocoda" in signs,
        fine="fine" in signs,
        jump=next((jump for jump in ("dacapo", "dalsegno") if jump in signs), ""),
    )


def _length(row: list[RawBar], following: list[RawBar]) -> Fraction:
    """How long a bar lasts: its time signature, unless it holds more or is divided.

    A bar that holds less lasts as long as what it holds if it is marked as irregular, if a
    repeat sign ends it, or if the next bar is its other half; else it is filled up with silence.
    """
    held = max(bar.held for bar in row)
    beats = row[0].signature
    if beats is None:
        return held or Fraction(4)
    full = Fraction(4 * beats[0], beats[1])
    if held > full or any(bar.implicit for bar in row):
        return held
    halved = any(bar.repeat_times for bar in row) or any(bar.implicit for bar in following)
    return held if held and halved else full
