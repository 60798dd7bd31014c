"""Open strings that nobody plucks and that ring along with the others."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter, resample_poly

from roboguitarist.performance import Performance
from roboguitarist.sound.voices import tone

COUPLING = 0.02
"""Greatest force of a string that rings along, in that of the string that drives it; chosen."""
PARTIALS = 5
SLOWER = 8
"""The low partials that matter are computed at a rate that much lower."""
FADE_S = 0.01


def sympathetic(performance: Performance, force: np.ndarray, rate_hz: int) -> np.ndarray:
    """Force on the bridge of all strings that ring along, (n,) float32.

    A string rings along while it is open and untouched. Each of its low partials is a resonator,
    driven by the force of the other strings.

    Args:
        performance: What the fingers did.
        force: (6, n) force of each string's own ringing on the bridge.
        rate_hz: Sampling rate.
    """
    n_samples = force.shape[1]
    out = np.zeros(n_samples, np.float32)
    slow_hz, n_slow = rate_hz / SLOWER, n_samples // SLOWER
    driving = force[:, : n_slow * SLOWER].reshape(6, n_slow, SLOWER).mean(axis=2)
    ringing = np.zeros(n_slow)
    for string in range(1, 7):
        free = _free(performance, string, n_slow, slow_hz)
        drive = free * (driving.sum(axis=0) - driving[string - 1])
        if drive.any():
            for resonator in _resonators(performance, string, slow_hz):
                ringing += free * lfilter(*resonator, drive)
    if ringing.any():
        out[: n_slow * SLOWER] = resample_poly(ringing.astype(np.float32), SLOWER, 1)
    return out


def _free(performance: Performance, string: int, n_samples: int, rate_hz: float) -> np.ndarray:
    """Whether the string is open and untouched, (n,) from 0 to 1, faded over `FADE_S`."""
    is_open = performance.sounding_fret[:, string - 1] == performance.tablature.capo
    time_s = np.arange(n_samples) / rate_hz
    if not performance.time_s.size:
        return np.ones(n_samples)
    changes = np.flatnonzero(np.diff(is_open)) + 1
    at_s = performance.time_s[changes]
    places = np.concatenate([[-np.inf], np.column_stack([at_s, at_s + FADE_S]).ravel()])
    levels = np.concatenate(
        [[is_open[0]], np.column_stack([~is_open[changes], is_open[changes]]).ravel()]
    )
    places[0] = min(performance.time_s[0], 0.0) - 1.0
    return np.interp(time_s, places, levels.astype(float))


def _resonators(
    performance: Performance, string: int, rate_hz: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Numerator and denominator of each partial's filter, `COUPLING` at its own frequency."""
    open_tone = tone(performance, string, performance.tablature.capo)
    found = []
    for partial in range(1, PARTIALS + 1):
        frequency_hz = float(open_tone.partial_hz(partial))
        if frequency_hz > 0.4 * rate_hz:
            break
        angle = 2 * np.pi * frequency_hz / rate_hz
        pole = np.exp(-float(open_tone.decay_rate(frequency_hz)) / rate_hz)
        gain = COUPLING * (1 - pole) * abs(1 - pole * np.exp(-2j * angle))
        found.append((np.array([0, gain]), np.array([1, -2 * pole * np.cos(angle), pole**2])))
    return found
