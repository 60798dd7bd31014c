"""From a performance to stereo samples and a file."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from roboguitarist import storage
from roboguitarist.guitar import STRINGS
from roboguitarist.performance import Performance
from roboguitarist.sound.body import radiate
from roboguitarist.sound.sympathy import sympathetic
from roboguitarist.sound.voices import string_voices

TAIL_S = 1.5
"""Time to ring out after the last event."""
FADE_S = 0.4
GAIN = 0.6
"""The same for every performance, so that soft playing stays soft."""
CEILING = 0.97
LOOK_AHEAD_S = 0.006
WIDTH = 0.35
"""Place of the outer strings between the middle (0) and one side (1); the bass is left."""


def synthesize(performance: Performance, rate_hz: int = 44100) -> np.ndarray:
    """Sound of a performance.

    Args:
        performance: What the fingers did; nothing else is heard.
        rate_hz: Sampling rate.

    Returns:
        (N, 2) float32 in [-1, 1], left and right. Sample 0 is time 0 of the piece; the sound
        ends `TAIL_S` after the last pluck or control tick.

    Raises:
        RoboGuitaristError: If the sampling rate is too low for the notes played, or the guitar
            is not known.
    """
    last_s = max([0.0, *performance.time_s[-1:], *performance.pluck_time_s[-1:]])
    force = np.zeros((6, round((last_s + TAIL_S) * rate_hz)), np.float32)
    for string in STRINGS.tolist():
        for start, voice in string_voices(performance, string, rate_hz, force.shape[1]):
            force[string - 1, start : start + len(voice)] += voice
    along = sympathetic(performance, force, rate_hz)
    angles = (1 + WIDTH * (3.5 - STRINGS) / 2.5) * np.pi / 4
    sides = np.stack([np.cos(angles), np.sin(angles)]).astype(np.float32)
    sound = GAIN * radiate(sides @ force + float(np.sqrt(0.5)) * along, rate_hz).T
    fade = round(FADE_S * rate_hz)
    sound[-fade:] *= np.cos(np.linspace(0, np.pi / 2, fade, dtype=np.float32))[:, None] ** 2
    return limited(sound, rate_hz)


def limited(sound: np.ndarray, rate_hz: int) -> np.ndarray:
    """Turn down, smoothly, where samples (N, 2) would exceed `CEILING`; the rest is unchanged.

    The gain is the running mean of the running minimum of what each sample allows, so nowhere
    more than that.
    """
    peak = np.abs(sound).max(axis=1)
    if peak.max() <= CEILING:
        return sound
    window = 2 * round(LOOK_AHEAD_S * rate_hz) + 1
    allowed = minimum_filter1d(CEILING / np.maximum(peak, CEILING), window)
    gain = uniform_filter1d(allowed, window)
    return np.clip(sound * gain[:, None], -1.0, 1.0)


def write_wav(path: str | Path, samples: np.ndarray, rate_hz: int = 44100) -> None:
    """Write 16-bit stereo; the bytes depend on the samples only.

    Args:
        path: File to write; it appears when it is complete.
        samples: (N, 2) in [-1, 1].
        rate_hz: Sampling rate.

    Raises:
        RoboGuitaristError: If the file cannot be written.
    """
    whole = np.round(np.clip(samples, -1.0, 1.0) * 32767).astype("<i2")
    with storage.replacing(path) as temporary, wave.open(str(temporary), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(rate_hz)
        file.writeframes(whole.tobytes())
