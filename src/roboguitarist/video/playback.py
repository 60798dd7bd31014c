"""Pictures of a performance at any time: hands, guitar and the strings that swing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from roboguitarist import replay
from roboguitarist.guitar import Guitar, preset
from roboguitarist.looks.strings import FIRST_WOUND, RADII_M
from roboguitarist.performance import Performance
from roboguitarist.ringing import Ring, rings
from roboguitarist.video.canvas import Blur, Canvas, View

_NYLON_RGBA, _WOUND_RGBA = (0.97, 0.96, 0.92, 0.5), (0.86, 0.79, 0.62, 0.5)
LEAST_M = 1e-4
"""Swings narrower than this are not seen."""


class Playback:
    """Draws a performance, until it is closed.

    Args:
        performance: What to show.
        size: Width and height of the pictures in pixels.
        high: With shadows and smooth edges.

    Raises:
        UnavailableError: If this machine cannot draw.
        RoboGuitaristError: If the performance does not fit its scene.
    """

    def __init__(self, performance: Performance, size: tuple[int, int], high: bool) -> None:
        self._performance, self._guitar = performance, preset(performance.guitar)
        self._rings = rings(performance)
        self._canvas = Canvas(replay.scene(performance), size, high)

    def picture(self, time_s: float, views: Sequence[View]) -> np.ndarray:
        """A picture (height, width, 3) uint8 at a time in seconds; later views cover earlier."""
        posture = replay.postures(self._performance, np.array([time_s]))[0]
        widths = ((ring, ring.width_at(time_s)) for ring in self._rings)
        blurs = [_blur(self._guitar, ring, width) for ring, width in widths if width > LEAST_M]
        return self._canvas.draw(posture, views, blurs)

    def close(self) -> None:
        """Give the graphics memory back."""
        self._canvas.close()


def _blur(guitar: Guitar, ring: Ring, width_m: float) -> Blur:
    """What the eye sees of a string that swings faster than it can follow: its envelope."""
    x = np.array([guitar.fret_x(ring.fret), guitar.scale_length_m])
    start, end = np.column_stack([x, guitar.string_y(ring.string, x), np.zeros(2)])
    along = (end - start) / np.linalg.norm(end - start)
    turn = np.column_stack([along, np.cross([0.0, 0.0, 1.0], along), [0.0, 0.0, 1.0]])
    radius = RADII_M[ring.string - 1]
    half = (0.5 * float(np.linalg.norm(end - start)), width_m + radius, 0.7 * radius)
    rgba = _WOUND_RGBA if ring.string >= FIRST_WOUND else _NYLON_RGBA
    return Blur((start + end) / 2, half, turn, rgba)
