"""Writing MIDI: one channel for each string, bends as pitch wheel, tempo and bars."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

import mido

from roboguitarist.formats.midi import STRINGS
from roboguitarist.formats.ticks import Ticked, TickedNote, in_ticks
from roboguitarist.tablature import MAX_BEND, N_STRINGS, Tablature

RESOLUTIONS = (480, 960, 10_080, 26_880, 32_760)
VELOCITY = 80
_NYLON_GUITAR = 24
_WHEEL = 8191
_BEND_STEPS = 16
_Event = tuple[int, int, mido.Message | mido.MetaMessage]


def write(tablature: Tablature) -> bytes:
    """A tablature as the bytes of a MIDI file of type 1.

    String 1 is on channel 1 and so on; a text event says so, and tells tuning and capo. Times are
    kept to the tick, of which a quarter note has as many as the piece needs.
    """
    ticked = in_ticks(tablature, RESOLUTIONS)
    file = mido.MidiFile(type=1, ticks_per_beat=ticked.per_quarter, charset="utf-8")
    file.tracks.append(_track(_conducted(tablature, ticked)))
    file.tracks.append(_track(_played(tablature, ticked)))
    buffer = io.BytesIO()
    file.save(file=buffer)
    return buffer.getvalue()


def _track(events: Iterator[_Event]) -> mido.MidiTrack:
    track, now = mido.MidiTrack(), 0
    for tick, _, message in sorted(events, key=lambda event: event[:2]):
        track.append(message.copy(time=tick - now))
        now = tick
    track.append(mido.MetaMessage("end_of_track", time=0))
    return track


def _conducted(tablature: Tablature, ticked: Ticked) -> Iterator[_Event]:
    yield 0, 0, mido.MetaMessage("track_name", name=tablature.title)
    signature = None
    for bar in ticked.bars:
        if (bar.bar.beats, bar.bar.beat_type) != signature:
            signature = bar.bar.beats, bar.bar.beat_type
            beats, beat_type = signature
            message = mido.MetaMessage("time_signature", numerator=beats, denominator=beat_type)
            yield bar.start, 1, message
    for tick, tempo in ticked.tempi:
        yield tick, 2, mido.MetaMessage("set_tempo", tempo=round(60_000_000 / tempo))


def _played(tablature: Tablature, ticked: Ticked) -> Iterator[_Event]:
    tuning = " ".join(map(str, tablature.tuning))
    text = STRINGS.format(tuning=tuning, capo=tablature.capo)
    yield 0, 0, mido.MetaMessage("track_name", name="Guitar")
    yield 0, 0, mido.MetaMessage("text", text=text)
    for channel in range(N_STRINGS):
        yield 0, 1, mido.Message("program_change", channel=channel, program=_NYLON_GUITAR)
        yield from _bend_range(channel)
    for note in ticked.notes:
        channel, pitch = note.note.string - 1, min(127, tablature.pitch(note.note))
        velocity = note.note.velocity or VELOCITY
        on = mido.Message("note_on", channel=channel, note=pitch, velocity=velocity)
        yield note.start, 4, on
        yield note.end, 3, mido.Message("note_off", channel=channel, note=pitch)
        yield from _bent(note, channel)


def _bend_range(channel: int) -> Iterator[_Event]:
    """Let the whole way of the pitch wheel be an octave: registered parameter 0."""
    for control, value in ((101, 0), (100, 0), (6, MAX_BEND), (38, 0)):
        message = mido.Message("control_change", channel=channel, control=control, value=value)
        yield 0, 2, message


def _bent(note: TickedNote, channel: int) -> Iterator[_Event]:
    if not note.note.bend:
        return
    for k in range(_BEND_STEPS + 1):
        tick = note.start + k * (note.end - note.start) // _BEND_STEPS
        height = _height(note.note.bend, k / _BEND_STEPS)
        value = min(_WHEEL, round(height * _WHEEL / MAX_BEND))
        order = 5 if k < _BEND_STEPS else 2
        value = value if k < _BEND_STEPS else 0
        yield tick, order, mido.Message("pitchwheel", channel=channel, pitch=value)


def _height(curve: Sequence[tuple[float, float]], share: float) -> float:
    """Semitones of a curve at a share of the time, in straight lines between its points."""
    before = curve[0]
    for after in curve:
        if after[0] >= share:
            width = after[0] - before[0]
            weight = (share - before[0]) / width if width else 1.0
            return before[1] + weight * (after[1] - before[1])
        before = after
    return before[1]
