"""Encoding pictures and sound to an mp4."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from roboguitarist import storage
from roboguitarist.video.errors import UnavailableError

RATE_HZ = 44100
CODECS = {
    "libopenh264": {},
    "libvpx-vp9": {"deadline": "realtime", "cpu-used": "7", "row-mt": "1", "crf": "30", "b": "0"},
    "mpeg4": {"qscale": "3"},
}
"""Video encoders in order of preference; x264, which many builds have too, is under the GPL."""
_BIT_RATE = {"libopenh264": 4_000_000, "mpeg4": 6_000_000}
_AUDIO_BIT_RATE = 192_000


def video_codec() -> str:
    """The first of `CODECS` that PyAV can encode with.

    Raises:
        UnavailableError: If PyAV is not installed or has none of them.
    """
    av = _av()
    for name in CODECS:
        if name in av.codecs_available:
            try:
                av.codec.Codec(name, "w")
            except ValueError:
                continue
            return name
    raise UnavailableError(f"PyAV has no video encoder (one of {', '.join(CODECS)} would do)")


def _av() -> Any:
    try:
        import av  # noqa: PLC0415
    except ImportError as error:
        raise UnavailableError(f"{error}; pip install 'roboguitarist[video]'") from error
    return av


@contextmanager
def film(path: str | Path, size: tuple[int, int], fps: int, samples: np.ndarray) -> Iterator[Movie]:
    """A film to add pictures to; the file appears when the block ends without an error.

    Args:
        path: File to write.
        size: Width and height in pixels, even numbers.
        fps: Pictures per second.
        samples: (N, 2) sound in [-1, 1] at `RATE_HZ`, from the first picture on.

    Raises:
        UnavailableError: If PyAV is not installed or has no encoder.
        RoboGuitaristError: If the file cannot be written.
    """
    av = _av()
    codec = video_codec()
    with storage.replacing(path) as temporary, av.open(str(temporary), "w", format="mp4") as file:
        movie = Movie(file, codec, size, fps, samples)
        yield movie
        movie.finish()


class Movie:
    """A film under construction, see `film`."""

    def __init__(
        self, file: Any, codec: str, size: tuple[int, int], fps: int, samples: np.ndarray
    ) -> None:
        self._file, self._fps = file, fps
        self._samples = np.ascontiguousarray(samples.T, np.float32)
        self._pictures = self._sounded = 0
        self._video = file.add_stream(codec, rate=fps)
        self._video.width, self._video.height = size
        self._video.pix_fmt = "yuv420p"
        self._video.bit_rate = _BIT_RATE.get(codec, 0)
        self._video.codec_context.options = dict(CODECS[codec])
        self._video.codec_context.thread_count = 2
        self._audio = file.add_stream("aac", rate=RATE_HZ, layout="stereo")
        self._audio.bit_rate = _AUDIO_BIT_RATE

    def add(self, picture: np.ndarray) -> None:
        """Add a picture (height, width, 3) uint8 and the sound that belongs to it."""
        frame = _av().VideoFrame.from_ndarray(picture, format="rgb24")
        frame.pts, frame.time_base = self._pictures, Fraction(1, self._fps)
        self._pictures += 1
        self._file.mux(self._video.encode(frame))
        self._add_sound(until=round(self._pictures * RATE_HZ / self._fps))

    def _add_sound(self, until: int) -> None:
        """Encode whole audio frames up to a sample, with silence after the end of the sound."""
        length = self._audio.codec_context.frame_size or 1024
        while self._sounded + length <= until:
            block = np.zeros((2, length), np.float32)
            part = self._samples[:, self._sounded : self._sounded + length]
            block[:, : part.shape[1]] = part
            frame = _av().AudioFrame.from_ndarray(block, format="fltp", layout="stereo")
            frame.sample_rate = RATE_HZ
            frame.pts, frame.time_base = self._sounded, Fraction(1, RATE_HZ)
            self._sounded += length
            self._file.mux(self._audio.encode(frame))

    def finish(self) -> None:
        """Write what the encoders still hold."""
        self._file.mux(self._video.encode())
        self._file.mux(self._audio.encode())
