"""A performance as pictures and as a film with its sound.

`render` writes the film, `still` gives one picture. The parts: `canvas` draws the scene through
OpenGL without a window, `overlay` writes the tablature over it, `movie` encodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Literal

import numpy as np

from roboguitarist import sound
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.guitar import preset
from roboguitarist.hands import VARIANTS
from roboguitarist.looks import CAMERAS
from roboguitarist.performance import Performance
from roboguitarist.scene import SceneConfig, build
from roboguitarist.video.canvas import Canvas, View
from roboguitarist.video.errors import UnavailableError
from roboguitarist.video.movie import RATE_HZ, film
from roboguitarist.video.overlay import STRIP_SHARE, Overlay

__all__ = ["LEAD_S", "UnavailableError", "render", "still"]

LEAD_S = 0.5
"""The film begins that long before the piece."""
INSETS = ("left", "right")
Quality = Literal["fast", "high"]


def render(
    performance: Performance,
    path: str | Path,
    camera: str = "front",
    *,
    size: tuple[int, int] = (1280, 720),
    fps: int = 30,
    samples: np.ndarray | None = None,
    quality: Quality = "fast",
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write a performance as an mp4 with sound.

    The film begins `LEAD_S` before the piece, or with the first tick if that is later, and ends
    when hands and sound have come to rest.

    Args:
        performance: What to show.
        path: File to write; it appears when it is complete.
        camera: One of `roboguitarist.looks.CAMERAS`.
        size: Width and height in pixels, even numbers.
        fps: Pictures per second.
        samples: (N, 2) sound at 44.1 kHz from time 0 on; synthesised if not given.
        quality: `high` draws shadows and smooth edges, and takes several times as long.
        progress: Called with the share of the work that is done, from 0 to 1.

    Raises:
        UnavailableError: If a library that this needs is missing; the message says which.
        RoboGuitaristError: If an argument is not one of those above or the file cannot be
            written.
    """
    _check(camera, size)
    if fps < 1:
        raise RoboGuitaristError(f"no video with {fps} pictures per second (give 1 or more)")
    samples = sound.synthesize(performance, RATE_HZ) if samples is None else samples
    times = frame_times(performance, fps, len(samples) / RATE_HZ)
    overlay = Overlay(performance, size, _insets(camera, size))
    main = _over_strip(camera, size)
    with (
        closing(_canvas(performance, size, quality)) as canvas,
        film(path, size, fps, _from(times[0], samples)) as movie,
    ):
        for done, time_s in enumerate(times.tolist(), start=1):
            picture = _picture(performance, canvas, time_s, [main, *overlay.insets])
            movie.add(overlay.draw(picture, time_s))
            if progress:
                progress(done / len(times))


def still(
    performance: Performance,
    time_s: float,
    camera: str = "front",
    *,
    size: tuple[int, int] = (1280, 720),
    quality: Quality = "high",
    overlay: bool = False,
) -> np.ndarray:
    """One picture of a performance.

    Args:
        performance: What to show.
        time_s: When, in seconds from the start of the piece.
        camera: One of `roboguitarist.looks.CAMERAS`.
        size: Width and height in pixels, even numbers.
        quality: As for `render`.
        overlay: Add the tablature and the close-ups, as in the film.

    Returns:
        (height, width, 3) uint8.

    Raises:
        UnavailableError: If a library that this needs is missing; the message says which.
        RoboGuitaristError: If an argument is not one of those above.
    """
    _check(camera, size)
    with closing(_canvas(performance, size, quality)) as canvas:
        if not overlay:
            return _picture(performance, canvas, time_s, [View(camera, (0, 0, *size))])
        over = Overlay(performance, size, _insets(camera, size))
        views = [_over_strip(camera, size), *over.insets]
        return over.draw(_picture(performance, canvas, time_s, views), time_s)


def frame_times(performance: Performance, fps: int, sound_s: float = 0.0) -> np.ndarray:
    """Times of the film's pictures in seconds from the start of the piece."""
    if not performance.time_s.size:
        raise RoboGuitaristError("no video of a performance without ticks")
    start_s = max(float(performance.time_s[0]), -LEAD_S)
    end_s = max(float(performance.time_s[-1]), sound_s)
    return start_s + np.arange(max(1, round((end_s - start_s) * fps))) / fps


def _check(camera: str, size: tuple[int, int]) -> None:
    if camera not in CAMERAS:
        raise RoboGuitaristError(f"no camera {camera!r} (there are {', '.join(CAMERAS)})")
    if min(size) < 2 or max(size) > 8192 or any(length % 2 for length in size):
        width, height = size
        raise RoboGuitaristError(f"no video of {width}x{height} (give even numbers up to 8192)")


def _from(start_s: float, samples: np.ndarray) -> np.ndarray:
    """The sound from `start_s` on."""
    skipped = round(start_s * RATE_HZ)
    silence = np.zeros((max(0, -skipped), 2), np.float32)
    return np.concatenate([silence, samples[max(0, skipped) :]])


def _canvas(performance: Performance, size: tuple[int, int], quality: Quality) -> Canvas:
    if performance.hand not in VARIANTS:
        raise RoboGuitaristError(f"no hand {performance.hand!r} (there are {', '.join(VARIANTS)})")
    model = build(SceneConfig(preset(performance.guitar), performance.hand))
    if performance.qpos.ndim != 2 or performance.qpos.shape[1] != model.nq:
        found = performance.qpos.shape
        raise RoboGuitaristError(f"the performance has joints {found}, the scene {model.nq}")
    return Canvas(model, size, high=quality == "high")


def _over_strip(camera: str, size: tuple[int, int]) -> View:
    """The main view, centred in what the tablature leaves free and a little larger than that."""
    width, height = size
    free, drawn = (1 - STRIP_SHARE) * height, 0.9 * height
    return View(camera, (0, round((free - drawn) / 2 + 0.035 * height), width, round(drawn)))


def _insets(camera: str, size: tuple[int, int]) -> tuple[View, ...]:
    """Close-ups side by side in the upper right corner."""
    width, height = size
    inset, gap = (round(0.236 * width), round(0.236 * height)), round(0.008 * width)
    names = INSETS if camera not in INSETS else ()
    return tuple(
        View(name, (width - (place + 1) * (inset[0] + gap), gap, *inset))
        for place, name in enumerate(names)
    )


def _picture(
    performance: Performance, canvas: Canvas, time_s: float, views: Sequence[View]
) -> np.ndarray:
    place = np.interp(time_s, performance.time_s, np.arange(len(performance.time_s)))
    before = int(place)
    after = min(before + 1, len(performance.time_s) - 1)
    share = place - before
    qpos = (1 - share) * performance.qpos[before] + share * performance.qpos[after]
    return canvas.draw(qpos, views)
