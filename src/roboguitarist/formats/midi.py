"""MIDI files to the score as written.

MIDI knows pitches and times only; strings and frets are found by `arrangement`, unless a track
says in a text event how its channels are the strings of a guitar, as `midi_writer` does.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import mido

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_bars import FASTEST, SLOWEST
from roboguitarist.formats.written import WrittenBar, WrittenNote, WrittenPart, WrittenScore
from roboguitarist.tablature import N_STRINGS

MAX_BYTES = 1_000_000
MAX_TICKS = 2**31
MAX_BARS = 10_000
DRUM_CHANNEL = 9
MAX_UNENDED = 0.1
"""Share of a track's notes that may never end and are given an end."""
BASS_PROGRAMS = range(32, 40)
"""Counted from 0, as in the file."""
STRINGS = "strings on channels 1 to 6, tuning {tuning}, capo {capo}"
"""Text event of a track whose channels are strings; tuning in MIDI pitches, string 1 first."""
_STRINGS = re.compile(r"strings on channels 1 to 6, tuning ((?:\d{1,3} ?){6}), capo (\d{1,2})")
_DIVISION = slice(12, 14)


@dataclass(frozen=True, slots=True)
class _Sounding:
    """A note in ticks."""

    start: int
    end: int
    pitch: int
    channel: int
    velocity: int


@dataclass
class _Track:
    """What one instrument plays."""

    name: str = ""
    notes: list[_Sounding] = field(default_factory=list)
    programs: set[int] = field(default_factory=set)
    strings: tuple[tuple[int, ...], int] | None = None
    unended: int = 0


@dataclass
class _Conductor:
    """What holds for all tracks: by tick, the tempo and the time signature; the title."""

    tempi: dict[int, Fraction] = field(default_factory=dict)
    signatures: dict[int, tuple[int, int]] = field(default_factory=dict)
    end: int = 0
    title: str = ""


def read(data: bytes) -> WrittenScore:
    """Read a MIDI file.

    Raises:
        TabError: If it is broken, or absurd in time or size.
    """
    if len(data) > MAX_BYTES:
        raise TabError("MIDI file too large", hint=f"at most {MAX_BYTES // 10**6} MB")
    if len(data) >= 14 and data[_DIVISION] == b"\0\0":
        raise TabError("a MIDI file with no ticks in a quarter note (division 0)")
    if len(data) >= 14 and data[12] & 0x80:
        raise TabError("a MIDI file in film frames", hint="one in ticks per quarter note")
    try:
        file = mido.MidiFile(file=io.BytesIO(data), clip=True, charset="latin-1")
    except Exception as error:  # mido has no error of its own
        raise TabError(f"broken MIDI file: {str(error)[:80] or 'it ends too early'}") from error
    conductor = _Conductor()
    mixed = file.type == 0  # all instruments in one track
    tracks = [found for track in file.tracks for found in _tracks(track, conductor, mixed)]
    bars = tuple(_bars(conductor, file.ticks_per_beat))
    parts = (_part(track, k, file.ticks_per_beat, bars) for k, track in enumerate(tracks, 1))
    return WrittenScore(bars, tuple(parts), title=conductor.title)


def _tracks(messages: Iterable[Any], conductor: _Conductor, mixed: bool) -> Iterator[_Track]:
    """Instruments of one track: one, or one for each channel where they are no strings."""
    track = _Track()
    by_channel: dict[int, set[int]] = {}
    sounding: dict[tuple[int, int], list[tuple[int, int]]] = {}
    now = 0
    for message in messages:
        now += message.time
        if now > MAX_TICKS:
            raise TabError("a MIDI file that goes on for ever")
        if message.is_meta:
            _read_meta(message, now, track, conductor)
        elif message.type == "program_change":
            by_channel.setdefault(message.channel, set()).add(message.program)
        elif message.type == "note_on" and message.velocity:
            starts = sounding.setdefault((message.channel, message.note), [])
            starts.append((now, message.velocity))
        elif message.type in ("note_on", "note_off"):
            starts = sounding.get((message.channel, message.note))
            if starts:
                start, velocity = starts.pop(0)
                note = _Sounding(start, now, message.note, message.channel, velocity)
                track.notes.append(note)
    for (channel, pitch), starts in sounding.items():
        track.unended += len(starts)
        for start, velocity in starts:
            track.notes.append(_Sounding(start, now, pitch, channel, velocity))
    conductor.end = max(conductor.end, now)
    track.notes.sort(key=lambda note: (note.start, note.channel, note.pitch))
    yield from _by_instrument(track, by_channel, mixed)


