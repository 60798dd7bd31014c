"""What the commands for recorded performances do: pages, and files for other programs."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from roboguitarist import cli_play
from roboguitarist.errors import RoboGuitaristError

if TYPE_CHECKING:
    from roboguitarist.cli import Export, View
    from roboguitarist.performance import Performance


def view(command: View) -> None:
    """Make a recording's web page and open it, or show it live.

    Raises:
        RoboGuitaristError: If the recording cannot be used or the page cannot be written.
    """
    performance = load(command.recording)
    from roboguitarist import live, viewer  # noqa: PLC0415

    if command.live:
        return live.show(performance)

    path = command.out or command.recording.with_suffix(".html")
    viewer.write_page(performance, path)
    print("Written:", path)
    # Without a screen a browser for the terminal would take it over.
    if not command.no_open and live.has_screen():
        webbrowser.open(path.resolve().as_uri())


def export(command: Export) -> None:
    """Write a recording as the files that were asked for.

    Raises:
        RoboGuitaristError: If the recording cannot be used, a suffix is not known or a file
            cannot be written.
    """
    if not command.out:
        raise RoboGuitaristError("no file to write (name one, such as performance.glb)")
    for path in command.out:
        if path.suffix.lower() not in WRITERS:
            raise RoboGuitaristError(f"{path}: no such export (there are {', '.join(WRITERS)})")
        cli_play.check_folder(path.parent)
        if path.exists() and path.samefile(command.recording):
            raise RoboGuitaristError(f"{path} would replace the recording")
    performance = load(command.recording)
    for path in command.out:
        WRITERS[path.suffix.lower()](performance, path, command)
    print("Written:", ", ".join(map(str, command.out)))


def load(path: Path) -> Performance:
    """The performance in a file.

    Raises:
        RoboGuitaristError: If it is none.
    """
    cli_play.load_mujoco()
    from roboguitarist.performance import Performance  # noqa: PLC0415

    return Performance.load(path)


def _scene(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist import export  # noqa: PLC0415

    export.write_glb(performance, path)


def _midi(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist import export  # noqa: PLC0415

    export.write_midi(performance, path)


def _joints(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist import export  # noqa: PLC0415

    export.write_joints(performance, path)


def _usd(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist.export import usd  # noqa: PLC0415

    with cli_play.progress_bar(path.name) as progress:
        usd.write_usd(performance, path, progress)


def _page(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist import viewer  # noqa: PLC0415

    viewer.write_page(performance, path)


def _sound(performance: Performance, path: Path, _: Export) -> None:
    from roboguitarist import sound  # noqa: PLC0415

    sound.write_wav(path, sound.synthesize(performance))


def _video(performance: Performance, path: Path, command: Export) -> None:
    from roboguitarist import video  # noqa: PLC0415

    with cli_play.progress_bar(path.name) as progress:
        video.render(performance, path, command.camera, quality=command.quality, progress=progress)


def _picture(performance: Performance, path: Path, command: Export) -> None:
    from roboguitarist import video  # noqa: PLC0415

    video.write_still(
        performance, path, command.at, command.camera, quality=command.quality, overlay=True
    )


def _moving_picture(performance: Performance, path: Path, command: Export) -> None:
    from roboguitarist import video  # noqa: PLC0415

    video.write_gif(performance, path, command.at, command.camera, quality=command.quality)


WRITERS: Mapping[str, Callable[[Performance, Path, Export], None]] = {
    ".glb": _scene,
    ".mid": _midi,
    ".csv": _joints,
    ".usdz": _usd,
    ".html": _page,
    ".wav": _sound,
    ".mp4": _video,
    ".png": _picture,
    ".gif": _moving_picture,
}
