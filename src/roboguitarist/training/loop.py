"""The loop of a run: learn, look at the policy now and then, and lose nothing."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

from tqdm import tqdm

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.learner import Learner, Progress
from roboguitarist.fretting.policy import Policy
from roboguitarist.training.folder import RunFolder

try:
    from torch.utils.tensorboard import SummaryWriter
except ModuleNotFoundError as error:
    raise RoboGuitaristError(
        "TensorBoard is not installed (pip install 'roboguitarist[train]')"
    ) from error


@dataclass(frozen=True)
class Evaluation:
    """How a policy plays.

    Attributes:
        score: The one number by which the best policy is chosen.
        scalars: All numbers, by names such as `twinkle/frame/f1`.
    """

    score: float
    scalars: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Rhythm:
    """How often what is done.

    Attributes:
        steps: Control ticks of the whole run.
        evaluate_every: Ticks between two evaluations; there is one more at the end.
        checkpoint_s: Longest time between two checkpoints: what a killed process loses at most.
    """

    steps: int
    evaluate_every: int
    checkpoint_s: float = 120.0


class Stop:
    """Whether someone wants the run to stop."""

    asked = False


class Pace:
    """How long the rest takes at the pace of late, and whether that is news.

    Args:
        total: Ticks of the whole run.
    """

    FIRST_S = 15.0
    """Before that the pace says little, and with less to go it is no news."""

    def __init__(self, total: int) -> None:
        self.total, self.begun = total, time.monotonic()
        self.left_s, self.end_s = math.inf, 0.0
        self._per_s = 0.0

    def news(self, progress: Progress) -> bool:
        """Whether the rest takes much longer or shorter than was said last, or nothing was."""
        share = 0.1 if self._per_s else 1.0
        self._per_s += share * (progress.per_s - self._per_s)
        self.left_s = max(self.total - progress.steps, 0) / max(self._per_s, 1e-9)
        now = time.monotonic()
        expected_s = self.end_s - now
        known = expected_s / 2 - 60 < self.left_s < expected_s * 2 + 60
        if min(now - self.begun, self.left_s) < self.FIRST_S or (self.end_s and known):
            return False
        self.end_s = now + self.left_s
        return True


def train(
    folder: RunFolder,
    learner: Learner,
    rhythm: Rhythm,
    evaluate: Callable[[Policy], Evaluation],
    say: Callable[[str], None] = tqdm.write,
) -> bool:
    """Learn until the steps are done or someone stops the run.

    A run whose folder has a checkpoint goes on from there.

    Args:
        folder: Where the run is kept; it has to be begun.
        learner: What learns.
        rhythm: How often what is done.
        evaluate: Plays with a policy, apart from training and without chance.
        say: Called with each line that a human would like to read.

    Returns:
        Whether the steps are done.

    Raises:
        RoboGuitaristError: If the folder cannot be written; the last checkpoint stays.
    """
    try:
        with ExitStack() as stack:
            stack.enter_context(folder.lock())
            folder.sweep()
            run = _Run(folder, learner, rhythm, evaluate, say)
            stop = stack.enter_context(stopping())
            run.board = stack.enter_context(_board(folder, learner.steps))
            run.bar = stack.enter_context(
                tqdm(total=rhythm.steps, initial=learner.steps, unit="tick", unit_scale=True,
                     disable=None, leave=False, dynamic_ncols=True)
            )  # fmt: skip
            return run.go(stop)
    except OSError as error:  # TensorBoard's file, too, needs room
        raise _unwritten(f"cannot write to {folder.path}: {error.strerror or error}") from error
    except RoboGuitaristError as error:
        if isinstance(error.__cause__, OSError):
            raise _unwritten(str(error)) from error
        raise


def _unwritten(what: str) -> RoboGuitaristError:
    return RoboGuitaristError(
        f"{what}; the run stopped, its last checkpoint is whole: make room, then --resume"
    )


class _Run:
    """A run while it goes."""

    board: SummaryWriter
    bar: tqdm[Any]

    def __init__(
        self,
        folder: RunFolder,
        learner: Learner,
        rhythm: Rhythm,
        evaluate: Callable[[Policy], Evaluation],
        say: Callable[[str], None],
    ) -> None:
        self.folder, self.learner, self.rhythm = folder, learner, rhythm
        self.evaluate, self.say, self.before_s = evaluate, say, 0.0
        state = folder.state()
        if state is not None:
            learner.restore(state["learner"])
            self.before_s = float(state["elapsed_s"])
        self.begun, self.saved, self.pace = time.monotonic(), time.monotonic(), Pace(rhythm.steps)
        # What was found after the checkpoint will be found again.
        self.rows = [row for row in folder.rows() if row["steps"] <= learner.steps]
        folder.write_rows(self.rows)

    @property
    def elapsed_s(self) -> float:
        """Time spent in this run, over all processes."""
        return self.before_s + time.monotonic() - self.begun

    def go(self, stop: Stop) -> bool:
        """Learn, and save at the end however it comes about."""
        for progress in self.learner.learn():
            self.bar.update(progress.steps - self.bar.n)
            self.bar.set_postfix(reward=f"{progress.reward:.3f}", refresh=False)
            self._tell(progress)
            if self.pace.news(progress):
                self.say(f"At this pace it takes another {minutes(self.pace.left_s)}.")
            if self._due():
                self._look(progress)
            if stop.asked:
                break
            if time.monotonic() - self.saved >= self.rhythm.checkpoint_s:
                self._save()
        done = self.learner.steps >= self.rhythm.steps
        self._save()
        return done

    def _due(self) -> bool:
        """An evaluation is."""
        last = self.rows[-1]["steps"] if self.rows else 0
        every, steps = self.rhythm.evaluate_every, self.learner.steps
        return steps // every > last // every or last < steps >= self.rhythm.steps

    def _tell(self, progress: Progress) -> None:
        named = {"reward": progress.reward, **progress.terms}
        for name, value in {**named, "ticks_per_s": progress.per_s}.items():
            self.board.add_scalar(f"train/{name}", value, progress.steps)
        for name, value in progress.losses.items():
            self.board.add_scalar(f"loss/{name}", value, progress.steps)

    def _look(self, progress: Progress) -> None:
        """Evaluate; keep the policy if it is the best so far."""
        policy = self.learner.policy()
        found = self.evaluate(policy)
        best = max((row["score"] for row in self.rows), default=-1.0)
        if found.score > best:
            policy.save(self.folder.best)
        row = {"steps": progress.steps, "elapsed_s": round(self.elapsed_s, 1),
               "score": found.score, "reward": progress.reward, **progress.terms,
               **found.scalars}  # fmt: skip
        self.rows.append(row)
        self.folder.write_rows(self.rows)
        for name, value in {"score": found.score, **found.scalars}.items():
            self.board.add_scalar(f"evaluation/{name}", value, progress.steps)
        self.board.flush()
        self.say(self._line(progress, found.score, max(best, found.score)))

    def _line(self, progress: Progress, score: float, best: float) -> str:
        return (
            f"{progress.steps:>10,} ticks, {minutes(self.elapsed_s)}: score {score:.3f}"
            f" (best {best:.3f}), reward {progress.reward:.3f}, {minutes(self.pace.left_s)} to go"
        )

    def _save(self) -> None:
        state = {"learner": self.learner.state(), "elapsed_s": self.elapsed_s}
        self.folder.save(state, self.learner.policy())
        self.saved = time.monotonic()


@contextmanager
def stopping() -> Iterator[Stop]:
    """Ctrl-C and a polite kill ask for a stop; a second one does not wait for it."""
    stop = Stop()

    def ask(signum: int, frame: FrameType | None) -> None:
        if stop.asked:
            raise KeyboardInterrupt
        stop.asked = True

    signals = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(one, ask) for one in signals]
    try:
        yield stop
    finally:
        for one, handler in zip(signals, before, strict=True):
            signal.signal(one, handler)


@contextmanager
def _board(folder: RunFolder, steps: int) -> Iterator[SummaryWriter]:
    """TensorBoard's file; what an earlier process wrote beyond the checkpoint is hidden."""
    writer = SummaryWriter(folder.path / "tensorboard", purge_step=steps or None)
    try:
        yield writer
    finally:
        with suppress(OSError):  # that the disk is full was said already
            writer.close()


def minutes(time_s: float) -> str:
    """A time as one says it."""
    if time_s < 90:
        return f"{time_s:.0f} s"
    return f"{time_s / 60:.0f} min" if time_s < 5400 else f"{time_s / 3600:.1f} h"
