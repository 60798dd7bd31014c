"""One part of a MusicXML file: walking through its measures and writing down its notes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from xml.etree.ElementTree import Element

from roboguitarist.errors import TabError
from roboguitarist.formats import musicxml_bars
from roboguitarist.formats.musicxml_bars import RawBar
from roboguitarist.formats.musicxml_marks import DYNAMICS, bend, fingers, techniques, velocity
from roboguitarist.formats.musicxml_staves import StaffDetails, pitch
from roboguitarist.formats.written import MAX_NOTES, WrittenNote
from roboguitarist.formats.xml_tree import descendants, integer, number

GRACE_LENGTH = Fraction(1, 8)
"""Quarter notes; a grace note is played just before its beat."""


@dataclass
class _Waiting:
    """A grace note waiting for the beat that it leads to."""

    element: Element
    slot: int


class PartReader:
    """Reads the measures of a part one after the other.

    Attributes:
        notes: What was read.
        bars: One for each measure.
        details: Strings and tuning.
        n_unpitched: Number of notes without pitch.
    """

    def __init__(self) -> None:
        self.notes: list[WrittenNote] = []
        self.bars: list[RawBar] = []
        self.details = StaffDetails()
        self.n_unpitched = 0
        self._divisions = Fraction(1)
        self._signature: tuple[int, int] | None = (4, 4)
        self._ending: frozenset[int] = frozenset()
        self._now = self._chord_start = self._here = Fraction(0)
        self._grace: list[_Waiting] = []
        self._velocity: int | None = None
        self._elements = 0
        self._complaints: Counter[str] = Counter()

    def warnings(self) -> tuple[str, ...]:
        """One line for each kind of thing that was not read as written."""
        return tuple(
            f"{what} ({count} times)" if count > 1 else what
            for what, count in self._complaints.items()
        )

    def read(self, measure: Element) -> None:
        """Read one measure.

        Raises:
            TabError: If something in it makes no sense; it names bar and beat.
        """
        before = self.bars[-1].number if self.bars else 0
        bar = RawBar(
            musicxml_bars.bar_number(measure.get("number"), before),
            implicit=measure.get("implicit") == "yes",
            signature=self._signature,
            endings=self._ending,
        )
        self.bars.append(bar)
        self._now = self._chord_start = Fraction(0)
        try:
            for element in measure:
                self._read(element, bar)
            self._settle_grace(self._now)
        except TabError as error:
            beat = float(self._here + 1)
            raise TabError(error.reason, bar=bar.number, beat=beat, hint=error.hint) from error
        bar.signature = self._signature
        if bar.repeat_times:
            self._ending = frozenset()

    def _read(self, element: Element, bar: RawBar) -> None:
        self._here = self._now if element.find("chord") is None else self._chord_start
        match element.tag:
            case "note":
                self._read_note(element)
            case "backup":
                self._settle_grace(self._now)
                self._now = max(Fraction(0), self._now - self._duration(element))
            case "forward":
                self._settle_grace(self._now)
                self._now += self._duration(element)
            case "attributes":
                self._read_attributes(element)
            case "barline":
                self._read_barline(element, bar)
            case "direction":
                self._read_direction(element, bar)
            case "sound":
                musicxml_bars.read_sound(element, bar, self._place(element))
        bar.held = max(bar.held, self._now)

    def _read_attributes(self, attributes: Element) -> None:
        divisions = number(attributes, "divisions")
        if divisions is not None and not 0 < divisions <= 10_000_000:
            raise TabError(f"divisions of {float(divisions):g}", hint="above 0")
        self._divisions = divisions or self._divisions
        time = attributes.find("time")
        if time is not None:
            self._signature = musicxml_bars.signature(time)
        self.details.read(attributes)

    def _read_barline(self, barline: Element, bar: RawBar) -> None:
        musicxml_bars.read_barline(barline, bar)
        for ending in barline.iterfind("ending"):
            numbers = musicxml_bars.ending_numbers(ending)
            if ending.get("type") == "start":
                bar.endings = self._ending = numbers
            else:
                bar.endings = bar.endings or numbers
                self._ending = frozenset()

    def _read_direction(self, direction: Element, bar: RawBar) -> None:
        place = self._place(direction)
        for mark in direction.iterfind("direction-type/dynamics/*"):
            self._velocity = DYNAMICS.get(mark.tag, self._velocity)
        for sound in direction.iterfind("sound"):
            self._velocity = velocity(sound.get("dynamics")) or self._velocity
            musicxml_bars.read_sound(sound, bar, place)
        for metronome in direction.iterfind("direction-type/metronome"):
            complaint = musicxml_bars.read_metronome(metronome, bar, place)
            if complaint:
                self._complaints[complaint] += 1
        if direction.find("direction-type/segno") is not None:
            bar.signs.add("segno")

    def _place(self, element: Element) -> Fraction:
        offset = number(element, "offset") or Fraction(0)
        return max(Fraction(0), self._now + offset / self._divisions)

    def _duration(self, element: Element) -> Fraction:
        duration = number(element, "duration") or Fraction(0)
        if duration < 0:
            raise TabError(f"duration of {float(duration):g}", hint="0 or more")
        return duration / self._divisions

    def _read_note(self, element: Element) -> None:
        self._elements += 1
        if self._elements > 2 * MAX_NOTES:
            raise TabError(f"more than {2 * MAX_NOTES} notes and rests")
        chord = element.find("chord") is not None
        if element.find("grace") is not None:
            slot = len({waiting.slot for waiting in self._grace})
            self._grace.append(_Waiting(element, max(0, slot - 1) if chord else slot))
            return
        if not chord:
            self._settle_grace(self._now)
        length = self._duration(element)
        start = self._chord_start if chord else self._now
        if not chord:
            self._chord_start = self._now
            self._now += length
        if element.find("rest") is None and element.find("cue") is None:
            self._add(element, start, length)

    def _settle_grace(self, beat: Fraction) -> None:
        """Place waiting grace notes one after the other just before the beat."""
        slots = len({waiting.slot for waiting in self._grace})
        for waiting in self._grace:
            start = beat - (slots - waiting.slot) * GRACE_LENGTH
            if waiting.element.find("rest") is None and waiting.element.find("cue") is None:
                self._add(waiting.element, start, GRACE_LENGTH)
        self._grace.clear()

    def _add(self, element: Element, start: Fraction, length: Fraction) -> None:
        if element.find("unpitched") is not None:
            self.n_unpitched += 1
            self._complaints["a note without pitch is left out"] += 1
            return
        if length == 0:
            self._complaints["a note without duration is left out"] += 1
            return
        note = self._note(element, start, length)
        if note.pitch is None and (note.string is None or note.fret is None):
            self._complaints["a note without pitch, or string and fret, is left out"] += 1
            return
        self.notes.append(note)

    def _note(self, element: Element, start: Fraction, length: Fraction) -> WrittenNote:
        staff = integer(element, "staff") or 1
        sounding = element.find("pitch")
        written = None if sounding is None else pitch(sounding)
        left, right = fingers(element)
        fret = _technical_number(element, "fret")
        open_string = descendants(element, "notations/technical/open-string")
        return WrittenNote(
            bar=len(self.bars) - 1,
            offset=start,
            length=length,
            pitch=None if written is None else written + self.details.transposition(staff),
            string=_technical_number(element, "string"),
            fret=0 if fret is None and open_string else fret,
            voice=_voice(element),
            staff=staff,
            tied=any(tie.get("type") == "stop" for tie in _ties(element)),
            techniques=techniques(element),
            left_finger=left,
            right_finger=right,
            bend=bend(element),
            velocity=velocity(element.get("dynamics")) or self._velocity,
        )


def _ties(element: Element) -> Iterator[Element]:
    yield from element.findall("tie")
    yield from descendants(element, "notations/tied")


def _technical_number(element: Element, name: str) -> int | None:
    found = descendants(element, f"notations/technical/{name}")
    return integer(found[0], "") if found else None


def _voice(element: Element) -> int:
    """Number of the voice; any text is allowed, one without a number is the first."""
    found = re.match(r"\s*(\d{1,3})", element.findtext("voice") or "")
    return max(1, int(found.group(1))) if found else 1
