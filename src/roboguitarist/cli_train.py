"""What `train` does: begin a run or go on with one, and say what becomes of it."""

from __future__ import annotations

import os
import shlex
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from roboguitarist import cli_play
from roboguitarist.errors import RoboGuitaristError

if TYPE_CHECKING:
    from roboguitarist.cli import Train
    from roboguitarist.fretting.learner import Learner
    from roboguitarist.tablature import Tablature
    from roboguitarist.training.folder import RunFolder
    from roboguitarist.training.settings import TrainConfig


_NOTHING = "no score (name a file or a piece, such as twinkle, or say --exercises; not both)"


def train(command: Train) -> None:
    """Train a policy, from the beginning or from where a run stopped.

    Raises:
        RoboGuitaristError: If a score or setting cannot be used, or the folder not be written.
        KeyboardInterrupt: If the run was stopped; all is saved then.
    """
    cli_play.load_mujoco()
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # TensorBoard and JAX say nothing
    from roboguitarist.training.folder import RunFolder  # noqa: PLC0415
    from roboguitarist.training.learners import make  # noqa: PLC0415

    folder = RunFolder(command.out or usual_place(command))
    config, tablatures = (_resumed if command.resume else _new)(command, folder)
    learner = make(config, tablatures)
    if not command.resume:
        cli_play.check_folder(folder.path)
        folder.begin(config.as_dict(), tablatures)
    pieces = f"{config.exercises} exercises" if config.exercises else ", ".join(tablatures)
    print(
        f"{config.algorithm} practises {pieces} with {config.n_envs} hands of the"
        f" kind {config.task.hand}, {config.learner.steps:,} ticks in all.\n"
        f"The run is kept in {folder.path}. Ctrl-C saves it and stops.\n"
        f"Curves: tensorboard --logdir {shlex.quote(str(folder.path))}",
        flush=True,
    )
    done = _run(folder, learner, config, tablatures)
    _report(folder, command, done)
    if not done:
        raise KeyboardInterrupt


def usual_place(command: Train) -> Path:
    """Folder of a run for which none is named: after its pieces, learner and seed.

    Raises:
        RoboGuitaristError: If no piece is named either.
    """
    names = [Path(score).stem for score in command.scores]
    if command.exercises and not names:
        names = ["exercises"]
    if not names:
        raise RoboGuitaristError(_NOTHING)
    seed = [] if command.seed is None else [f"seed{command.seed}"]
    return Path("runs") / "-".join([*names, _algorithm(command), *seed])


def _algorithm(command: Train) -> str:
    return command.algorithm or ("branching" if command.exercises else "batch-ppo")


def settings(command: Train, base: TrainConfig) -> TrainConfig:
    """Settings of a run with what the command says otherwise."""
    said = {
        name: value
        for name in ("steps", "seed", "hand", "control_hz", "mapping", "freedom", "euclidean",
                     "n_envs", "exercises")
        if (value := getattr(command, name)) not in (None, False)
    }  # fmt: skip
    task = {f.name: said[f.name] for f in fields(base.task) if f.name in said}
    if "control_hz" in task:  # the physics keep their time step
        rate = base.task.control_hz * base.task.substeps
        task["substeps"] = round(rate / task["control_hz"])
    return replace(
        base,
        task=replace(base.task, **task),
        learner=replace(base.learner, **{k: said[k] for k in ("steps", "seed") if k in said}),
        **{k: said[k] for k in ("n_envs", "exercises") if k in said},
    )


def _new(command: Train, folder: RunFolder) -> tuple[TrainConfig, dict[str, Tablature]]:
    from roboguitarist.training import practice  # noqa: PLC0415
    from roboguitarist.training.settings import defaults  # noqa: PLC0415

    config = settings(command, defaults(_algorithm(command)))
    if bool(command.scores) == bool(command.exercises):
        raise RoboGuitaristError(_NOTHING)
    if config.learner.steps < 1:
        raise RoboGuitaristError(f"--steps {config.learner.steps} (at least 1)")
    folder.check_free()
    if config.exercises:
        if config.exercises < 1 or config.task.task != "guided":
            raise RoboGuitaristError(
                f"--exercises {config.exercises} with {config.algorithm}"
                " (at least 1, with branching)"
            )
        return config, practice.exercises(config.exercises, config.learner.seed)
    tablatures = dict(cli_play.read(score, command.track) for score in command.scores)
    return config, tablatures


def _resumed(command: Train, folder: RunFolder) -> tuple[TrainConfig, dict[str, Tablature]]:
    """The run's own settings.

    Raises:
        RoboGuitaristError: If there is no run, or the command asks for another one.
    """
    from roboguitarist.training.settings import TrainConfig  # noqa: PLC0415

    saved, tablatures = folder.read()
    config = TrainConfig.of(saved)
    names = [Path(score).stem for score in command.scores]
    if (
        settings(command, config) != config
        or command.algorithm not in (None, config.algorithm)
        or names not in ([], list(tablatures))
    ):
        raise RoboGuitaristError(
            f"the run in {folder.path} was begun with other settings, see its config.json"
            " (with --resume they need not be said)"
        )
    return config, tablatures


def _run(
    folder: RunFolder, learner: Learner, config: TrainConfig, tablatures: dict[str, Tablature]
) -> bool:
    from roboguitarist.performance import PerformConfig  # noqa: PLC0415
    from roboguitarist.training import practice  # noqa: PLC0415
    from roboguitarist.training.evaluation import evaluator  # noqa: PLC0415
    from roboguitarist.training.loop import Rhythm, train  # noqa: PLC0415
    from roboguitarist.training.settings import EVALUATIONS  # noqa: PLC0415

    stage = PerformConfig(config.task.hand, config.task.guitar)
    steps = config.learner.steps
    look = (
        practice.examiner(config.task, config.n_threads)
        if config.exercises
        else evaluator(tablatures, stage, config.metric)
    )
    return train(folder, learner, Rhythm(steps, max(steps // EVALUATIONS, 1)), look)


def _report(folder: RunFolder, command: Train, done: bool) -> None:
    rows = folder.rows()
    if rows:
        best = max(rows, key=lambda row: row["score"])
        score = shlex.quote(command.scores[0]) if command.scores else "SCORE"
        print(f"Best policy: {folder.best}, score {best['score']:.3f} at {best['steps']:,} ticks.")
        print(f"To see and hear it: roboguitarist play {score} --policy {folder.best}")
    if not done:
        out = shlex.quote(str(folder.path))
        print(f"Stopped, nothing is lost. To go on: roboguitarist train --resume --out {out}")