def _by_instrument(track: _Track, programs: dict[int, set[int]], mixed: bool) -> Iterator[_Track]:
    channels = sorted({note.channel for note in track.notes})
    if track.strings is not None or len(channels) < 2 or not mixed:
        track.programs = {p for channel in channels for p in programs.get(channel, ())}
        if channels:
            yield track
        return
    for channel in channels:
        notes = [note for note in track.notes if note.channel == channel]
        name = f"{track.name} channel {channel + 1}".strip()
        yield _Track(name, notes, programs.get(channel, set()), unended=track.unended)


def _read_meta(message: Any, now: int, track: _Track, conductor: _Conductor) -> None:
    match message.type:
        case "set_tempo":
            tempo = Fraction(60_000_000, max(1, message.tempo))
            if not SLOWEST <= tempo <= FASTEST:
                hint = f"{SLOWEST} to {FASTEST} quarter notes a minute"
                raise TabError(f"tempo {float(tempo):g}", hint=hint)
            conductor.tempi[now] = tempo
        case "time_signature":
            numerator, denominator = message.numerator, message.denominator
            if not 0 < numerator <= 64 or not 0 < denominator <= 64:
                raise TabError("time signature makes no sense")
            conductor.signatures[now] = numerator, denominator
        case "track_name" if not track.name:
            track.name = _decoded(message.name).strip("\0 ")[:100]
            conductor.title = conductor.title or track.name
        case "text":
            found = _STRINGS.fullmatch(message.text)
            if found:
                tuning = tuple(int(pitch) for pitch in found[1].split())
                track.strings = tuning, int(found[2])


def _decoded(text: str) -> str:
    """A text that was read as Latin-1, in UTF-8 if it makes sense so."""
    try:
        return text.encode("latin-1").decode()
    except UnicodeDecodeError:
        return text


def _bars(conductor: _Conductor, per_quarter: int) -> Iterator[WrittenBar]:
    """Bars from one time signature to the next, and on to the end of all tracks."""
    changes = sorted({0: (4, 4), **conductor.signatures}.items())
    tempi = sorted(conductor.tempi.items())
    number, k = 1, 0
    ends = [*(tick for tick, _ in changes[1:]), max(conductor.end, 1)]
    for (start, (beats, beat_type)), end in zip(changes, ends, strict=True):
        length = Fraction(4 * beats * per_quarter, beat_type)
        now = Fraction(start)
        while now < end:
            following = min(now + length, Fraction(end)) if end != ends[-1] else now + length
            inside = []
            while k < len(tempi) and tempi[k][0] < following:
                inside.append((max(Fraction(0), tempi[k][0] - now) / per_quarter, tempi[k][1]))
                k += 1
            quarters = (following - now) / per_quarter
            yield WrittenBar(number, quarters, beats, beat_type, tuple(inside))
            if number > MAX_BARS:
                raise TabError(f"more than {MAX_BARS} bars")
            number, now = number + 1, following


def _part(
    track: _Track, number: int, per_quarter: int, bars: tuple[WrittenBar, ...]
) -> WrittenPart:
    tuning, capo = track.strings or (None, 0)
    drums = all(note.channel == DRUM_CHANNEL for note in track.notes) and tuning is None
    bass = bool(track.programs) and all(program in BASS_PROGRAMS for program in track.programs)
    obstacle = "it is a drum part" if drums else "it is a bass part" if bass else ""
    if track.unended > MAX_UNENDED * len(track.notes):
        obstacle = f"{track.unended} of its {len(track.notes)} notes never end"
    ends = f"{track.unended} notes never end; they last until the track does"
    return WrittenPart(
        name=track.name or f"track {number}",
        notes=tuple(_notes(track, per_quarter, bars)),
        tuning=tuning,
        capo=capo,
        obstacle=obstacle,
        warnings=(ends,) if track.unended else (),
    )


def _notes(track: _Track, per_quarter: int, bars: tuple[WrittenBar, ...]) -> Iterator[WrittenNote]:
    bar, start = 0, Fraction(0)
    for note in track.notes:
        quarter = Fraction(note.start, per_quarter)
        while bar < len(bars) - 1 and start + bars[bar].length <= quarter:
            start += bars[bar].length
            bar += 1
        string, fret = _place(note, track)
        yield WrittenNote(
            bar,
            quarter - start,
            Fraction(max(1, note.end - note.start), per_quarter),
            pitch=note.pitch,
            string=string,
            fret=fret,
            velocity=note.velocity,
        )


def _place(note: _Sounding, track: _Track) -> tuple[int | None, int | None]:
    if track.strings is None or note.channel >= N_STRINGS:
        return None, None
    tuning, capo = track.strings
    return note.channel + 1, note.pitch - tuning[note.channel] - capo
