"""Systems of an ASCII tab: which lines are strings, and how they are tuned."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from roboguitarist.errors import TabError
from roboguitarist.formats.ascii_tuning import NOTE, by_labels
from roboguitarist.tablature import N_STRINGS

_LABEL = r"(?P<label>[A-Za-z][A-Za-z0-9#♯♭]?|[1-9](?=\s*[|:]))?"
_LINE = re.compile(rf"\s*{_LABEL}\s*(?P<body>([|:\]*]|-[-|:\d]).*)")
_MIN_DASHES = 2
_TIMES = re.compile(
    r"\(?\s*(\d{1,2})\s*\)?$|.*?[x×*]\s*(\d{1,2})\b|.*?\b(\d{1,2})\s*(?:[x×]|times\b)",
    re.IGNORECASE,
)
_WORDS = re.compile(r"\s+\(?[A-Za-z]{3}.*")
_LONGEST_COMMENT = 200


@dataclass(frozen=True, slots=True)
class StringLine:
    """One string in one system: its label, and what follows it."""

    number: int
    label: str
    body: str


@dataclass(frozen=True, slots=True)
class System:
    """Six strings over the width of the page, string 1 first.

    Attributes:
        line: Number of its first line in the file, from 1.
        rows: What stands on each string, all of one length, a bar line at the end.
        times: How often its last bar's repeat is played as said behind it, 0 if nothing is.
    """

    line: int
    rows: tuple[str, ...]
    times: int = 0


def is_string(line: str) -> bool:
    """Whether a line looks like one string of a tab.

    Between a label that is no note and the dashes there must be a bar line: `PM---` is no string.
    """
    found = _LINE.match(line)
    if found is None:
        return False
    label = found["label"] or ""
    named = bool(label) and found["body"].startswith("|")
    if found["body"].count("-") < (1 if named else _MIN_DASHES):
        return False
    return not label or bool(NOTE.fullmatch(label)) or not found["body"].startswith("-")


def systems(lines: Sequence[str]) -> tuple[list[System], tuple[int, ...]]:
    """All systems of a tab, and the tuning by its labels.

    Raises:
        TabError: If there is none, or not of six strings of a guitar.
    """
    blocks = [part for block in _blocks(lines) for part in _split(block)]
    if not blocks:
        raise TabError("no tab found", hint="six lines of dashes and frets, string 1 on top")
    tuning, upside_down = by_labels([line.label for line in blocks[0]])
    return [_system(block, upside_down) for block in blocks], tuning


def _blocks(lines: Sequence[str]) -> Iterator[list[StringLine]]:
    """Runs of lines that look like strings; single rules of dashes are none."""
    block: list[StringLine] = []
    for number, line in enumerate([*lines, ""], 1):
        found = _LINE.match(line)
        if found and is_string(line):
            block.append(StringLine(number, found["label"] or "", found["body"].rstrip()))
            continue
        if len(block) > 2:
            yield block
        block = []


def _split(block: list[StringLine]) -> list[list[StringLine]]:
    """The systems of a run: those of six strings may stand without a blank line between."""
    labels = {line.label.casefold() for line in block} - {""}
    strange = [label for label in labels if not (NOTE.fullmatch(label) or label.isdigit())]
    if strange:
        reason = f"a line is labelled {strange[0]!r}, as in a drum tab"
        raise TabError(f"line {block[0].number}: {reason}", hint="e B G D A E are read")
    if len(block) % N_STRINGS and labels:
        block = [line for line in block if line.label]  # a rule of dashes stands above
    if len(block) % N_STRINGS:
        where = f"lines {block[0].number} to {block[-1].number}"
        raise TabError(f"{where}: a tab of {len(block)} strings, not {N_STRINGS}")
    return [block[k : k + N_STRINGS] for k in range(0, len(block), N_STRINGS)]


def _system(block: list[StringLine], upside_down: bool) -> System:
    ordered = list(reversed(block)) if upside_down else block
    cut = [_without_comment(line.body) for line in ordered]
    width = max(len(body) for body, _ in cut)
    rows = tuple(body.replace(" ", "-").ljust(width, "-") + "|" for body, _ in cut)
    times = max(_times(comment) for _, comment in cut)
    return System(block[0].number, rows, times)


def _without_comment(body: str) -> tuple[str, str]:
    """A string's line, and what stands behind its last bar line if that is no music."""
    end = body.rfind("|") + 1
    if end and "-" not in body[end:]:
        return body[:end], body[end:].strip()
    return _WORDS.sub("", body), ""


def _times(comment: str) -> int:
    found = _TIMES.match(comment[:_LONGEST_COMMENT])
    return int(next(filter(None, found.groups()))) if found else 0
