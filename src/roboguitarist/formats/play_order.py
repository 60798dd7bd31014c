"""The order in which written bars are played: repeats, endings, da capo, dal segno, coda, fine.

Where signs contradict each other the rule is to play every bar that can be reached and to stop:
a repeat without a start begins after the last one, a start without an end is ignored, a repeat
whose own ending was skipped still goes back while endings remain to be played.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from roboguitarist.errors import TabError
from roboguitarist.formats.written import WrittenBar

MAX_PLAYED_BARS = 10_000


@dataclass
class _Section:
    """A repeated stretch: where it starts, the bars that send back, the endings after them."""

    start: int
    closings: list[int] = field(default_factory=list)
    end: int = 0
    total: int = 2
    played: int = 0


def expand(bars: Sequence[WrittenBar]) -> list[int]:
    """Indices of the written bars in the order they are played.

    Raises:
        TabError: If more than `MAX_PLAYED_BARS` would be played, or a da capo or dal segno leads
            back for ever because nothing says where to end.
    """
    sections = _sections(bars)
    order: list[int] = []
    index, jumped = 0, False
    while index < len(bars):
        bar = bars[index]
        for section in sections:
            if section.start == index and not section.played:
                section.played = 1
        skipped = not _sounds(bar, index, sections)
        if not skipped:
            order.append(index)
        if len(order) > MAX_PLAYED_BARS:
            raise TabError(f"repeats make more than {MAX_PLAYED_BARS} bars", bar=bar.number)
        if jumped and bar.fine:
            break
        target = None if jumped else _repeat(index, sections, skipped)
        if target is None and not skipped:
            target = _jump(bars, index, jumped)
            if target is not None and not jumped:
                _check_end(bars, bar)
                jumped = True
                for section in sections:
                    section.played = section.total
        index = index + 1 if target is None else target
    return order


def _check_end(bars: Sequence[WrittenBar], bar: WrittenBar) -> None:
    if not any(other.fine or other.to_coda for other in bars):
        names = {"dacapo": "da capo", "dalsegno": "dal segno"}
        reason = f"this {names[bar.jump]} would be played for ever"
        raise TabError(reason, bar=bar.number, hint="with a fine or a coda in the score")


def _jump(bars: Sequence[WrittenBar], index: int, jumped: bool) -> int | None:
    """Where da capo, dal segno or, after one of them, "to coda" lead from the end of a bar."""
    if jumped:
        codas = (i for i in range(index + 1, len(bars)) if bars[i].coda)
        return next(codas, None) if bars[index].to_coda else None
    if bars[index].jump == "dacapo":
        return 0
    if bars[index].jump == "dalsegno":
        return max((i for i in range(index + 1) if bars[i].segno), default=0)
    return None


def _repeat(index: int, sections: list[_Section], skipped: bool) -> int | None:
    """Where a repeat sign at the end of a bar leads, if anywhere."""
    for section in sections:
        if index not in section.closings or (skipped and index != section.closings[-1]):
            continue
        if section.played < section.total:
            section.played += 1
            return section.start
    for section in sections:
        if index == section.end:
            section.played = 0
    return None


def _sounds(bar: WrittenBar, index: int, sections: list[_Section]) -> bool:
    if not bar.endings:
        return True
    inside = [section for section in sections if section.start <= index <= section.end]
    return not inside or inside[-1].played in bar.endings


def _sections(bars: Sequence[WrittenBar]) -> list[_Section]:
    """Pair the repeat signs; inner sections come after the ones around them."""
    done: list[_Section] = []
    open_sections = [_Section(0)]
    for index, bar in enumerate(bars):
        if open_sections[-1].closings and not bar.endings:
            _close(done, open_sections, index)
        if bar.repeat_start and index != open_sections[-1].start:
            if open_sections[-1].closings:
                _close(done, open_sections, index)
            if index != open_sections[-1].start:
                open_sections.append(_Section(index))
        if bar.repeat_times:
            open_sections[-1].closings.append(index)
            if not bar.endings:
                _close(done, open_sections, index + 1)
    while open_sections:
        _close(done, open_sections, len(bars))
    for section in done:
        section.total = _total(bars, section)
    return sorted(done, key=lambda section: section.start)


def _close(done: list[_Section], open_sections: list[_Section], index: int) -> None:
    """End the innermost section before `index`; one without a repeat sign is forgotten."""
    section = open_sections.pop()
    section.end = index - 1
    if section.closings:
        done.append(section)
    if not open_sections and section.closings:
        open_sections.append(_Section(index))


def _total(bars: Sequence[WrittenBar], section: _Section) -> int:
    """How often a section is played: as its signs say, and until each ending had its turn."""
    total = max(2, *(bars[index].repeat_times for index in section.closings))
    after = range(section.closings[-1] + 1, section.end + 1)
    for index in [*section.closings, *after]:
        total = max(total, *bars[index].endings, 0)
    return total
