"""The experiments of the paper: figures 9 to 18, each by one command.

Usage: python benchmarks/paper.py 9 [10 ...] [--steps N] [--seeds 2] [--algorithm batch-ppo]
                                  [--jobs 2] [--runs DIR] [--results DIR] [--plot-only]

Every run is kept in DIR (runs/paper) and shared by the figures that need it. The command can be
stopped at any time and given again: what is done is not done again, what was begun goes on. Writes
results/paper-fig09.json and .png and so on, and prints a table of each. Run it on a machine that
does nothing else: the default 5 million ticks of a run take an hour or two
on one core.
"""

from __future__ import annotations

import os

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "TF_CPP_MIN_LOG_LEVEL": "3"}

import json
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import paper_plots
import record
import tyro
from paper_arms import FIGURES, TEMPI, TRANSFER_F1, Arm, Figure
from paper_reference import reference
from speed import processor

from roboguitarist import cli_report, formats, pieces
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.policy import Policy
from roboguitarist.performance import PerformConfig
from roboguitarist.training.evaluation import evaluator
from roboguitarist.training.folder import RunFolder
from roboguitarist.training.learners import make
from roboguitarist.training.loop import Rhythm, train
from roboguitarist.training.settings import EVALUATIONS, Algorithm, defaults


@dataclass(frozen=True)
class Command:
    """Which figures, and how much is spent on them.

    Attributes:
        figures: Their numbers, 9 to 18.
        steps: Control ticks of each run; the learner's default if not said.
        seeds: Runs of each arm.
        algorithm: The learner.
        jobs: Runs at the same time, each on one core.
        runs: Folder of the runs.
        results: Folder of the results and plots.
        plot_only: Train nothing, use what is there.
    """

    figures: Annotated[tuple[int, ...], tyro.conf.Positional]
    steps: int | None = None
    seeds: int = 2
    algorithm: Algorithm = "batch-ppo"
    jobs: int = 2
    runs: Path = Path("runs/paper")
    results: Path = record.FOLDER
    plot_only: bool = False

    def folder(self, arm: Arm, seed: int) -> RunFolder:
        """Where the run of an arm is kept."""
        config = arm.config(self.algorithm, self.steps, seed)
        return RunFolder(self.runs / arm.name(self.algorithm, config.learner.steps, seed))


