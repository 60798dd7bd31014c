"""Staves of a MusicXML part: strings, tuning, capo, transposition, and doubled staves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats.written import WrittenNote
from roboguitarist.formats.xml_tree import integer, text
from roboguitarist.tablature import N_STRINGS, STANDARD_TUNING

_STEPS = {"C": 0, "D": 2, "E": 4, "F": 5, "G": 7, "A": 9, "B": 11}
MAX_TRANSPOSITION = 60
_SAME_MUSIC = 0.5
"""Share of notes with a twin from which two staves show the same music."""


@dataclass
class StaffDetails:
    """What the attributes of a part say about its strings."""

    capo: int = 0
    tab_staves: set[int] = field(default_factory=set)
    percussion: bool = False
    _transpose: dict[int, int] = field(default_factory=dict)
    _lines: int | None = None
    _tuning: dict[int, int] = field(default_factory=dict)

    def read(self, attributes: Element) -> None:
        """Take over one `<attributes>` element."""
        for clef in attributes.iterfind("clef"):
            sign = text(clef, "sign").casefold()
            if sign == "tab":
                self.tab_staves.add(_staff(clef))
            self.percussion = self.percussion or sign == "percussion"
        for transpose in attributes.iterfind("transpose"):
            semitones = (integer(transpose, "chromatic") or 0) + 12 * (
                integer(transpose, "octave-change") or 0
            )
            if abs(semitones) > MAX_TRANSPOSITION:
                raise TabError(f"transposition by {semitones} semitones", hint="at most 5 octaves")
            staves = [_staff(transpose)] if transpose.get("number") else range(100)
            self._transpose.update(dict.fromkeys(staves, semitones))
        for details in attributes.iterfind("staff-details"):
            self._read_details(details)

    def _read_details(self, details: Element) -> None:
        capo = integer(details, "capo")
        self.capo = self.capo if capo is None else capo
        tunings = details.findall("staff-tuning")
        if tunings or _staff(details) in self.tab_staves:
            self._lines = integer(details, "staff-lines") or self._lines
        for tuning in tunings:
            line = tuning.get("line", "")
            if line.isdecimal() and len(line) < 3:
                self._tuning[int(line)] = pitch(tuning, "tuning-") or 0

    def transposition(self, staff: int) -> int:
        """Semitones from written to sounding pitch."""
        return self._transpose.get(staff, 0)

    def n_strings(self, highest_used: int) -> int | None:
        """Number of strings, None if nothing tells."""
        if len(self._tuning) == max(self._tuning, default=0) and len(self._tuning) > 3:
            return len(self._tuning)
        if self._lines:
            return self._lines
        return highest_used if highest_used > N_STRINGS else None

    def tuning(self) -> tuple[int, ...] | None:
        """Open strings, string 1 first; strings that are not given are tuned as usual.

        Lines are counted from the bottom, where string 6 is; a tuning in the other direction is
        turned round, one that is written an octave high as guitar music often is, is lowered.
        """
        if not self._tuning:
            return None
        n = self.n_strings(0) or N_STRINGS
        if n != N_STRINGS:
            return tuple(self._tuning[line] for line in sorted(self._tuning, reverse=True))
        usual = dict(enumerate(reversed(STANDARD_TUNING), 1))
        given = {line: p for line, p in self._tuning.items() if line in usual}
        if len(given) == N_STRINGS and given[1] > given[N_STRINGS]:
            given = {N_STRINGS + 1 - line: p for line, p in given.items()}
        if all(9 <= p - usual[line] <= 15 for line, p in given.items()):
            given = {line: p - 12 for line, p in given.items()}
        return tuple(({**usual, **given})[line] for line in range(N_STRINGS, 0, -1))


def _staff(element: Element) -> int:
    number = element.get("number", "1")
    return int(number) if number.isdecimal() and len(number) < 3 else 1


def pitch(element: Element, prefix: str = "") -> int | None:
    """MIDI pitch written in an element, None if there is none.

    Args:
        element: Holds step, alter and octave.
        prefix: Before the names of these three.

    Raises:
        TabError: If it is not a pitch between 0 and 127.
    """
    step, octave = text(element, f"{prefix}step").upper(), integer(element, f"{prefix}octave")
    if not step and octave is None:
        return None
    if step not in _STEPS or octave is None:
        raise TabError(f"pitch {step[:9]!r} without a step from A to G or an octave")
    found = 12 * (octave + 1) + _STEPS[step] + (integer(element, f"{prefix}alter") or 0)
    if not 0 <= found <= 127:
        raise TabError(f"pitch {step}{octave} is out of range")
    return found


def one_staff(notes: Sequence[WrittenNote], tab_staves: set[int]) -> tuple[WrittenNote, ...]:
    """Notes of a part whose standard staff and tab staff show the same music, each once.

    Strings and frets come from the tab staff, fingers and techniques from both.
    """
    tab = [note for note in notes if note.staff in tab_staves]
    other = [note for note in notes if note.staff not in tab_staves]
    if not tab or not other:
        return tuple(notes)
    twins = {_moment(note): note for note in other}
    matched = sum((Counter(map(_moment, tab)) & Counter(map(_moment, other))).values())
    if matched < _SAME_MUSIC * min(len(tab), len(other)):
        return tuple(notes)
    return tuple(_with_marks(note, twins.get(_moment(note))) for note in tab)


def _moment(note: WrittenNote) -> tuple:
    """What twins share; the staves may be written in different octaves."""
    return note.bar, note.offset, (note.pitch or 0) % 12


def _with_marks(note: WrittenNote, twin: WrittenNote | None) -> WrittenNote:
    if twin is None:
        return note
    return replace(
        note,
        techniques=tuple(sorted({*note.techniques, *twin.techniques})),
        left_finger=twin.left_finger if note.left_finger is None else note.left_finger,
        right_finger=note.right_finger or twin.right_finger,
        tied=note.tied or twin.tied,
        bend=note.bend or twin.bend,
        velocity=note.velocity or twin.velocity,
    )
