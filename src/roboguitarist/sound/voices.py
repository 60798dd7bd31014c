"""One string through a whole performance, event by event."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from roboguitarist import guitar
from roboguitarist.performance import DEAD, Performance
from roboguitarist.sound.events import NO_PLUCK, Event, string_events
from roboguitarist.sound.strings import (
    LN_60_DB,
    MUTE,
    SILENCE,
    Loop,
    dead_excitation,
    pluck_excitation,
    ring,
    tuned_loop,
)

TOUCH_S = 0.012
"""How long the plucking finger lies on the string before it lets go."""
STOP_S = 0.05
"""Time for 60 dB of decay of a string that a finger stops."""
SLIDE_GAIN = 0.35
"""What is left of a ringing that the left hand takes to another fret."""


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
        if event.damps or start >= n_samples:
            continue
        loop = _loop(performance, string, event.fret, rate_hz)
        left = before[start - before_start :]
        excitation = _excitation(performance, event, loop, left, rate_hz)
        if np.abs(excitation).max(initial=0.0) < SILENCE:
            continue
        free = max(round(min(_touched_s(following) * rate_hz, n_samples)) - start, 0)
        length = min(free + round(1.5 * STOP_S * rate_hz), n_samples - start)
        before, before_start = ring(loop, excitation, length), start
        stopped = before[free:]
        stopped *= np.exp(-LN_60_DB / STOP_S / rate_hz * np.arange(len(stopped)))
        yield start, before


def _touched_s(event: Event) -> float:
    """Time from which on the string no longer rings as before."""
    return event.time_s - TOUCH_S if event.pluck != NO_PLUCK else event.time_s


def _loop(performance: Performance, string: int, fret: int, rate_hz: int) -> Loop:
    if fret == DEAD:
        return MUTE
    pitch = performance.tablature.tuning[string - 1] + fret
    return tuned_loop(440.0 * 2 ** ((pitch - 69) / 12), rate_hz)


def _excitation(
    performance: Performance, event: Event, loop: Loop, left: np.ndarray, rate_hz: int
) -> np.ndarray:
    """What starts a voice: a pluck, and what is left of the voice before."""
    grain = _grain(left, loop.period)
    if event.pluck == NO_PLUCK:
        return SLIDE_GAIN * grain
    rng = np.random.default_rng([abs(performance.seed), event.pluck])
    speed = float(performance.pluck_speed_m_s[event.pluck])
    if event.fret == DEAD:
        return dead_excitation(speed, rate_hz, rng)
    burst = pluck_excitation(loop.period, _position(performance, event), speed, rate_hz, rng)
    out = np.zeros(max(len(burst), len(grain)))
    out[: len(burst)] = burst
    out[: len(grain)] += grain
    return out


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
