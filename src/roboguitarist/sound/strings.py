"""One string: a Karplus-Strong loop, excited by plucks.

The loop is y[n] = x[n] + sum_k h[k] y[n - N - k]: a round trip along the string delays by one
period and loses a little. `loop` finds the delay N and the kernel h for a string.

After K. Karplus and A. Strong, "Digital synthesis of plucked-string and drum timbres", and
D. Jaffe and J. Smith, "Extensions of the Karplus-Strong plucked-string algorithm", both Computer
Music Journal 7(2), 1983; the two polarisations after M. Karjalainen, V. Välimäki and T. Tolonen,
"Plucked-string models: from the Karplus-Strong algorithm to digital waveguides and beyond", the
same 22(3), 1998.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from roboguitarist.sound.damping import LN_60_DB
from roboguitarist.sound.loop import Loop

ALONG = 0.15
"""How loud the polarisation along the top is beside that across it, at the start."""
DEAD_DECAY_S = 0.025
"""Time for 60 dB of decay of the noise of a touched string."""
HALF_SPEED_M_S = 0.3
"""Pluck speed that gives half of the greatest loudness."""
SILENCE = 1e-5
"""Excitations weaker than this are not worth computing."""
BLOCK = 200
"""Samples from which on longer blocks save no more time."""


MUTE = Loop(1.0, BLOCK, np.zeros(1), 0)
"""A touched string: nothing comes back."""


def ring(loop: Loop, excitation: np.ndarray, length: int) -> np.ndarray:
    """The string's answer to an excitation, up to `length` samples from its start.

    Computed in blocks of a period, as no sample depends on one nearer than that. When the
    excitation is over, m periods follow from those before by m round trips at once, that is
    by the kernel convolved m times with itself.
    """
    known = min(len(excitation), length)
    length = min(length, known + loop.audible)
    delay, kernel = loop.delay, loop.kernel
    before = len(kernel) - 1
    y = np.zeros(before + length)
    y[before : before + known] = excitation[:known]
    start, free_from = before + delay, before + known + delay + len(kernel)
    while start < len(y):
        if delay < BLOCK and start >= free_from:
            free_from = start + 2 * delay + 2 * len(kernel)
            delay, kernel = 2 * delay, np.convolve(kernel, kernel)
        stop = min(start + delay, len(y))
        earlier = y[start - delay - len(kernel) + 1 : stop - delay]
        y[start:stop] += np.convolve(earlier, kernel, "valid")
        start = stop
    return y[before:]


def two_polarisations(loop: Loop, across: np.ndarray) -> np.ndarray:
    """A string that moves along the top too, where the bridge yields less and it rings longer.

    As the bridge takes the same rate from every partial, the second motion is the first, weaker and
    with that rate given back.

    Args:
        loop: The string.
        across: (n,) its motion across the top, as `ring` gives it.
    """
    grown = np.exp(loop.lingering * np.arange(len(across)))
    return across * ((1 + ALONG * grown) / (1 + ALONG))


def pluck_excitation(
    period: float, position: float, speed_m_s: float, rate_hz: int, rng: np.random.Generator
) -> np.ndarray:
    """Force on the bridge in the first period after a pluck, (n,) samples.

    An ideal string plucked at a point presses on the bridge in rectangles as wide as the time a
    wave takes over twice the distance from there to the bridge, so partials with a node at that
    point are missing. The flesh of the finger adds some noise, and both are rounded: the
    slower the finger, the more.

    Args:
        period: Samples in a period.
        position: Distance of the plucked point from the bridge in speaking lengths, 0 to 1.
        speed_m_s: Speed of the finger, at least 0; loudness saturates for fast ones.
        rate_hz: Sampling rate.
        rng: Source of the noise.
    """
    n = round(period)
    width = position * n
    pulse = np.clip(width - np.arange(n), 0.0, 1.0)
    noise = rng.standard_normal(n)
    noise -= np.roll(noise, round(width))
    burst = pulse - pulse.mean() + 0.1 * (noise - noise.mean())
    return strength(speed_m_s) * _rounded(burst, speed_m_s, rate_hz)


def dead_excitation(speed_m_s: float, rate_hz: int, rng: np.random.Generator) -> np.ndarray:
    """Short noise of a touched string that is plucked, (n,) samples; it excites no loop."""
    time_s = np.arange(round(2 * DEAD_DECAY_S * rate_hz)) / rate_hz
    noise = rng.standard_normal(len(time_s)) * np.exp(-LN_60_DB * time_s / DEAD_DECAY_S)
    return 0.4 * strength(speed_m_s) * _rounded(noise, speed_m_s, rate_hz)


def strength(speed_m_s: float) -> float:
    """Loudness of a pluck, 0 to 1; twice the speed is never more than twice as loud."""
    return speed_m_s / (speed_m_s + HALF_SPEED_M_S)


def _rounded(burst: np.ndarray, speed_m_s: float, rate_hz: int) -> np.ndarray:
    """Two first-order low-passes, and their ringing out appended."""
    cutoff_hz = 500.0 + 7000.0 * strength(speed_m_s)
    pole = np.exp(-2 * np.pi * cutoff_hz / rate_hz)
    tail = int(np.ceil(-12.0 / np.log(pole)))
    padded = np.concatenate([burst, np.zeros(tail)])
    return np.asarray(lfilter([(1 - pole) ** 2], [1.0, -2 * pole, pole**2], padded))
