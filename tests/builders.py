"""Synthetic performances, for tests of whatever reads a performance."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from roboguitarist.fingering import assign
from roboguitarist.guitar import Guitar
from roboguitarist.performance import Performance
from roboguitarist.tablature import Note, Tablature

FRETS = st.integers(0, 12)
PLUCKS = ("time_s", "string", "finger", "fret", "speed_m_s", "x_m")


@st.composite
def tablatures(draw: st.DrawFn, min_notes: int = 0) -> Tablature:
    """Tablatures in which no two notes overlap on one string, on a grid of 0.1 s."""
    notes: list[Note] = []
    steps = st.tuples(st.integers(0, 6), st.integers(1, 6), FRETS)
    for string in range(1, 7):
        tenths = 0
        for rest, length, fret in draw(st.lists(steps, max_size=4)):
            notes.append(Note(round(0.1 * (tenths + rest), 6), string, fret, 0.1 * length))
            tenths += rest + length
    if len(notes) < min_notes:
        notes = [Note(0.0, string, draw(FRETS), 0.5) for string in range(1, 1 + min_notes)]
    return Tablature(
        tuple(sorted(notes, key=lambda note: note.place)), capo=draw(st.integers(0, 3))
    )


def perfect(tablature: Tablature, control_hz: float = 30.0, lead_s: float = 0.5) -> Performance:
    """A performance that does at every moment what the tablature says.

    No two notes may overlap on one string. The joints do not move; the hands of the Shadow
    figures have 27 positions each.

    Args:
        tablature: What is played.
        control_hz: Ticks per second.
        lead_s: Time before the first and after the last note.
    """
    guitar, fingering = Guitar(), assign(tablature)
    ticks = int(np.ceil((tablature.duration_s + 2 * lead_s) * control_hz)) + 1
    time_s = np.arange(ticks) / control_hz - lead_s
    force_n = np.zeros((ticks, 6, guitar.n_frets), np.float32)
    sounding = np.full((ticks, 6), tablature.capo, np.int8)
    for note in tablature.notes:
        fret = tablature.stopped_fret(note)
        if fret:
            held = (time_s >= note.onset_s - 1e-6) & (time_s < note.end_s - 1e-6)
            force_n[held, note.string - 1, fret - 1] = 3.0
            sounding[held, note.string - 1] = fret
    count = len(tablature.notes)
    return Performance(
        tablature,
        fingering.left,
        fingering.right,
        time_s,
        np.zeros((ticks, 54), np.float32),
        force_n,
        sounding,
        np.array([note.onset_s for note in tablature.notes], float),
        np.array([note.string for note in tablature.notes], np.int8),
        fingering.right.copy(),
        np.array([note.fret + tablature.capo for note in tablature.notes], np.int8),
        np.full(count, 0.5, np.float32),
        np.full(count, guitar.sound_hole_x_m, np.float32),
        np.zeros(ticks, np.float32),
        control_hz=control_hz,
    )


def idle(tablature: Tablature) -> Performance:
    """A performance in which nothing is pressed and nothing plucked."""
    still = without_plucks(perfect(tablature), np.ones(len(tablature.notes), bool))
    silent = np.full_like(still.sounding_fret, tablature.capo)
    return replace(still, press_force_n=np.zeros_like(still.press_force_n), sounding_fret=silent)


def without_plucks(performance: Performance, drop: np.ndarray) -> Performance:
    """The performance without the plucks where `drop` (P,) is true."""
    kept = {f"pluck_{name}": getattr(performance, f"pluck_{name}")[~drop] for name in PLUCKS}
    return replace(performance, **kept)


def with_pluck(performance: Performance, time_s: float, string: int, fret: int) -> Performance:
    """The performance with one pluck more."""
    extra = {"time_s": time_s, "string": string, "finger": 0, "fret": fret}
    extra |= {"speed_m_s": 0.5, "x_m": 0.49}
    place = np.searchsorted(performance.pluck_time_s, time_s)
    arrays = {name: getattr(performance, f"pluck_{name}") for name in PLUCKS}
    more = {f"pluck_{name}": np.insert(arrays[name], place, extra[name]) for name in PLUCKS}
    return replace(performance, **more)


def moving(tablature: Tablature, lead_s: float = 0.5) -> Performance:
    """As `perfect`, with joints of the `linkage` hand: both move, one slide with the time.

    Position 0, the left forearm's x, grows by 10 mm a second from 0 at the first tick, so that
    it tells the time.
    """
    played = perfect(tablature, lead_s=lead_s)
    qpos = np.zeros((len(played.time_s), 51), np.float32)
    since_s = played.time_s - played.time_s[0]
    qpos[:, 0] = 0.01 * since_s
    qpos[:, [8, 12, 30, 34]] = 0.3 + 0.2 * np.sin(3.0 * since_s)[:, None]
    return replace(played, qpos=qpos)


def unpacked_glb(glb: bytes) -> tuple[dict[str, Any], bytes]:
    """The JSON and the binary chunk of a GLB file."""
    magic, version, length = struct.unpack_from("<III", glb)
    assert (magic, version, length) == (0x46546C67, 2, len(glb))
    size, kind = struct.unpack_from("<II", glb, 12)
    assert kind == 0x4E4F534A
    size_b, kind_b = struct.unpack_from("<II", glb, 20 + size)
    assert kind_b == 0x004E4942
    assert 28 + size + size_b == len(glb)
    return json.loads(glb[20 : 20 + size]), glb[28 + size :]
