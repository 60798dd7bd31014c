"""The tablature over the picture: a strip that scrolls with the music, and frames of close-ups."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import groupby
from typing import Any

import numpy as np

from roboguitarist.alignment import misses
from roboguitarist.looks.materials import FINGER_RGB
from roboguitarist.performance import Performance
from roboguitarist.tablature import Note
from roboguitarist.video.canvas import View
from roboguitarist.video.errors import UnavailableError

Colour = tuple[int, int, int]

STRIP_SHARE = 0.2
"""Height of the strip in heights of the picture."""
SECONDS_SHOWN = 8.0
NOW_SHARE = 0.25
"""Where the present is, in widths of the picture."""
LEFT_FINGERS = ("FF", "MF", "RF", "LF")
RIGHT_FINGERS = ("TH", "FF", "MF", "RF")
_PAPER, _LINE, _BAR = (24, 26, 30), (92, 96, 104), (58, 61, 68)
_TEXT, _FAINT, _INK = (235, 235, 232), (150, 153, 160), (18, 19, 22)
_COMING, _RIGHT, _MISSED = (206, 208, 212), (96, 205, 120), (240, 92, 84)
_CAPTIONS = {"left": "fretting", "right": "plucking"}
_SMOOTH = 4


class Overlay:
    """Draws over the pictures of one performance.

    Args:
        performance: Whose notes to show; right ones turn green as they come, missed ones red.
        size: Width and height of the pictures in pixels.
        insets: Close-ups in the pictures, which get a frame each.

    Raises:
        UnavailableError: If Pillow is not installed.
    """

    def __init__(
        self, performance: Performance, size: tuple[int, int], insets: Sequence[View] = ()
    ) -> None:
        self._image, self._drawing, self._font = _pillow()
        self._tablature = performance.tablature
        self._left, self._right = performance.left.tolist(), performance.right.tolist()
        self._missed = {miss.index for miss in misses(performance)}
        self._size, self.insets = size, tuple(insets)
        self._strip_px = round(STRIP_SHARE * size[1])
        self._row_px = 0.105 * self._strip_px
        self._per_second = size[0] / SECONDS_SHOWN
        self._ends = np.array([note.end_s for note in self._tablature.notes])
        self._onsets = np.array([note.onset_s for note in self._tablature.notes])

    def draw(self, picture: np.ndarray, time_s: float) -> np.ndarray:
        """The picture (height, width, 3) with the tablature as it stands at `time_s`."""
        width, height = self._size
        strip = self._image.new("RGB", (width, self._strip_px), _PAPER)
        draw = self._drawing.Draw(strip)
        self._draw_lines(draw, time_s)
        shown = self._shown(time_s)
        self._draw_tails(draw, shown, time_s)
        self._draw_heads(strip, draw, shown, time_s)
        self._draw_plucking(draw, shown, time_s)
        self._draw_header(draw)
        out = picture.copy()
        out[height - self._strip_px :] = np.asarray(strip)
        for view in self.insets:
            self._draw_frame(out, view)
        return out

    def _x(self, at_s: float, time_s: float) -> float:
        return NOW_SHARE * self._size[0] + (at_s - time_s) * self._per_second

    def _y(self, string: int) -> float:
        return 0.28 * self._strip_px + (string - 1) * self._row_px

    def _text(self, share: float) -> Any:
        return self._font(max(6, round(share * self._strip_px)))

    def _shown(self, time_s: float) -> list[tuple[int, Note]]:
        first = time_s - NOW_SHARE * SECONDS_SHOWN - 1.0
        last = time_s + (1 - NOW_SHARE) * SECONDS_SHOWN + 1.0
        indices = np.flatnonzero((self._ends >= first) & (self._onsets <= last)).tolist()
        return [(index, self._tablature.notes[index]) for index in indices]

    def _colour(self, index: int, note: Note, time_s: float) -> Colour:
        """Colour of a note: grey before its time, then what became of it, fading afterwards."""
        if time_s < note.onset_s:
            return _COMING
        colour = _MISSED if index in self._missed else _RIGHT
        return colour if time_s < note.end_s else _mixed(colour, _PAPER, 0.35)

    def _draw_lines(self, draw: Any, time_s: float) -> None:
        width = self._size[0]
        top, bottom = self._y(1), self._y(6)
        for bar in self._tablature.bars:
            x = self._x(bar.onset_s, time_s) - 0.9 * self._row_px
            if 0 <= x <= width:
                draw.line([x, top, x, bottom], _BAR, 1)
                place = (x + 2, top - 0.5 * self._row_px)
                draw.text(place, str(bar.number), _FAINT, self._text(0.075), anchor="ls")
        for string in range(1, 7):
            draw.line([0, self._y(string), width, self._y(string)], _LINE, 1)
        now = NOW_SHARE * width
        ends = [now, top - 0.6 * self._row_px, now, bottom + 0.6 * self._row_px]
        draw.line(ends, _TEXT, max(1, self._strip_px // 70))

    def _draw_tails(self, draw: Any, shown: list[tuple[int, Note]], time_s: float) -> None:
        """A bar along the string for as long as each note is written."""
        half = 0.16 * self._row_px
        for index, note in shown:
            colour = _mixed(self._colour(index, note, time_s), _PAPER, 0.5)
            start, y = self._x(note.onset_s, time_s), self._y(note.string)
            end = max(start, self._x(note.end_s, time_s) - 0.7 * self._row_px)
            draw.rectangle([start, y - half, end, y + half], colour)

    def _draw_heads(
        self, strip: Any, draw: Any, shown: list[tuple[int, Note]], time_s: float
    ) -> None:
        """Each note's fret with the finger that stops it in that finger's colour."""
        for index, note in shown:
            sounding = note.onset_s <= time_s < note.end_s
            height = round((1.18 if sounding else 0.98) * self._row_px)
            head = _head(str(note.fret), self._colour(index, note, time_s), max(3, height))
            x, y = self._x(note.onset_s, time_s), self._y(note.string)
            strip.paste(head, (round(x - head.width / 2), round(y - head.height / 2)), head)
            finger = self._left[index]
            if finger > 0:
                place = (x + 0.62 * head.width, y - 0.1 * self._row_px)
                colour = _finger_colour(LEFT_FINGERS[finger - 1])
                draw.text(place, str(finger), colour, self._text(0.088), anchor="ls")

    def _draw_plucking(self, draw: Any, shown: list[tuple[int, Note]], time_s: float) -> None:
        """The right hand's fingers under each onset, the thumb last."""
        y = self._y(6) + 0.75 * self._row_px
        for onset_s, fingers in self._plucking(shown):
            for place, finger in enumerate(fingers):
                x = (
                    self._x(onset_s, time_s)
                    + (place - (len(fingers) - 1) / 2) * 0.62 * self._row_px
                )
                colour = _finger_colour(RIGHT_FINGERS[finger])
                draw.text((x, y), "pima"[finger], colour, self._text(0.095), anchor="ma")

    def _plucking(self, shown: list[tuple[int, Note]]) -> Iterator[tuple[float, list[int]]]:
        for onset_s, together in groupby(shown, key=lambda item: item[1].onset_s):
            yield onset_s, sorted({self._right[index] for index, _ in together}, reverse=True)

    def _draw_header(self, draw: Any) -> None:
        margin, y = 0.1 * self._strip_px, 0.045 * self._strip_px
        name = " · ".join(filter(None, (self._tablature.title, self._tablature.composer)))
        font = self._text(0.095)
        draw.text((margin, y), _written(name, font), _TEXT, font, anchor="la")
        right = self._size[0] - margin
        count = len(self._tablature.notes)
        score = f"{count - len(self._missed)} of {count} notes right"
        draw.text((right, y), score, _FAINT, font, anchor="ra")

    def _draw_frame(self, picture: np.ndarray, view: View) -> None:
        left, top, width, height = view.rect
        edge = max(1, self._size[1] // 360)
        part = picture[top : top + height, left : left + width]
        for side in (part[:edge], part[-edge:], part[:, :edge], part[:, -edge:]):
            side[:] = _PAPER
        caption = self._image.fromarray(part)
        place = (2.5 * edge + 2, height - 2.5 * edge - 1)
        text = _CAPTIONS[view.camera]
        self._drawing.Draw(caption).text(place, text, _INK, self._text(0.1), anchor="ls")
        part[:] = np.asarray(caption)


def _pillow() -> tuple[Any, Any, Any]:
    try:
        from PIL import Image, ImageDraw  # noqa: PLC0415
    except ImportError as error:
        raise UnavailableError(f"{error}; pip install 'roboguitarist[video]'") from error
    return Image, ImageDraw, _font


def image(picture: np.ndarray) -> Any:
    """A picture (height, width, 3) uint8 as an image of Pillow's.

    Raises:
        UnavailableError: If Pillow is not installed.
    """
    return _pillow()[0].fromarray(picture)


@lru_cache
def _font(size: int) -> Any:
    """A font with accented letters if the machine has one, else Pillow's own."""
    from PIL import ImageFont  # noqa: PLC0415

    for name in ("DejaVuSans.ttf", "LiberationSans-Regular.ttf", "Arial.ttf"):
        try:
            return ImageFont.truetype(name, size)
        except OSError:
            continue
    return ImageFont.load_default(size)


def _written(text: str, font: Any) -> str:
    """The text, with plain letters where a font that lacks accents would leave boxes."""
    if font.getname()[0].startswith(("DejaVu", "Liberation", "Arial")):
        return text
    letters = unicodedata.normalize("NFKD", text)
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def _mixed(colour: Colour, other: Colour, share: float) -> Colour:
    red, green, blue = (
        round((1 - share) * a + share * b) for a, b in zip(colour, other, strict=True)
    )
    return red, green, blue


def _finger_colour(finger: str) -> Colour:
    red, green, blue = (round(255 * value) for value in FINGER_RGB[finger])
    return red, green, blue


@lru_cache(maxsize=256)
def _head(text: str, colour: Colour, height: int) -> Any:
    """A rounded label with smooth edges."""
    image, drawing, font = _pillow()
    big = _SMOOTH * height
    width = big if len(text) == 1 else round(1.45 * big)
    mask = image.new("L", (width, big), 0)
    drawing.Draw(mask).rounded_rectangle([0, 0, width - 1, big - 1], 0.42 * big, 255)
    label = image.new("RGB", (width, big), colour)
    middle = (width / 2, big / 2)
    drawing.Draw(label).text(middle, text, _INK, font(round(0.8 * big)), anchor="mm")
    label.putalpha(mask)
    return label.resize((width // _SMOOTH, height), image.Resampling.LANCZOS)
