"""Master bars of a GPIF document: time signatures, repeats, signs and tempo marks."""

from __future__ import annotations

import re
from collections import defaultdict
from fractions import Fraction
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_bars import FASTEST, MAX_TIMES, SLOWEST
from roboguitarist.formats.play_order import MAX_PLAYED_BARS
from roboguitarist.formats.written import WrittenBar
from roboguitarist.formats.xml_tree import decimal, text

_TEMPO_UNITS = {
    "1": Fraction(1, 2),
    "2": Fraction(1),
    "3": Fraction(3, 2),
    "4": Fraction(2),
    "5": Fraction(3),
}
"""Quarter notes in the note value that a tempo counts."""
_Tempi = dict[int, list[tuple[Fraction, Fraction]]]


def bars_of(root: Element) -> tuple[WrittenBar, ...]:
    """All bars of a document.

    Raises:
        TabError: If there are too many, or a signature or tempo makes no sense.
    """
    elements = root.findall("MasterBars/MasterBar")
    if len(elements) > MAX_PLAYED_BARS:
        raise TabError(f"more than {MAX_PLAYED_BARS} bars")
    tempi = _tempi(root)
    bars: list[WrittenBar] = []
    ending: frozenset[int] = frozenset()
    for number, element in enumerate(elements, 1):
        written = frozenset(
            int(n) for n in re.findall(r"\d{1,2}", text(element, "AlternateEndings"))
        )
        starts = _starts(element.find("Repeat"))
        ending = written or (frozenset() if starts else ending)
        bar = _bar(element, number, ending, tempi[number - 1])
        ending = frozenset() if bar.repeat_times else ending
        bars.append(bar)
    return tuple(bars)


def _starts(repeat: Element | None) -> bool:
    return repeat is not None and repeat.get("start") == "true"


def _times(repeat: Element | None) -> int:
    if repeat is None or repeat.get("end") != "true":
        return 0
    count = repeat.get("count", "2")
    return min(MAX_TIMES, max(2, int(count))) if re.fullmatch(r"\d{1,6}", count) else 2


def _bar(
    element: Element,
    number: int,
    endings: frozenset[int],
    tempi: list[tuple[Fraction, Fraction]],
) -> WrittenBar:
    repeat = element.find("Repeat")
    beats, beat_type = _signature(element, number)
    length = Fraction(4 * beats, beat_type)
    targets = {text(target) for target in element.iterfind("Directions/Target")}
    jumps = {text(jump) for jump in element.iterfind("Directions/Jump")}
    return WrittenBar(
        number=number,
        length=length,
        beats=beats,
        beat_type=beat_type,
        tempi=tuple(sorted((share * length, tempo) for share, tempo in tempi)),
        repeat_start=_starts(repeat),
        repeat_times=_times(repeat),
        endings=endings,
        segno="Segno" in targets,
        coda="Coda" in targets,
        fine="Fine" in targets,
        to_coda="DaCoda" in jumps,
        jump=_jump(jumps),
    )


def _jump(jumps: set[str]) -> str:
    if any(jump.startswith("DaCapo") for jump in jumps):
        return "dacapo"
    return "dalsegno" if any(jump.startswith("DaSegno") for jump in jumps) else ""


def _signature(element: Element, number: int) -> tuple[int, int]:
    written = text(element, "Time") or "4/4"
    found = re.fullmatch(r"(\d{1,3})/(\d{1,3})", written)
    beats, beat_type = (int(found[1]), int(found[2])) if found else (0, 0)
    if not 0 < beats <= 64 or beat_type not in (1, 2, 4, 8, 16, 32, 64):
        raise TabError(f"time signature {written[:9]!r}", bar=number)
    return beats, beat_type


def _tempi(root: Element) -> _Tempi:
    """By bar from 0: share of the bar, and quarter notes a minute."""
    found: _Tempi = defaultdict(list)
    for automation in root.iterfind("MasterTrack/Automations/Automation"):
        bar, value = text(automation, "Bar"), text(automation, "Value").split()
        if text(automation, "Type") != "Tempo" or not re.fullmatch(r"\d{1,5}", bar) or not value:
            continue
        unit = _TEMPO_UNITS.get(value[1] if len(value) > 1 else "2", Fraction(1))
        tempo = decimal(value[0], "tempo") * unit
        if not SLOWEST <= tempo <= FASTEST:
            hint = f"{SLOWEST} to {FASTEST} quarter notes a minute"
            raise TabError(f"tempo {float(tempo):g}", bar=int(bar) + 1, hint=hint)
        share = decimal(text(automation, "Position") or "0", "position of a tempo mark")
        found[int(bar)].append((min(Fraction(1), max(Fraction(0), share)), tempo))
    return found
