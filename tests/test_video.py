from __future__ import annotations

import os
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from builders import perfect, without_plucks
from roboguitarist import video
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.looks import CAMERAS
from roboguitarist.performance import Performance
from roboguitarist.tablature import Note, Tablature
from roboguitarist.video import canvas, movie
from roboguitarist.video.overlay import _MISSED, _RIGHT, STRIP_SHARE, Overlay
from roboguitarist.video.playback import Playback

SIZE, FPS = (160, 120), 20
NOTES = (Note(0.0, 2, 1, 0.2), Note(0.2, 4, 2, 0.2, beat=2.0))
SHORT = Tablature(NOTES, title="Für zwei", composer="Anonymous")


@pytest.fixture(scope="module")
def performance() -> Performance:
    played = perfect(SHORT, lead_s=0.1)
    qpos = np.zeros((len(played.time_s), 51), np.float32)
    qpos[:, 0] = np.linspace(0.0, 0.1, len(qpos))
    return replace(played, qpos=qpos)


@pytest.fixture(scope="module")
def _opengl() -> None:
    try:
        canvas.open_context(16, 16).free()
    except video.UnavailableError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def _encoder() -> None:
    pytest.importorskip("PIL")
    try:
        movie.video_codec()
    except video.UnavailableError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def film(performance, tmp_path_factory, _opengl, _encoder) -> Path:
    path = tmp_path_factory.mktemp("video") / "short.mp4"
    samples = np.zeros((movie.RATE_HZ, 2), np.float32)
    samples[: movie.RATE_HZ // 50, 0] = 0.8
    video.render(performance, path, size=SIZE, fps=FPS, samples=samples)
    return path


def _decoded(path: Path) -> tuple[np.ndarray, np.ndarray, float]:
    """Pictures, sound (2, n) and length in seconds of a file."""
    import av  # noqa: PLC0415

    with av.open(str(path)) as file:
        stream: Any = file.streams.video[0]
        length_s = float(stream.duration * stream.time_base)
        pictures = np.stack([f.to_ndarray(format="rgb24") for f in file.decode(video=0)])
    with av.open(str(path)) as file:
        frames = [frame for frame in file.decode(audio=0) if (frame.pts or 0) >= 0]
    return pictures, np.concatenate([frame.to_ndarray() for frame in frames], axis=1), length_s


@pytest.mark.slow
def test_a_film_has_its_length_size_and_sound(film, performance):
    pictures, heard, length_s = _decoded(film)
    expected_s = 1.0 - performance.time_s[0]
    assert pictures.shape == (round(expected_s * FPS), SIZE[1], SIZE[0], 3)
    assert length_s == pytest.approx(expected_s, abs=1 / FPS)
    assert heard.shape[0] == 2
    assert heard.shape[1] / movie.RATE_HZ == pytest.approx(expected_s, abs=0.06)


@pytest.mark.slow
def test_sound_comes_with_its_picture(film, performance):
    _, heard, _ = _decoded(film)
    first_s = np.flatnonzero(np.abs(heard[0]) > 0.4)[0] / movie.RATE_HZ
    assert first_s == pytest.approx(-performance.time_s[0], abs=0.005)
    assert np.abs(heard[1]).max() < 0.1


@pytest.mark.slow
def test_pictures_are_not_blank_and_move(film):
    pictures, _, _ = _decoded(film)
    scene = pictures[:, : round((1 - STRIP_SHARE) * SIZE[1])].astype(float)
    assert (scene.std(axis=(1, 2, 3)) > 15).all()
    assert np.abs(scene[-1] - scene[0]).max() > 40


@pytest.mark.usefixtures("_opengl")
@pytest.mark.parametrize("camera", CAMERAS)
def test_a_still_shows_something_from_every_camera(performance, camera):
    picture = video.still(performance, 0.1, camera, size=(128, 72), quality="fast")
    assert picture.shape == (72, 128, 3)
    assert picture.dtype == np.uint8
    assert picture.std() > 15


@pytest.mark.usefixtures("_opengl")
def test_a_still_is_the_same_twice_and_between_ticks(performance):
    one, two, other = (
        video.still(performance, time_s, size=SIZE, quality="fast") for time_s in (0.05, 0.05, 0.3)
    )
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()


@pytest.mark.usefixtures("_opengl")
def test_a_plucked_string_is_seen_to_swing(performance):
    still = without_plucks(performance, np.array([True, True]))
    one, other = (
        video.still(played, 0.05, "right", size=(320, 180), quality="fast").astype(int)
        for played in (performance, still)
    )
    assert 20 < (np.abs(one - other).max(axis=2) > 15).sum() < 2000


@pytest.mark.usefixtures("_opengl")
def test_a_gif_shows_some_seconds_and_goes_round(performance, tmp_path):
    image = pytest.importorskip("PIL.Image")
    path = tmp_path / "a.gif"
    video.write_gif(performance, path, 0.2, size=SIZE, fps=10, length_s=0.5, quality="fast")
    with image.open(path) as gif:
        assert gif.size == SIZE
        assert gif.n_frames == 5
        assert gif.info["loop"] == 0


@pytest.mark.slow
@pytest.mark.usefixtures("_opengl", "_encoder")
def test_a_minute_in_720p_takes_less_than_150_seconds_of_processor_time(performance, tmp_path):
    """Drawing, writing over and encoding, by the quickest of several batches of pictures."""
    size, fps, batch = (1280, 720), 30, 5
    overlay = Overlay(performance, size, video._insets("front", size))
    views = [video._over_strip("front", size), *overlay.insets]
    spent = []
    with (
        closing(Playback(performance, size, high=False)) as playback,
        movie.film(tmp_path / "a.mp4", size, fps, np.zeros((44100, 2), np.float32)) as film,
    ):
        for start in range(4):
            before = os.times()
            for k in range(batch):
                time_s = (start * batch + k) / fps
                film.add(overlay.draw(playback.picture(time_s, views), time_s))
            after = os.times()
            spent.append(after.user + after.system - before.user - before.system)
    assert min(spent) / batch * 60 * fps < 150


def _coloured(picture: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((np.abs(picture.astype(int) - colour).max(axis=2) < 20).sum())


def test_notes_turn_green_when_right_and_red_when_missed(performance):
    pytest.importorskip("PIL")
    size = (640, 360)
    silent = without_plucks(performance, np.array([True, False]))
    blank = np.full((size[1], size[0], 3), 128, np.uint8)
    for played, colours in ((performance, (True, False)), (silent, (False, True))):
        overlay = Overlay(played, size)
        before, during = overlay.draw(blank, -0.05), overlay.draw(blank, 0.1)
        # A finger's small number may have a colour much like them.
        assert max(_coloured(before, _RIGHT), _coloured(before, _MISSED)) < 5
        found = tuple(_coloured(during, colour) > 20 for colour in (_RIGHT, _MISSED))
        assert found == colours
        np.testing.assert_array_equal(during[: 360 - 80], blank[: 360 - 80])
    assert (blank == 128).all()


def test_without_opengl_one_line_says_what_to_install(performance, tmp_path, monkeypatch):
    monkeypatch.setattr(canvas, "_LIBRARY", {"egl": "libNoSuchThing.so"})
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(video.UnavailableError, match="libegl1 and libgl1-mesa-dri") as caught:
        video.render(performance, tmp_path / "a.mp4", size=SIZE)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_broken_driver_is_one_line_too(performance, monkeypatch):
    monkeypatch.setattr(canvas, "backend", lambda: "no_such_backend")
    with pytest.raises(video.UnavailableError, match=r"does not start.*libegl1"):
        video.still(performance, 0.0, size=SIZE)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems draw without a display server")
@pytest.mark.filterwarnings("ignore")
def test_a_window_system_without_a_display_is_one_line_too(performance, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(video.UnavailableError, match="libegl1"):
        video.still(performance, 0.0, size=SIZE)


@pytest.mark.parametrize("module", ["av", "PIL"])
def test_without_the_extra_one_line_says_how_to_get_it(performance, monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(video.UnavailableError, match=r"pip install 'roboguitarist\[video\]'"):
        movie.video_codec() if module == "av" else Overlay(performance, SIZE)


def test_without_an_encoder_one_line_names_them(monkeypatch):
    pytest.importorskip("av")
    monkeypatch.setattr(movie, "CODECS", {"nothing264": {}})
    with pytest.raises(video.UnavailableError, match="nothing264"):
        movie.video_codec()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"camera": "behind"}, "front, left, right, player"),
        ({"size": (161, 120)}, "even numbers"),
        ({"size": (0, 120)}, "even numbers"),
    ],
)
def test_bad_arguments_are_named(performance, arguments, message):
    with pytest.raises(RoboGuitaristError, match=message):
        video.still(performance, 0.0, **arguments)


def test_joints_of_another_hand_are_refused(performance):
    other = replace(performance, qpos=performance.qpos[:, :40])
    with pytest.raises(RoboGuitaristError, match="joints"):
        video.still(other, 0.0, size=SIZE)


@pytest.mark.usefixtures("_opengl", "_encoder")
def test_an_error_leaves_no_file(performance, tmp_path, monkeypatch):
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(movie.Movie, "add", fail)
    samples = np.zeros((100, 2), np.float32)
    with pytest.raises(RoboGuitaristError, match="No space left"):
        video.render(performance, tmp_path / "a.mp4", size=SIZE, samples=samples)
    assert not list(tmp_path.iterdir())
