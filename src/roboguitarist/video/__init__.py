"""A performance as pictures and as a film with its sound.

`render` writes the film, `still` gives one picture. The parts: `canvas` draws the scene through
OpenGL without a window, `overlay` writes the tablature over it, `movie` encodes.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Literal

import numpy as np

from roboguitarist import replay, sound, storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.looks import CAMERAS
from roboguitarist.performance import Performance
from roboguitarist.replay import LEAD_S, frame_times
from roboguitarist.video.canvas import View
from roboguitarist.video.errors import UnavailableError
from roboguitarist.video.movie import RATE_HZ, film
from roboguitarist.video.overlay import STRIP_SHARE, Overlay, image
from roboguitarist.video.playback import Playback

__all__ = ["LEAD_S", "UnavailableError", "render", "still", "write_gif", "write_still"]

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
        closing(Playback(performance, size, quality == "high")) as playback,
        film(path, size, fps, replay.sound_from(times[0], samples, RATE_HZ)) as movie,
    ):
        for done, time_s in enumerate(times.tolist(), start=1):
            picture = playback.picture(time_s, [main, *overlay.insets])
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
    with closing(Playback(performance, size, quality == "high")) as playback:
        if not overlay:
            return playback.picture(time_s, [View(camera, (0, 0, *size))])
        over = Overlay(performance, size, _insets(camera, size))
        views = [_over_strip(camera, size), *over.insets]
        return over.draw(playback.picture(time_s, views), time_s)


def write_still(
    performance: Performance,
    path: str | Path,
    time_s: float,
    camera: str = "front",
    *,
    size: tuple[int, int] = (1280, 720),
    quality: Quality = "high",
    overlay: bool = False,
) -> None:
    """Write one picture as PNG; arguments and errors as for `still`."""
    picture = still(performance, time_s, camera, size=size, quality=quality, overlay=overlay)
    with storage.replacing(path) as temporary:
        image(picture).save(temporary, "PNG")


def write_gif(
    performance: Performance,
    path: str | Path,
    time_s: float,
    camera: str = "front",
    *,
    size: tuple[int, int] = (640, 360),
    fps: int = 15,
    length_s: float = 4.0,
    quality: Quality = "high",
) -> None:
    """Write some seconds as an animated GIF without sound.

    Args:
        performance: What to show.
        path: File to write; it appears when it is complete.
        time_s: The middle of what is shown, in seconds from the start of the piece.
        camera: One of `roboguitarist.looks.CAMERAS`.
        size: Width and height in pixels, even numbers.
        fps: Pictures per second.
        length_s: How long it lasts.
        quality: As for `render`.

    Raises:
        UnavailableError: If a library that this needs is missing; the message says which.
        RoboGuitaristError: If an argument is not one of those above or the file cannot be
            written.
    """
    _check(camera, size)
    times = time_s + np.arange(-length_s / 2, length_s / 2, 1 / fps)
    drawn = (2 * size[0], 2 * size[1])  # and halved: small pictures need smooth edges
    overlay = Overlay(performance, drawn, _insets(camera, drawn))
    views = [_over_strip(camera, drawn), *overlay.insets]
    with closing(Playback(performance, drawn, quality == "high")) as playback:
        first, *others = (
            image(overlay.draw(playback.picture(at_s, views), at_s)).reduce(2)
            for at_s in times.tolist()
        )
    with storage.replacing(path) as temporary:
        first.save(
            temporary, "GIF", save_all=True, append_images=others, duration=1000 // fps, loop=0
        )


def _check(camera: str, size: tuple[int, int]) -> None:
    if camera not in CAMERAS:
        raise RoboGuitaristError(f"no camera {camera!r} (there are {', '.join(CAMERAS)})")
    if min(size) < 2 or max(size) > 8192 or any(length % 2 for length in size):
        width, height = size
        raise RoboGuitaristError(f"no video of {width}x{height} (give even numbers up to 8192)")


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
