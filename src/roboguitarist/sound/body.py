"""The guitar's body, whose modes the strings' force on the bridge sets ringing, and a room."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.signal import butter, oaconvolve, sosfilt

LOW_MODES = (
    # Hz, quality factor, gain: air, top plate, back plate, then crosswise and lengthwise bending
    (101.0, 15.0, 1.0),
    (192.0, 22.0, 1.3),
    (233.0, 25.0, 0.7),
    (291.0, 28.0, -0.5),
    (387.0, 30.0, 0.8),
    (458.0, 30.0, -0.6),
    (544.0, 32.0, 0.7),
)
"""Frequencies as commonly found on classical guitars; qualities and gains chosen, not measured."""
HIGH_MODES = 48
"""Number of modes from 600 Hz to 5 kHz, where they are too dense to name."""
HIGH_GAIN = 0.6
HIGH_QUALITY = 35.0
DIRECT = 0.8
"""Gain of what the body radiates without delay."""
CUT_HZ = 95.0
"""Below its air mode the body hardly radiates."""
LENGTH_S = 0.35
ROOM_S, ROOM_DELAY_S = 0.5, 0.012
"""Time for 60 dB of decay of a small room, and what its first echo comes later."""
ROOM_GAIN = 0.004
"""Of the room beside `DIRECT`: heard as air around the guitar, not as a hall."""
ROOM_DULL_HZ = 4000.0


@lru_cache(maxsize=4)
def response(rate_hz: int) -> np.ndarray:
    """Impulse response of the body at two microphones, (2, n) float32.

    Low modes sound the same on both sides; the high ones are spread between them.
    """
    rng = np.random.default_rng(1779)
    time_s = np.arange(round(LENGTH_S * rate_hz)) / rate_hz
    out = np.zeros((2, len(time_s)))
    for frequency_hz, quality, gain in LOW_MODES:
        out += gain * _mode(time_s, frequency_hz, quality, rate_hz)
    for even_hz in np.geomspace(620.0, 5000.0, HIGH_MODES):
        frequency_hz = even_hz * rng.uniform(0.97, 1.03)
        sides = HIGH_GAIN * rng.choice([-1, 1]) * rng.uniform(0.4, 1.0, (2, 1))
        if frequency_hz < 0.45 * rate_hz:
            out += sides * _mode(time_s, frequency_hz, HIGH_QUALITY, rate_hz)
    out *= np.cos(np.linspace(0, np.pi / 2, len(time_s)))
    out[:, 0] += DIRECT
    out = np.hstack([out, np.zeros((2, round((ROOM_S - LENGTH_S) * rate_hz)))])
    out += _room(out.shape[1], rate_hz, rng)
    cut = butter(2, CUT_HZ, "highpass", fs=rate_hz, output="sos")
    return np.asarray(sosfilt(cut, out), np.float32)


def _room(n_samples: int, rate_hz: int, rng: np.random.Generator) -> np.ndarray:
    """Echoes too dense to be told apart, different on both sides, (2, n)."""
    time_s = np.arange(n_samples) / rate_hz
    echoes = rng.standard_normal((2, n_samples)) * np.exp(-np.log(1000) / ROOM_S * time_s)
    echoes[:, time_s < ROOM_DELAY_S] = 0.0
    dull = butter(1, min(ROOM_DULL_HZ, 0.45 * rate_hz), fs=rate_hz, output="sos")
    return ROOM_GAIN * np.asarray(sosfilt(dull, echoes))


def _mode(time_s: np.ndarray, frequency_hz: float, quality: float, rate_hz: int) -> np.ndarray:
    """Impulse response of a resonator with a gain of 1 at its frequency."""
    rate = np.pi * frequency_hz / quality
    return 2 * rate / rate_hz * np.exp(-rate * time_s) * np.sin(2 * np.pi * frequency_hz * time_s)


def radiate(force: np.ndarray, rate_hz: int) -> np.ndarray:
    """Sound at two microphones of the strings' force on the bridge, (2, n) to (2, n) float32."""
    return oaconvolve(force, response(rate_hz), axes=1)[:, : force.shape[1]]
