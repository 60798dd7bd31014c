"""What the commands do: from a score to its performance and the files that come of it."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from roboguitarist import cli_report, formats, pieces, storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.tablature import Tablature

if TYPE_CHECKING:
    import numpy as np

    from roboguitarist.alignment import Miss
    from roboguitarist.cli import Convert, Evaluate, Export, Finger, Options, Play, Reading
    from roboguitarist.metrics import Metrics
    from roboguitarist.performance import Performance


@dataclass(frozen=True)
class Playing:
    """One score as it was played.

    Attributes:
        name: The score's name without folder and suffix.
        performance: What the physics did.
        metrics: How good it was.
        misses: The notes that were not right.
    """

    name: str
    performance: Performance
    metrics: Metrics
    misses: tuple[Miss, ...]

    def row(self) -> tuple[str, ...]:
        """The row in the table of metrics."""
        return cli_report.metrics_row(self.name, self.metrics, self.misses)

    def as_dict(self) -> dict[str, Any]:
        """The JSON object of the command line."""
        return {
            "name": self.name,
            "controller": self.performance.controller,
            "hand": self.performance.hand,
            "seed": self.performance.seed,
            "metrics": self.metrics.as_dict(),
            "misses": dict(Counter(miss.cause.value for miss in self.misses)),
        }


def play(command: Play) -> None:
    """Write a score's recording, sound, metrics, web page and video, and print the metrics.

    Raises:
        RoboGuitaristError: If the score cannot be used or the files cannot be written.
    """
    name, tablature = read_asked(command.score, command, command.speed)
    paths = output_paths(command.out, name, command.score)
    seconds: dict[str, float] = {}
    performance = perform(name, tablature, command, seconds)

    from roboguitarist import sound, viewer  # noqa: PLC0415

    start = time.perf_counter()
    samples = sound.synthesize(performance)
    seconds["sound"] = time.perf_counter() - start
    playing = assess(name, performance, seconds)
    performance.save(paths["npz"])
    sound.write_wav(paths["wav"], samples)
    write_json(paths["json"], playing.as_dict())
    viewer.write_page(performance, paths["html"], samples)
    print(cli_report.metrics_table([playing.row()]))
    for line in cli_report.shortened(map(str, playing.misses)):
        print(line)
    if command.no_video or not film(paths["mp4"], performance, command, samples):
        del paths["mp4"]
    print("Written:", ", ".join(map(str, paths.values())))


def evaluate(command: Evaluate) -> None:
    """Play scores one after the other and print their metrics.

    Raises:
        RoboGuitaristError: If a score cannot be used or the file cannot be written.
    """
    if not command.scores:
        raise RoboGuitaristError("no score (name a file or a piece, such as twinkle)")
    if command.json:
        check_folder(command.json.parent)
    tablatures = [read_asked(score, command, command.speed) for score in command.scores]
    playings = []
    for name, tablature in tablatures:
        seconds: dict[str, float] = {}
        performance = perform(name, tablature, command, seconds)
        playings.append(assess(name, performance, seconds))
    print(cli_report.metrics_table([playing.row() for playing in playings]))
    if command.json:
        write_json(command.json, [playing.as_dict() for playing in playings])


def finger(command: Finger) -> None:
    """Print a score's tablature with the fingers of both hands.

    Raises:
        RoboGuitaristError: If the score cannot be used or the file cannot be written.
    """
    from roboguitarist import engraving, fingering  # noqa: PLC0415

    _, tablature = read_asked(command.score, command)
    found = fingering.assign(
        tablature, method=command.method, hand=command.hand, objective=command.objective
    )
    if command.out:
        formats.save(command.out, found.marked())
    width = shutil.get_terminal_size().columns
    print(engraving.render(found, width), end="")


def convert(command: Convert) -> None:
    """Write a score, or what was heard of a recording, in another format.

    Raises:
        RoboGuitaristError: If it cannot be read or written.
    """
    if Path(command.score).suffix == ".npz":
        load_mujoco()
        from roboguitarist import transcription  # noqa: PLC0415
        from roboguitarist.performance import Performance  # noqa: PLC0415

        tablature = transcription.heard(Performance.load(command.score))
    else:
        _, tablature = read_asked(command.score, command)
    if command.output.exists() and Path(command.score).exists():
        if command.output.samefile(command.score):
            raise RoboGuitaristError(f"{command.output} would replace the score")
    formats.save(command.output, tablature)
    print("Written:", command.output)


def read_asked(score: str, reading: Reading, speed: float = 1.0) -> tuple[str, Tablature]:
    """Name and tablature of a score, read as the command says."""
    return read(score, reading.track, speed, tempo=reading.tempo, grid=reading.grid)


def read(
    score: str,
    track: str | None = None,
    speed: float = 1.0,
    *,
    tempo: float | None = None,
    grid: int | None = None,
) -> tuple[str, Tablature]:
    """Name and tablature of a score file or a piece of the repertoire.

    What was read otherwise than written is said on stderr.

    Raises:
        RoboGuitaristError: If there is no such score, or it cannot be used.
    """
    path = Path(score)
    is_name = score in pieces.names() or not (path.suffix or path.parent.name or path.exists())
    path = pieces.path(score) if is_name else path
    tablature = formats.load(path, track, tempo=tempo, grid=grid)
    tablature = tablature.at_speed(speed)
    complain(path.stem, tablature.warnings)
    return path.stem, tablature


def complain(name: str, lines: Iterable[str]) -> None:
    """Say on stderr what is not as the score asks."""
    for line in cli_report.shortened(lines):
        print(f"roboguitarist: {name}: {line}", file=sys.stderr)


def perform(
    name: str, tablature: Tablature, options: Options, seconds: dict[str, float]
) -> Performance:
    """Play a tablature; the wall time that this took is added to `seconds`."""
    load_mujoco()
    from roboguitarist import fingering, performance  # noqa: PLC0415
    from roboguitarist.fretting.policy import Policy  # noqa: PLC0415

    policy = Policy.load(options.policy) if options.policy else None
    hand = options.hand or (policy.hand if policy else "linkage")
    config = performance.PerformConfig(
        hand=hand,  # pyright: ignore[reportArgumentType] - performing checks the name
        controller="policy" if policy else options.controller,
        policy=policy,
        seed=options.seed,
    )
    start = time.perf_counter()
    fingered = fingering.assign(tablature)
    complain(name, [*cli_report.simplified(tablature), *fingered.problems])
    with progress_bar(name) as progress:
        played = performance.perform(fingered, config, progress)
    seconds["performance"] = time.perf_counter() - start
    return played


def load_mujoco() -> None:
    """Import MuJoCo without a renderer: if `MUJOCO_GL` names one that is missing, that fails.

    The video looks for a renderer itself, and obeys the same variable.
    """
    chosen = os.environ.pop("MUJOCO_GL", None)
    import mujoco  # noqa: F401, PLC0415

    if chosen is not None:
        os.environ["MUJOCO_GL"] = chosen


@contextmanager
def progress_bar(name: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr, if that is a terminal, and what to call with the share that is done."""
    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=100, desc=name, bar_format=layout, disable=None, leave=False) as bar:

        def show(share: float) -> None:
            bar.update(round(100 * share) - bar.n)

        yield show


