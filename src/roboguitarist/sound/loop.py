"""The filter that a string's loop goes through once a period: its losses, stiffness and tuning.

A wave on a string comes back after a round trip as a partial of the same phase, weaker by what
`damping` says. Between partials both vary smoothly with frequency, so they make up a filter: at
frequency f its loss is exp(-rate(f) / f0) and its phase as many turns as the partial that f would
be has its number, which is less than f / f0 by what stiffness adds. `tuned_loop` finds the whole
delay and the few taps nearest to that, exact at the fundamental.

This stands for the allpass filters by which D. Jaffe and J. Smith make strings stiff, and for their
filters for loss and tuning: one short filter has all three.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import solve_toeplitz

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.sound.damping import Tone

STIFF_HZ = 5000.0
"""Up to here partials are where stiffness has them; beyond, waves travel at the same speed."""
SPREAD = 1 / 6
"""How much earlier, in periods, the fastest waves may come back at most."""
MARGIN = 10
"""Taps before the earliest wave and after the latest."""
GRID = 1024
"""Frequencies from 0 to half of the sampling rate at which the filter is held to its law."""
GREATEST_GAIN = 1 - 1e-6
"""Of the filter at any frequency; less than 1, so that none grows."""


@dataclass(frozen=True)
class Loop:
    """A tuned string loop.

    Attributes:
        period: Samples in a period, not whole.
        delay: Whole samples N of delay before the first tap.
        kernel: (K,) taps h, of a gain less than 1 at every frequency.
        audible: Samples after which nothing is heard, 96 dB below the start.
        lingering: How much slower, per sample, the polarisation along the top dies away.
    """

    period: float
    delay: int
    kernel: np.ndarray
    audible: int
    lingering: float = 0.0


@lru_cache(maxsize=512)
def tuned_loop(tone: Tone, rate_hz: int) -> Loop:
    """Loop that rings as a string does.

    Raises:
        RoboGuitaristError: If the sampling rate is too low for this frequency.
    """
    period = rate_hz / tone.frequency_hz
    hz = np.linspace(0.0, rate_hz / 2, GRID + 1)
    turns, spread = _turns(tone, hz, rate_hz)
    taps = int(np.ceil(spread)) + 2 * MARGIN + 1
    delay = int(period) + MARGIN + 1 - taps
    if delay < 1:
        too_high = f"a string of {tone.frequency_hz:.0f} Hz"
        raise RoboGuitaristError(f"{rate_hz} samples a second are too few for {too_high}")
    loss = tone.decay_rate(hz) / tone.frequency_hz
    beyond = np.maximum(hz - STIFF_HZ, 0.0) / max(rate_hz / 2 - STIFF_HZ, STIFF_HZ)
    wanted = np.exp(-loss - 4 * beyond**4 - 2j * np.pi * (turns - hz * delay / rate_hz))
    omega = 2 * np.pi / period
    gain = np.exp(-float(tone.decay_rate(tone.frequency_hz)) / tone.frequency_hz)
    kernel = _nearest(wanted, 1 + loss**-2, taps, omega, gain * np.exp(1j * omega * delay))
    kernel *= min(1.0, GREATEST_GAIN / np.abs(np.fft.rfft(kernel, 16 * GRID)).max())
    audible = round(1.6 * tone.decay_s(across=False) * rate_hz)
    lingering = (tone.bridge_rate() - tone.bridge_rate(across=False)) / rate_hz
    return Loop(period, delay, kernel, audible, lingering)


def _turns(tone: Tone, hz: np.ndarray, rate_hz: int) -> tuple[np.ndarray, float]:
    """Phase of a round trip in turns, (n,), and by how many samples arrivals differ."""
    turns = tone.partial_at(hz)
    slope = np.gradient(turns, hz)
    spread = (slope[0] - slope) * rate_hz
    in_time = (hz <= STIFF_HZ) & (spread <= SPREAD * rate_hz / tone.frequency_hz)
    top = int(np.flatnonzero(in_time)[-1])
    turns[top:] = turns[top] + slope[top] * (hz[top:] - hz[top])
    return turns, float(spread[top])


def _nearest(
    wanted: np.ndarray, weight: np.ndarray, taps: int, omega: float, exact: complex
) -> np.ndarray:
    """Taps of least weighted square error, and without error at one frequency.

    Args:
        wanted: (GRID + 1,) complex response from 0 to half of the sampling rate.
        weight: (GRID + 1,) of the squared error.
        taps: Number of taps.
        omega: The frequency, in radians per sample, at which the response is to be `exact`.
        exact: The response there.
    """
    correlation = np.fft.irfft(weight)[:taps]
    turning = omega * np.arange(taps)
    constraints = np.column_stack([np.cos(turning), -np.sin(turning)])
    right = np.column_stack([np.fft.irfft(weight * wanted)[:taps], constraints])
    free, *moving = solve_toeplitz(correlation, right).T
    moving = np.column_stack(moving)
    missing = [exact.real, exact.imag] - constraints.T @ free
    return free + moving @ np.linalg.solve(constraints.T @ moving, missing)
