"""The command line `roboguitarist`.

Heavy modules are imported inside the commands, so that help and complaints come at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass
from io import StringIO, TextIOWrapper
from itertools import dropwhile, takewhile
from pathlib import Path
from typing import Annotated, Literal

import tyro

from roboguitarist import __version__
from roboguitarist.errors import RoboGuitaristError

PROG = "roboguitarist"
Score = Annotated[str, tyro.conf.arg(metavar="SCORE"), tyro.conf.Positional]
Hand = Annotated[Literal["linkage", "tendon"] | None, tyro.conf.arg(metavar="{linkage,tendon}")]
Recording = Annotated[Path, tyro.conf.arg(metavar="FILE.npz"), tyro.conf.Positional]
Camera = Literal["front", "left", "right", "player"]
Quality = Literal["fast", "high"]
Track = Annotated[str | None, tyro.conf.arg(metavar="N")]
Tempo = Annotated[float | None, tyro.conf.arg(metavar="BPM")]
Grid = Annotated[int | None, tyro.conf.arg(metavar="N")]
UNUSABLE, INTERRUPTED, BROKEN_PIPE = 2, 130, 141
"""Exit statuses; the last two are what a shell reports for the signals."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How a score is read.

    Attributes:
        track: Part of the score, by number from 1 or by name; by default the first guitar.
        tempo: Quarter notes a minute of an ASCII tab; by default as the tab says, else 120.
        grid: A column of an ASCII tab is 1/N of a whole note; by default 16.
    """

    track: Track = None
    tempo: Tempo = None
    grid: Grid = None


@dataclass(frozen=True, kw_only=True)
class Options(Reading):
    """How a score is played.

    Attributes:
        controller: What drives the left hand: the planner alone, or corrected by a policy.
        policy: Policy file that drives the left hand, as `train` writes it.
        hand: Hand variant: fingers with coupled joints, or tendons as on the published hand; by
            default the policy file's, or linkage.
        speed: Factor of the tempo.
        seed: Seed of everything random.
    """

    controller: Literal["policy", "planner"] = "planner"
    policy: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    hand: Hand = None
    speed: float = 1.0
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Play(Options):
    """Play a score: write its video, web page, sound, recording and metrics.

    NAME is the score's name without suffix; the files are NAME.mp4, NAME.html, NAME.wav, NAME.npz
    and NAME.json.

    Attributes:
        score: Score file, or name of a piece of the repertoire.
        out: Folder to write to.
        no_video: Leave out the video.
        camera: Where the video is seen from.
        quality: `high` draws shadows and smooth edges, and takes several times as long.
    """

    score: Score
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out")
    no_video: bool = False
    camera: Camera = "front"
    quality: Quality = "fast"

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_play  # noqa: PLC0415

        cli_play.play(self)


@dataclass(frozen=True, kw_only=True)
class Evaluate(Options):
    """Play scores without sound and video, and print the metrics.

    Attributes:
        scores: Score files, or names of pieces of the repertoire.
        json: Write the metrics to this file, too.
    """

    scores: Annotated[tuple[Score, ...], tyro.conf.arg(metavar="SCORE..."), tyro.conf.Positional]
    json: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_play  # noqa: PLC0415

        cli_play.evaluate(self)


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train a policy for the left hand: on one score or a few, or for all, on exercises.

    On scores, what is not said here is as in the paper. Begin with `roboguitarist train twinkle`,
    which takes about an hour on two cores. `roboguitarist train --exercises 800` trains one policy
    for every tablature: it corrects the planner, and practises what the generator makes.

    Attributes:
        scores: Score files, or names of pieces of the repertoire.
        exercises: Number of generated exercises to practise instead of scores.
        algorithm: Learner: batch-ppo is this project's own, branching too, which corrects the
            planner; the others are those of sbx, droq the paper's; batch-ppo on scores and
            branching on exercises if none is named.
        resume: Go on with the run in the folder, with the settings that it was begun with.
        out: Folder of the run; runs/SCORE-ALGORITHM if none is named.
        steps: Control ticks to learn from, over all hands.
        seed: Seed of everything random.
        n_envs: Hands that practise at the same time.
        hand: Hand variant; the paper's is tendon, and so it is here.
        control_hz: Frame rate.
        mapping: Function that turns distances into rewards.
        freedom: Frets below a wanted one may be held too.
        euclidean: The plain distance as finger reward.
        track: Part of the score, by number from 1 or by name; by default the first guitar.
    """

    scores: Annotated[
        tuple[Score, ...], tyro.conf.arg(metavar="SCORE..."), tyro.conf.Positional
    ] = ()
    algorithm: Literal["batch-ppo", "branching", "droq", "sac", "crossq", "tqc", "ppo"] | None = (
        None
    )
    exercises: int | None = None
    resume: bool = False
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    steps: int | None = None
    seed: int | None = None
    n_envs: int | None = None
    hand: Hand = None
    control_hz: float | None = None
    mapping: Literal["reciprocal", "gaussian"] | None = None
    freedom: bool = False
    euclidean: bool = False
    track: Track = None

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_train  # noqa: PLC0415

        cli_train.train(self)