def assess(
    name: str, performance: Performance, seconds: Mapping[str, float] | None = None
) -> Playing:
    """Metrics and misses of a performance.

    Args:
        name: The score's name.
        performance: What was done.
        seconds: Wall time that each stage took, if measured.
    """
    from roboguitarist import alignment, metrics  # noqa: PLC0415

    length_s = performance.tablature.duration_s
    speed = {stage: length_s / elapsed for stage, elapsed in (seconds or {}).items()}
    measured = metrics.evaluate(performance, speed=speed or None)
    return Playing(name, performance, measured, alignment.misses(performance))


def film(
    path: Path, performance: Performance, options: Play | Export, samples: np.ndarray | None = None
) -> bool:
    """Make the video; on a machine that cannot, say what is missing and go on.

    Returns:
        Whether it was made.

    Raises:
        RoboGuitaristError: If the file cannot be written.
    """
    from roboguitarist import video  # noqa: PLC0415

    try:
        with progress_bar(path.name) as progress:
            video.render(
                performance,
                path,
                options.camera,
                quality=options.quality,
                samples=samples,
                progress=progress,
            )
    except video.UnavailableError as error:
        print(f"roboguitarist: no video: {error}", file=sys.stderr)
        return False
    return True


def output_paths(folder: Path, name: str, score: str) -> dict[str, Path]:
    """Where the outputs of `play` go, by suffix; checked before long work begins.

    Raises:
        RoboGuitaristError: If the folder cannot be written, or an output would replace the score.
    """
    check_folder(folder)
    paths = {
        suffix: folder / f"{name}.{suffix}" for suffix in ("npz", "wav", "json", "html", "mp4")
    }
    for path in paths.values():
        if path.exists() and Path(score).exists() and path.samefile(score):
            raise RoboGuitaristError(f"{path} would replace the score (choose another --out)")
    return paths


def check_folder(folder: Path) -> None:
    """Make sure that a folder is there and can be written to, before long work begins.

    Raises:
        RoboGuitaristError: If not.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise RoboGuitaristError(
            f"cannot write to folder {folder}: {error.strerror or error}"
        ) from error


def write_json(path: Path, item: Any) -> None:
    """Write an object as JSON; the file appears when it is complete.

    Raises:
        RoboGuitaristError: If it cannot be written.
    """
    text = json.dumps(item, ensure_ascii=False, indent=1, allow_nan=False)
    with storage.replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