def run(command: Command, arm: Arm, seed: int) -> bool:
    """Do what is left of one run; whether it is done now."""
    folder, config = command.folder(arm, seed), arm.config(command.algorithm, command.steps, seed)
    rows, steps = folder.rows(), config.learner.steps
    if rows and rows[-1]["steps"] >= steps:
        return True
    config = replace(config, n_threads=0)  # the other core has its own run
    tablatures = {arm.piece: formats.load(pieces.path(arm.piece))}
    if not folder.settings.exists():
        folder.begin(config.as_dict(), tablatures)
    elif replace(config, n_threads=0).as_dict() != folder.read()[0]:
        raise RoboGuitaristError(f"{folder.path} was begun with other settings (move it away)")
    evaluate = evaluator(tablatures, PerformConfig(config.task.hand), "frame")
    name = folder.path.name
    return train(
        folder,
        make(config, tablatures),
        Rhythm(steps, max(steps // EVALUATIONS, 1)),
        evaluate,
        lambda line: print(f"{name}: {line.strip()}", file=sys.stderr, flush=True),
    )


def run_all(command: Command) -> bool:
    """Do all runs that the figures need; whether all are done."""
    wanted = {}
    for seed in range(command.seeds):  # one of each first
        for number in command.figures:
            for arm in FIGURES[number].arms:
                wanted.setdefault(command.folder(arm, seed).path, (arm, seed))
    with ProcessPoolExecutor(
        command.jobs, mp_context=get_context("spawn"), max_tasks_per_child=1
    ) as pool:
        jobs = [pool.submit(run, command, arm, seed) for arm, seed in wanted.values()]
        return all(job.result() for job in as_completed(jobs))


def results(command: Command, figure: Figure) -> list[dict[str, Any]]:
    """Each arm with its runs: the best evaluation, the last, and the curve of F1."""
    out = []
    for arm in figure.arms:
        found = []
        for seed in range(command.seeds):
            rows = command.folder(arm, seed).rows()
            if rows:
                best = max(rows, key=lambda row: row["score"])
                found.append({
                    "seed": seed, "run": command.folder(arm, seed).path.name,
                    "minutes": round(rows[-1]["elapsed_s"] / 60, 1), "ticks": rows[-1]["steps"],
                    "best": measured(best, arm.piece), "last": measured(rows[-1], arm.piece),
                    "curve": [[row["steps"], row["elapsed_s"], *frame(row, arm.piece)]
                              for row in rows],
                })  # fmt: skip
        out.append({"piece": arm.piece, "label": arm.label, "paper": dict(arm.paper),
                    "task": dict(arm.task), "learner": dict(arm.learner),
                    "runs": found})  # fmt: skip
    return out


def measured(row: dict[str, Any], piece: str) -> dict[str, float]:
    """The metrics of the piece in a row of the curve: fretting, sound, motion."""
    start = f"{piece}/"
    return {key.removeprefix(start): round(value, 4) for key, value in row.items()
            if key.startswith(start)}  # fmt: skip


def frame(row: dict[str, Any], piece: str) -> list[float]:
    """Precision, recall and F1 of `frame`."""
    return [round(row.get(f"{piece}/frame/{name}", 0.0), 4) for name in paper_plots.NAMES]


def transfer(command: Command) -> list[dict[str, Any]]:
    """Figure 12: the policies of Scales Practice on other pieces, at three tempi."""
    (arm,) = FIGURES[12].arms
    out = []
    for seed in range(command.seeds):
        best = command.folder(arm, seed).best
        if not best.exists():
            continue
        policy = Policy.load(best)
        for piece, paper in TRANSFER_F1.items():
            for tempo in TEMPI:
                tablature = formats.load(pieces.path(piece)).at_speed(tempo)
                found = evaluator({piece: tablature}, PerformConfig(policy.task_config().hand))(
                    policy
                )
                out.append({"piece": piece, "tempo": tempo, "seed": seed,
                            "paper": paper if tempo == 1.0 else None,
                            "frame": frame(dict(found.scalars), piece)})  # fmt: skip
    return out


def report(command: Command, figure: Figure) -> None:
    """Write the figure's results and plot, and print its table."""
    arms = results(command, figure)
    name = f"paper-fig{figure.number:02d}"
    document: dict[str, Any] = {"figure": figure.number, "title": figure.title,
                                "claim": figure.claim, "arms": arms}  # fmt: skip
    if figure.number == 12:
        document["transfer"] = transfer(command)
    played = sorted({arm.piece for arm in figure.arms})
    document["reference"] = {piece: reference(piece) for piece in played}
    words = " ".join(sys.argv[1:])
    path = command.results / f"{name}.json"
    facts = {
        "versions": record.versions("torch"),
        "processor": processor(),
        "cores": os.cpu_count(),
        "settings": defaults(command.algorithm).as_dict(),
    }
    text = json.dumps({"command": f"python benchmarks/paper.py {words}", **facts, **document},
                      indent=1)  # fmt: skip
    path.write_text(text + "\n", encoding="utf-8")
    paper_plots.draw(figure, document, path.with_suffix(".png"))
    print(f"\nFigure {figure.number}, {figure.title}. The paper: {figure.claim}.\n")
    print(table(arms))
    print(path, path.with_suffix(".png"))


def table(arms: list[dict[str, Any]]) -> str:
    """Means over the seeds of the best policies."""
    rows = []
    for arm in arms:
        runs = arm["runs"]
        mean = {name: f"{np.mean([one['best'][f'frame/{name}'] for one in runs]):.2f}"
                if runs else "-" for name in paper_plots.NAMES}  # fmt: skip
        spread = " ".join(f"{one['best']['frame/f1']:.2f}" for one in runs) or "-"
        paper = ", ".join(f"{key} {value:g}" for key, value in arm["paper"].items()) or "-"
        spent = f"{np.mean([one['minutes'] for one in runs]):.0f}" if runs else "-"
        rows.append((arm["piece"], arm["label"], *mean.values(), spread, paper, spent))
    header = ("piece", "arm", *paper_plots.NAMES, "f1 of each seed", "paper", "min a run")
    return cli_report.table([header, *rows], text_columns=2)


def main() -> int:
    """Train what is missing, then report every figure."""
    command = tyro.cli(Command, description=__doc__)
    unknown = [number for number in command.figures if number not in FIGURES]
    if unknown or not command.figures:
        print(f"paper.py: figures are 9 to 18, not {unknown or 'none'}", file=sys.stderr)
        return 2
    try:
        done = command.plot_only or run_all(command)
    except RoboGuitaristError as error:
        print(f"paper.py: {error}", file=sys.stderr)
        return 2
    for number in command.figures:
        report(command, FIGURES[number])
    if not done:
        print("Stopped; the same command goes on.", file=sys.stderr)
    return 0 if done else 130


if __name__ == "__main__":
    sys.exit(main())