@dataclass(frozen=True, kw_only=True)
class Finger(Reading):
    """Print the tablature of a score with the fingers of both hands.

    Attributes:
        score: Score file, or name of a piece of the repertoire.
        method: Search of the whole piece, or the paper's greedy rule.
        hand: Whose fingers count: the simulated hand's or a guitarist's.
        objective: Make the sum of all steps easy, or the hardest moment first.
        out: Write the score with these fingers to this file, too (.musicxml or .json).
    """

    score: Score
    method: Literal["search", "paper"] = "search"
    hand: Literal["robot", "human"] = "robot"
    objective: Literal["sum", "hardest"] = "sum"
    out: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_play  # noqa: PLC0415

        cli_play.finger(self)


@dataclass(frozen=True, kw_only=True)
class Convert(Reading):
    """Write a score in another format: MusicXML, MIDI, ASCII tab or JSON.

    Attributes:
        score: Score file, name of a piece of the repertoire, or a recording (.npz), of which
            what was heard is written.
        output: File to write; its suffix says how: .musicxml, .mid, .txt or .json.
    """

    score: Score
    output: Annotated[Path, tyro.conf.arg(metavar="FILE"), tyro.conf.Positional]

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_play  # noqa: PLC0415

        cli_play.convert(self)


@dataclass(frozen=True, kw_only=True)
class View:
    """Make the web page of a recorded performance and show it in the browser.

    Attributes:
        recording: The `.npz` file of a performance, as `play` writes it.
        out: The page; by default it stands beside the recording.
        no_open: Only make the page.
        live: Show the performance in MuJoCo's own viewer instead.
    """

    recording: Recording
    out: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    no_open: bool = False
    live: bool = False

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_export  # noqa: PLC0415

        cli_export.view(self)


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write a recorded performance for other programs.

    Attributes:
        recording: The `.npz` file of a performance, as `play` writes it.
        out: Files to write; the suffix says what: glb, mid, csv, usdz, html, wav, mp4, gif or png.
        at: Time of a png in seconds from the start of the piece, and of the middle of a gif.
        camera: Where a video or a picture is seen from.
        quality: Of a video or a picture.
    """

    recording: Recording
    out: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE..."), tyro.conf.Positional]
    at: float = 0.0
    camera: Camera = "front"
    quality: Quality = "fast"

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_export  # noqa: PLC0415

        cli_export.export(self)


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """List the pieces of the repertoire.

    Attributes:
        names: Print bare names, one a line.
    """

    names: bool = False

    def run(self) -> None:
        """Do what the command says."""
        from roboguitarist import cli_report, pieces  # noqa: PLC0415

        names = "\n".join(pieces.names())
        print(names if self.names else cli_report.repertoire())


Command = (
    Annotated[Play, tyro.conf.subcommand("play")]
    | Annotated[Evaluate, tyro.conf.subcommand("evaluate")]
    | Annotated[Train, tyro.conf.subcommand("train")]
    | Annotated[Finger, tyro.conf.subcommand("finger")]
    | Annotated[Convert, tyro.conf.subcommand("convert")]
    | Annotated[View, tyro.conf.subcommand("view")]
    | Annotated[Export, tyro.conf.subcommand("export")]
    | Annotated[Pieces, tyro.conf.subcommand("pieces")]
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Args:
        args: Arguments after the program's name; by default those of the process.
    """
    args = list(sys.argv[1:] if args is None else args)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal without ü shows Für Elise as it can
    try:
        if args == ["--version"]:
            print(PROG, __version__)
        else:
            parse(args).run()
        sys.stdout.flush()
    except RoboGuitaristError as error:
        print(f"{PROG}: {error}", file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as error:
        # Nothing more can be printed; the interpreter must not try again when it exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return BROKEN_PIPE
        print(f"{PROG}: {error.strerror or error}", file=sys.stderr)
        return UNUSABLE
    return 0


def parse(
    args: Sequence[str],
) -> Play | Evaluate | Train | Finger | Convert | View | Export | Pieces:
    """The command that the arguments ask for.

    Raises:
        RoboGuitaristError: On arguments that make no sense.
        SystemExit: After printing help.
    """
    complaint = StringIO()
    try:
        with redirect_stderr(complaint):
            return tyro.cli(
                Command,  # pyright: ignore[reportArgumentType] - a union is a type for tyro
                prog=PROG,
                description=f"{PROG} {__version__}: robotic hands play guitar tablature.",
                args=args,
                config=(tyro.conf.FlagCreatePairsOff, tyro.conf.ConsolidateSubcommandArgs),
            )
    except SystemExit as stop:
        if stop.code in (0, None):
            raise
        reason = f"{_one_line(complaint.getvalue())} (see {PROG} --help)"
        raise RoboGuitaristError(reason) from None


def _one_line(box: str) -> str:
    """What tyro says in a box of many lines, from under its title to the next rule."""
    lines = dropwhile(_is_rule, box.splitlines()[1:])
    text = " ".join(line.strip("│ ") for line in takewhile(lambda line: not _is_rule(line), lines))
    return text.rstrip(".") or "unusable arguments"


def _is_rule(line: str) -> bool:
    return not line.strip("│╰─╯- ")
