"""What was performed as a Standard MIDI File, each string on its own channel."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import mido
import numpy as np

from roboguitarist import storage
from roboguitarist.performance import Performance
from roboguitarist.ringing import Ring, rings
from roboguitarist.sound.strings import strength
from roboguitarist.tablature import Tempo

TICKS_PER_QUARTER = 960
NYLON_GUITAR = 24
"""Program number in General MIDI, from 0."""
LOUDEST_M_S = 1.5
"""Speed of a pluck that gets the highest velocity."""


def write_midi(performance: Performance, path: str | Path) -> None:
    """Write what sounded: pitches as fretted, onsets as plucked, lengths as rung, and loudness.

    The tempo marks are those of the tablature, so that its bars stand where an editor draws
    them. String 1 is on channel 1, and so on. Plucks of strings that were touched but not
    pressed are left out.

    Args:
        performance: What was done.
        path: File to write; it appears when it is complete.

    Raises:
        RoboGuitaristError: If the file cannot be written.
    """
    file = midi(performance)
    with storage.replacing(path) as temporary:
        file.save(temporary)


def midi(performance: Performance) -> mido.MidiFile:
    """The file's content: a track of tempo marks and a track of notes."""
    tempi = performance.tablature.tempi
    file = mido.MidiFile(type=1, ticks_per_beat=TICKS_PER_QUARTER)
    marks: list[tuple[int, mido.MetaMessage]] = []
    for tempo in tempi:
        microseconds = round(60e6 / tempo.quarters_per_minute)
        mark = mido.MetaMessage("set_tempo", tempo=microseconds)
        marks.append((_ticks(max(0.0, tempo.onset_s), tempi), mark))
    title = mido.MetaMessage("track_name", name=_plain(performance.tablature.title))
    file.tracks.append(_track([(0, title), *marks]))
    file.tracks.append(_track([*_programs(), *_notes(performance)]))
    return file


def _programs() -> list[tuple[int, mido.Message]]:
    return [(0, mido.Message("program_change", channel=c, program=NYLON_GUITAR)) for c in range(6)]


def _notes(performance: Performance) -> list[tuple[int, mido.Message]]:
    tablature, tempi = performance.tablature, performance.tablature.tempi
    events: list[tuple[int, int, mido.Message]] = []
    for ring, speed_m_s in _sounding(performance):
        pitch = tablature.tuning[ring.string - 1] + ring.fret
        start = _ticks(ring.start_s, tempi)
        end = max(start + 1, _ticks(ring.end_s, tempi))
        loudness = strength(speed_m_s) / strength(LOUDEST_M_S)
        velocity = int(np.clip(round(127 * loudness), 1, 127))
        channel, note = ring.string - 1, int(pitch)
        on = mido.Message("note_on", channel=channel, note=note, velocity=velocity)
        off = mido.Message("note_off", channel=channel, note=note, velocity=0)
        events.append((start, 1, on))
        events.append((end, 0, off))
    # What ends comes before what begins on the same tick.
    ordered = sorted(events, key=lambda event: event[:2])
    return [(tick, message) for tick, _, message in ordered]


def _sounding(performance: Performance) -> list[tuple[Ring, float]]:
    """What rang, with the speed of its pluck in m/s; nothing that was dead."""
    speeds = {
        (max(float(time_s), 0.0), int(string)): (int(fret), float(speed))
        for time_s, string, fret, speed in zip(
            performance.pluck_time_s, performance.pluck_string,
            performance.pluck_fret, performance.pluck_speed_m_s, strict=True,
        )
    }  # fmt: skip
    found = []
    for ring in rings(performance):
        fret, speed = speeds[ring.start_s, ring.string]
        if fret == ring.fret and ring.end_s > ring.start_s:
            found.append((ring, speed))
    return found


def _ticks(time_s: float, tempi: tuple[Tempo, ...]) -> int:
    """Ticks from the start of the piece to a time."""
    quarters = 0.0
    for tempo, following in pairwise([*tempi, Tempo(np.inf, 1.0)]):
        start_s = min(max(0.0, tempo.onset_s), time_s) if tempo is not tempi[0] else 0.0
        stretch_s = min(time_s, following.onset_s) - start_s
        quarters += max(0.0, stretch_s) * tempo.quarters_per_minute / 60.0
    return round(quarters * TICKS_PER_QUARTER)


def _track(events: list[tuple[int, mido.Message | mido.MetaMessage]]) -> mido.MidiTrack:
    """Events at ticks from the start, as a track with the ticks between them."""
    track, now = mido.MidiTrack(), 0
    for tick, message in events:
        track.append(message.copy(time=tick - now))
        now = tick
    track.append(mido.MetaMessage("end_of_track", time=0))
    return track


def _plain(text: str) -> str:
    """The text in the letters that MIDI files have."""
    return text.encode("latin-1", "replace").decode("latin-1")
