"""One string through a whole performance, event by event."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from roboguitarist import guitar
from roboguitarist.performance import DEAD, PRESS_THRESHOLD_N, Performance
from roboguitarist.sound.damping import LN_60_DB, Tone
from roboguitarist.sound.events import NO_PLUCK, Event, Move, string_events
from roboguitarist.sound.loop import Loop, tuned_loop
from roboguitarist.sound.strings import (
    MUTE,
    SILENCE,
    dead_excitation,
    pluck_excitation,
    ring,
    two_polarisations,
)

TOUCH_S = 0.012
"""How long the plucking finger lies on the string before it lets go."""
STOP_S = 0.05
"""Time for 60 dB of decay of a string that a finger stops."""
KEPT = {Move.HAMMER_ON: 0.5, Move.PULL_OFF: 0.45, Move.SLIDE: 0.35, Move.DAMP: 0.0}
"""What is left of a ringing that the left hand takes to another fret."""
FIRM_N = 1.6
"""Press force from which on a fretted string does not buzz; below, it meets the wire."""
BUZZ = 7.0
"""Strength of the worst buzz."""


def string_voices(
    performance: Performance, string: int, rate_hz: int, n_samples: int
) -> Iterator[tuple[int, np.ndarray]]:
    """Force of a string (1 to 6) on the bridge, as pieces to be added up.

    A voice is the ringing from one event on. The next event stops it, and the new voice takes
    over what is left.

    Yields:
        First sample of a voice, and its samples (n,), none beyond `n_samples`.
    """
    events = [*string_events(performance, string), Event(np.inf, DEAD)]
    before, before_start = np.zeros(0), 0
    for event, following in pairwise(events):
        start = round(event.time_s * rate_hz)
        if event.move is Move.DAMP or start >= n_samples:
            continue
        loop = _loop(performance, string, event.fret, rate_hz)
        left = before[start - before_start :]
        excitation = _excitation(performance, event, loop, left, rate_hz)
        if np.abs(excitation).max(initial=0.0) < SILENCE:
            continue
        free = max(round(min(_touched_s(following) * rate_hz, n_samples)) - start, 0)
        length = min(free + round(1.5 * STOP_S * rate_hz), n_samples - start)
        before, before_start = two_polarisations(loop, ring(loop, excitation, length)), start
        before += _buzz(performance, string, event, before, rate_hz)
        stopped = before[free:]
        stopped *= np.exp(-LN_60_DB / STOP_S / rate_hz * np.arange(len(stopped)))
        yield start, before


def _touched_s(event: Event) -> float:
    """Time from which on the string no longer rings as before."""
    return event.time_s - TOUCH_S if event.pluck != NO_PLUCK else event.time_s


def _loop(performance: Performance, string: int, fret: int, rate_hz: int) -> Loop:
    if fret == DEAD:
        return MUTE
    return tuned_loop(tone(performance, string, fret), rate_hz)


def tone(performance: Performance, string: int, fret: int) -> Tone:
    """A string (1 to 6) of a performance as it sounds at a fret counted from the nut."""
    board = guitar.preset(performance.guitar)
    pitch = performance.tablature.tuning[string - 1] + fret
    length_m = board.scale_length_m - float(board.fret_x(fret))
    return Tone(string, 440.0 * 2 ** ((pitch - 69) / 12), length_m)


def _excitation(
    performance: Performance, event: Event, loop: Loop, left: np.ndarray, rate_hz: int
) -> np.ndarray:
    """What starts a voice: a pluck, and what is left of the voice before."""
    grain = _grain(left, loop.period)
    if event.pluck == NO_PLUCK:
        return KEPT[event.move or Move.SLIDE] * grain
    rng = np.random.default_rng([abs(performance.seed), event.pluck])
    speed = float(performance.pluck_speed_m_s[event.pluck])
    if event.fret == DEAD:
        return dead_excitation(speed, rate_hz, rng)
    burst = pluck_excitation(loop.period, _position(performance, event), speed, rate_hz, rng)
    out = np.zeros(max(len(burst), len(grain)))
    out[: len(burst)] = burst
    out[: len(grain)] += grain
    return out


def _buzz(
    performance: Performance, string: int, event: Event, voice: np.ndarray, rate_hz: int
) -> np.ndarray | float:
    """What a string adds that is pressed just enough to sound: it beats on the wire.

    The string meets the wire at the top of its swing; the swing must be wide for that, so the
    buzz ends before the tone does.
    """
    force_n = _press_force_n(performance, string, event)
    if event.pluck == NO_PLUCK or not PRESS_THRESHOLD_N <= force_n < FIRM_N:
        return 0.0
    worst = (FIRM_N - force_n) / (FIRM_N - PRESS_THRESHOLD_N)
    peak = np.abs(voice[: rate_hz // 20]).max(initial=0.0)
    beyond = np.maximum(voice - 0.3 * peak, 0.0)
    return BUZZ * worst * np.diff(beyond, n=2, prepend=[0.0, 0.0])


def _press_force_n(performance: Performance, string: int, event: Event) -> float:
    """Force behind the fret at the tick nearest to an event, 0 for an open string."""
    if event.fret <= performance.tablature.capo or not performance.time_s.size:
        return 0.0
    tick = int(np.argmin(np.abs(performance.time_s - event.time_s)))
    force_n = performance.press_force_n
    return (
        float(force_n[tick, string - 1, event.fret - 1]) if event.fret <= force_n.shape[2] else 0.0
    )


def _grain(left: np.ndarray, period: float) -> np.ndarray:
    """The next two periods of a voice, faded in and out.

    In a loop of the same pitch the fades of successive rounds add up to 1, so that the ringing
    goes on unchanged from the second period on.
    """
    window = np.hanning(round(2 * period) + 1)[:-1]
    return window[: len(left)] * left[: len(window)]


def _position(performance: Performance, event: Event) -> float:
    """Distance of the plucked point from the bridge, in speaking lengths."""
    board = guitar.preset(performance.guitar)
    to_bridge = board.scale_length_m - float(performance.pluck_x_m[event.pluck])
    speaking = board.scale_length_m - float(board.fret_x(event.fret))
    return float(np.clip(to_bridge / speaking, 0.03, 0.97))
