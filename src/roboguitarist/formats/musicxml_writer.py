"""Writing MusicXML: one part on a tab staff, with the fingers of both hands.

A piece is written as it is played, repeats written out.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from roboguitarist.formats.lanes import (
    Lane,
    Piece,
    from_the_start,
    grace_notes,
    in_bars,
    lanes,
    next_on_string,
)  # fmt: skip
from roboguitarist.formats.musicxml_notations import FORTE, notations, play
from roboguitarist.formats.note_values import NoteValue, split
from roboguitarist.formats.ticks import TickedBar, in_ticks
from roboguitarist.tablature import Bar, Note, Tablature, Technique

DIVISIONS = (8, 24, 120, 480, 960, 10_080, 26_880, 10_000_000)
_STEPS = "C C# D D# E F F# G G# A A# B".split()
_NYLON_GUITAR = 25
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write(tablature: Tablature) -> bytes:
    """A tablature as the text of a MusicXML file."""
    root = Element("score-partwise", {"version": "4.0"})
    _write_header(root, tablature)
    part = SubElement(root, "part", {"id": "P1"})
    _PartWriter(tablature).write(part)
    ElementTree.indent(root)
    declaration = b'<?xml version="1.0" encoding="UTF-8"?>\n'
    return declaration + ElementTree.tostring(root, "utf-8") + b"\n"


def _write_header(root: Element, tablature: Tablature) -> None:
    _text(SubElement(root, "work"), "work-title", tablature.title)
    identification = SubElement(root, "identification")
    if tablature.composer:
        _text(identification, "creator", tablature.composer, type="composer")
    _text(SubElement(identification, "encoding"), "software", "RoboGuitarist")
    if tablature.source:
        _text(identification, "source", tablature.source)
    if tablature.grade:
        miscellaneous = SubElement(identification, "miscellaneous")
        _text(miscellaneous, "miscellaneous-field", tablature.grade, name="grade")
    score_part = SubElement(SubElement(root, "part-list"), "score-part", {"id": "P1"})
    _text(score_part, "part-name", "Guitar")
    instrument = SubElement(score_part, "score-instrument", {"id": "P1-I1"})
    _text(instrument, "instrument-name", "Guitar")
    midi = SubElement(score_part, "midi-instrument", {"id": "P1-I1"})
    _text(midi, "midi-channel", 1)
    _text(midi, "midi-program", _NYLON_GUITAR)


def _text(parent: Element, tag: str, text: object, **attributes: str) -> Element:
    element = SubElement(parent, tag, attributes)
    element.text = _NOT_XML.sub("", str(text))
    return element


class _PartWriter:
    """Writes the bars of a tablature one after the other."""

    def __init__(self, tablature: Tablature) -> None:
        self._tablature = tablature
        self._ticked = in_ticks(tablature, DIVISIONS)
        self._grace = grace_notes(self._ticked)
        small = {id(ticked) for groups in self._grace.values() for g in groups for ticked in g}
        self._notes = [ticked for ticked in self._ticked.notes if id(ticked) not in small]
        self._bars = from_the_start(self._ticked, self._notes)
        self._after = dict(next_on_string(tablature.notes))
        self._signature: tuple[int, int] | None = None

    def write(self, part: Element) -> None:
        for bar, inside in zip(self._bars, in_bars(self._bars, self._notes), strict=True):
            self._write_bar(part, bar, inside)

    def _write_bar(self, part: Element, bar: TickedBar, pieces: list[Piece]) -> None:
        measure = SubElement(part, "measure", {"number": str(bar.bar.number)})
        quarters, beat_type = bar.full
        if (bar.end - bar.start) * beat_type < quarters * self._ticked.per_quarter:
            measure.set("implicit", "yes")
        self._write_attributes(measure, bar.bar)
        for tick, tempo in self._ticked.tempi:
            first = bar is self._bars[0]
            if bar.start <= tick < bar.end or (first and tick < bar.start):
                _write_tempo(measure, tempo, max(0, tick - bar.start))
        for k, lane in enumerate(lanes(pieces) or [Lane("1")]):
            if k:
                _text(SubElement(measure, "backup"), "duration", bar.end - bar.start)
            self._write_lane(measure, bar, lane)

    def _write_attributes(self, measure: Element, bar: Bar) -> None:
        first, signature = self._signature is None, (bar.beats, bar.beat_type)
        if signature == self._signature:
            return
        self._signature = signature
        attributes = SubElement(measure, "attributes")
        if first:
            _text(attributes, "divisions", self._ticked.per_quarter)
        time = SubElement(attributes, "time")
        _text(time, "beats", bar.beats)
        _text(time, "beat-type", bar.beat_type)
        if first:
            clef = SubElement(attributes, "clef")
            _text(clef, "sign", "TAB")
            _text(clef, "line", 5)
            _write_strings(attributes, self._tablature)

    def _write_lane(self, measure: Element, bar: TickedBar, lane: Lane) -> None:
        now = bar.start
        for chord in lane.chords:
            first = chord[0]
            self._write_rest(measure, lane, first.start - now)
            for group in self._grace.pop((first.note.voice, first.start), ()):
                for k, ticked in enumerate(group):
                    self._write_grace(measure, ticked.note, chord=k > 0)
            self._write_chord(measure, lane, chord)
            now = first.end
        self._write_rest(measure, lane, bar.end - now)

    def _write_rest(self, measure: Element, lane: Lane, ticks: int) -> None:
        for length, value in split(ticks, self._ticked.per_quarter):
            note = SubElement(measure, "note")
            SubElement(note, "rest")
            _text(note, "duration", length)
            _text(note, "voice", lane.name)
            _write_value(note, value)

    def _write_grace(self, measure: Element, note: Note, *, chord: bool) -> None:
        element = SubElement(measure, "note", _dynamics(note))
        SubElement(element, "grace", {"slash": "yes"})
        if chord:
            SubElement(element, "chord")
        _write_pitch(element, self._tablature.pitch(note))
        _text(element, "voice", note.voice)
        _text(element, "type", "32nd")
        _write_head(element, note)
        element.append(notations(note, self._following(note), grace=True))
        _append_play(element, note)

    def _write_chord(self, measure: Element, lane: Lane, chord: list[Piece]) -> None:
        ticks = chord[0].end - chord[0].start
        parts = list(split(ticks, self._ticked.per_quarter))
        for k, (length, value) in enumerate(parts):
            for piece in chord:
                before = piece.from_before or k > 0
                after = piece.goes_on or k < len(parts) - 1
                element = SubElement(measure, "note", {} if before else _dynamics(piece.note))
                if piece is not chord[0]:
                    SubElement(element, "chord")
                _write_pitch(element, self._tablature.pitch(piece.note))
                _text(element, "duration", length)
                ties = [kind for kind, tied in (("stop", before), ("start", after)) if tied]
                for kind in ties:
                    SubElement(element, "tie", {"type": kind})
                _text(element, "voice", lane.name)
                _write_value(element, value)
                _write_head(element, piece.note)
                self._write_notations(element, piece.note, ties)

    def _write_notations(self, element: Element, note: Note, ties: list[str]) -> None:
        if "stop" in ties:
            marks = notations(Note(0.0, note.string, note.fret, 1.0))
        else:
            marks = notations(note, self._following(note))
        for kind in reversed(ties):
            marks.insert(0, Element("tied", {"type": kind}))
        element.append(marks)
        if "stop" not in ties:
            _append_play(element, note)

    def _following(self, note: Note) -> tuple[Technique, ...]:
        following = self._after.get(note.place)
        return following.techniques if following else ()


def _write_strings(attributes: Element, tablature: Tablature) -> None:
    details = SubElement(attributes, "staff-details")
    _text(details, "staff-lines", len(tablature.tuning))
    for line, pitch in enumerate(reversed(tablature.tuning), 1):
        tuning = SubElement(details, "staff-tuning", {"line": str(line)})
        _write_steps(tuning, pitch, "tuning-")
    if tablature.capo:
        _text(details, "capo", tablature.capo)


def _write_steps(element: Element, pitch: int, prefix: str = "") -> None:
    step = _STEPS[pitch % 12]
    _text(element, f"{prefix}step", step[0])
    if step[1:]:
        _text(element, f"{prefix}alter", 1)
    _text(element, f"{prefix}octave", pitch // 12 - 1)


def _write_pitch(note: Element, pitch: int) -> None:
    _write_steps(SubElement(note, "pitch"), pitch)


def _write_value(note: Element, value: NoteValue | None) -> None:
    if value is None:
        return
    _text(note, "type", value.name)
    for _ in range(value.dots):
        SubElement(note, "dot")
    if value.actual != value.normal:
        modification = SubElement(note, "time-modification")
        _text(modification, "actual-notes", value.actual)
        _text(modification, "normal-notes", value.normal)


def _write_head(element: Element, note: Note) -> None:
    if Technique.DEAD in note.techniques:
        _text(element, "notehead", "x")


def _append_play(element: Element, note: Note) -> None:
    how = play(note)
    if how is not None:
        element.append(how)


def _dynamics(note: Note) -> dict[str, str]:
    return {} if note.velocity is None else {"dynamics": f"{100 * note.velocity / FORTE:.2f}"}


def _write_tempo(measure: Element, tempo: float, offset: int) -> None:
    direction = SubElement(measure, "direction", {"placement": "above"})
    metronome = SubElement(SubElement(direction, "direction-type"), "metronome")
    _text(metronome, "beat-unit", "quarter")
    _text(metronome, "per-minute", f"{tempo:.2f}".rstrip("0").rstrip("."))
    if offset:
        _text(direction, "offset", offset)
    SubElement(direction, "sound", {"tempo": repr(tempo)})
