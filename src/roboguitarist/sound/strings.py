"""One string: a Karplus-Strong loop, excited by plucks.

The loop is y[n] = x[n] + sum_k h[k] y[n - N - k]: a round trip along the string delays by one
period and loses a little. The kernel h is a sampled Gaussian. Its sum is the loss of the
fundamental, as `damping` has it; its width is what higher partials lose beside that, growing with
the square of the frequency and right at 3 kHz where sampling allows; its centre, between samples,
tunes the string; and as its taps are positive and add up to less than 1, no frequency can grow.

After K. Karplus and A. Strong, "Digital synthesis of plucked-string and drum timbres", and
D. Jaffe and J. Smith, "Extensions of the Karplus-Strong plucked-string algorithm", both Computer
Music Journal 7(2), 1983; the two polarisations after M. Karjalainen, V. Välimäki and T. Tolonen,
"Plucked-string models: from the Karplus-Strong algorithm to digital waveguides and beyond", the
same 22(3), 1998.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.signal import lfilter

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.sound.damping import LN_60_DB, Tone

BRIGHT_HZ = 3000.0
"""Where, beside the fundamental, the loss is right."""
ALONG = 0.15
"""How loud the polarisation along the top is beside that across it, at the start."""
MIN_VARIANCE = 0.25
"""Least variance of the kernel in samples squared; below it the Gaussian is undersampled."""
GREATEST_SUM = 1 - 1e-6
"""Of a kernel's taps; less than 1, so that no frequency grows."""
MAX_HALF_WIDTH = 5
"""Most taps on either side of the kernel's middle; numpy convolves up to 11 taps fastest."""
DEAD_DECAY_S = 0.025
"""Time for 60 dB of decay of the noise of a touched string."""
HALF_SPEED_M_S = 0.3
"""Pluck speed that gives half of the greatest loudness."""
SILENCE = 1e-5
"""Excitations weaker than this are not worth computing."""
BLOCK = 200
"""Samples from which on longer blocks save no more time."""


@dataclass(frozen=True)
class Loop:
    """A tuned string loop.

    Attributes:
        period: Samples in a period, not whole.
        delay: Whole samples N of delay before the first tap.
        kernel: (K,) taps h, positive, adding up to less than 1.
        audible: Samples after which nothing is heard, 96 dB below the start.
        lingering: How much slower, per sample, the polarisation along the top dies away.
    """

    period: float
    delay: int
    kernel: np.ndarray
    audible: int
    lingering: float = 0.0


MUTE = Loop(1.0, BLOCK, np.zeros(1), 0)
"""A touched string: nothing comes back."""


@lru_cache(maxsize=512)
def tuned_loop(tone: Tone, rate_hz: int) -> Loop:
    """Loop that rings as a string does.

    The centre and the sum of the kernel are corrected until the phase delay of the whole loop at
    the fundamental is one period and its loss there that of the tone.

    Raises:
        RoboGuitaristError: If the sampling rate is too low for this frequency.
    """
    frequency_hz = tone.frequency_hz
    period = rate_hz / frequency_hz
    omega = 2 * np.pi / period
    gain = np.exp(-float(tone.decay_rate(frequency_hz)) / frequency_hz)
    variance = _variance(tone, rate_hz)
    half = min(int(np.ceil(4 * np.sqrt(variance))), MAX_HALF_WIDTH)
    delay = round(period) - half
    if delay < 1:
        reason = f"{rate_hz} samples a second are too few for a string of {frequency_hz:.0f} Hz"
        raise RoboGuitaristError(reason)
    taps = np.arange(2 * half + 1)
    centre = wanted = period - delay
    kernel = np.empty(0)
    for _ in range(4):
        kernel = np.exp(-((taps - centre) ** 2) / (2 * variance))
        response = kernel @ np.exp(-1j * omega * (taps - half))
        kernel *= min(gain / abs(response), GREATEST_SUM / kernel.sum())
        centre += wanted - (half - np.angle(response) / omega)
    audible = round(1.6 * tone.decay_s(across=False) * rate_hz)
    lingering = (tone.bridge_rate() - tone.bridge_rate(across=False)) / rate_hz
    return Loop(period, delay, kernel, audible, lingering)


def _variance(tone: Tone, rate_hz: int) -> float:
    """Of the kernel in samples squared, for the loss at `BRIGHT_HZ` beside the fundamental's."""
    rates = tone.decay_rate(np.array([tone.frequency_hz, BRIGHT_HZ]))
    omegas = 2 * np.pi * np.array([tone.frequency_hz, BRIGHT_HZ]) / rate_hz
    steepness = 2 * np.diff(rates)[0] / np.diff(np.square(omegas))[0]
    return max(float(steepness / tone.frequency_hz), MIN_VARIANCE)


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
