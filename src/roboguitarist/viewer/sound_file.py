"""Sound as browsers take it."""

from __future__ import annotations

import io
import wave
from fractions import Fraction
from typing import Any

import numpy as np
from scipy.signal import resample_poly

OPUS_HZ = 48000
OPUS_BIT_RATE = 112_000
SPARE_HZ = 22050
"""Sampling rate of the single channel that is left when nothing can encode."""


def encoded(samples: np.ndarray, rate_hz: int) -> tuple[str, bytes]:
    """Sound (N, 2) in [-1, 1] as a small file, with its media type.

    Opus in WebM, or, on a machine without PyAV, a WAV file in one channel.
    """
    try:
        import av  # noqa: PLC0415
    except ImportError:
        return "audio/wav", _wav(samples, rate_hz)
    return "audio/webm", _opus(av, samples, rate_hz)


def _opus(av: Any, samples: np.ndarray, rate_hz: int) -> bytes:
    whole = np.gcd(OPUS_HZ, rate_hz)
    sound = resample_poly(samples, OPUS_HZ // whole, rate_hz // whole, axis=0)
    sound = np.ascontiguousarray(np.clip(sound, -1, 1), np.float32)
    file = io.BytesIO()
    with av.open(file, "w", format="webm") as container:
        stream = container.add_stream("libopus", rate=OPUS_HZ, layout="stereo")
        stream.bit_rate = OPUS_BIT_RATE
        stream.codec_context.format = "flt"
        length = OPUS_HZ // 50
        for start in range(0, len(sound), length):
            block = np.zeros((length, 2), np.float32)
            part = sound[start : start + length]
            block[: len(part)] = part
            frame = av.AudioFrame.from_ndarray(block.reshape(1, -1), "flt", "stereo")
            frame.sample_rate = OPUS_HZ
            frame.pts, frame.time_base = start, Fraction(1, OPUS_HZ)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return file.getvalue()


def _wav(samples: np.ndarray, rate_hz: int) -> bytes:
    whole = np.gcd(SPARE_HZ, rate_hz)
    mono = resample_poly(samples.mean(axis=1), SPARE_HZ // whole, rate_hz // whole)
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(SPARE_HZ)
        out.writeframes(np.round(32767 * np.clip(mono, -1, 1)).astype("<i2").tobytes())
    return file.getvalue()
