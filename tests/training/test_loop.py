import json
import os
import signal

import numpy as np
import pytest

pytest.importorskip("torch")

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.learner import Progress
from roboguitarist.fretting.policy import Policy
from roboguitarist.tablature import Note, Tablature
from roboguitarist.training.folder import RunFolder
from roboguitarist.training.loop import Evaluation, Pace, Rhythm, train

TUNE = Tablature((Note(0.0, 3, 2, 0.4),))


class Counter:
    """Learns to count; its policy says how far it is."""

    def __init__(self, total, at=lambda steps: None):
        self.total, self.at, self.steps = total, at, 0

    def learn(self):
        while self.steps < self.total:
            self.steps += 10
            self.at(self.steps)
            yield Progress(self.steps, 1000.0, 0.5, {"key": 0.25})

    def policy(self):
        one, zero = np.ones((1, 1), np.float32), np.full(1, self.steps, np.float32)
        return Policy(zero, one[0], one, zero, one, zero, one, zero, "paper", "tendon", 30.0)

    def state(self):
        return {"steps": self.steps}

    def restore(self, state):
        self.steps = state["steps"]


def score(policy):
    steps = float(policy.mean[0])
    return Evaluation(steps if steps < 60 else 0.0, {"tune/frame/f1": steps})


def begun(path):
    folder = RunFolder(path / "run")
    folder.begin({"steps": 100}, {"tune": TUNE})
    return folder


def run(folder, learner, every=20, checkpoint_s=1000.0):
    return train(folder, learner, Rhythm(100, every, checkpoint_s), score, lambda line: None)


def test_a_run_keeps_its_curve_and_its_best_policy(tmp_path):
    folder = begun(tmp_path)
    assert run(folder, Counter(100))
    assert [row["steps"] for row in folder.rows()] == [20, 40, 60, 80, 100]
    assert folder.rows()[0] | {"elapsed_s": 0} == {
        "steps": 20, "elapsed_s": 0, "score": 20.0, "reward": 0.5, "key": 0.25,
        "tune/frame/f1": 20.0,
    }  # fmt: skip
    assert Policy.load(folder.best).mean == 40
    assert Policy.load(folder.last).mean == 100
    assert folder.read() == ({"steps": 100}, {"tune": TUNE})


def test_a_run_that_breaks_goes_on_from_its_checkpoint(tmp_path):
    folder = begun(tmp_path)

    def fail(steps):
        if steps == 50:
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        run(folder, Counter(100, fail), every=10, checkpoint_s=0.0)
    # As if it had been killed after an evaluation, before the checkpoint after it.
    folder.write_rows([*folder.rows(), {"steps": 50, "score": 7}])
    seen = []
    assert run(folder, Counter(100, seen.append), every=10)
    assert seen == [50, 60, 70, 80, 90, 100]
    assert [row["steps"] for row in folder.rows()] == list(range(10, 101, 10))
    assert folder.rows()[4]["score"] == 50


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_saves_and_stops(tmp_path, number):
    folder = begun(tmp_path)
    before = signal.getsignal(number)
    kill = Counter(100, lambda steps: os.kill(os.getpid(), number) if steps == 30 else None)
    assert not run(folder, kill)
    state = folder.state()
    assert state is not None
    assert state["learner"] == {"steps": 30}
    assert signal.getsignal(number) is before
    assert run(folder, Counter(100))


def test_a_second_signal_does_not_wait(tmp_path):
    def twice(steps):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(begun(tmp_path), Counter(100, twice))


def test_a_full_disk_stops_the_run_with_a_message(tmp_path, monkeypatch):
    folder = begun(tmp_path)

    def full(*args):
        cause = OSError(28, "No space left on device")
        raise RoboGuitaristError("cannot write x: No space left on device") from cause

    monkeypatch.setattr("roboguitarist.training.checkpoint.save", full)
    with pytest.raises(RoboGuitaristError, match=r"No space left.*--resume"):
        run(folder, Counter(100))


def test_a_board_that_cannot_be_written_stops_the_run_with_a_message(tmp_path, monkeypatch):
    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("roboguitarist.training.loop.SummaryWriter.add_scalar", full)
    with pytest.raises(RoboGuitaristError, match=r"No space left.*--resume"):
        run(begun(tmp_path), Counter(100))


def test_the_time_left_is_said_at_first_and_when_it_changes_much(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("roboguitarist.training.loop.time.monotonic", lambda: now[0])
    pace, news = Pace(100_000), []
    for _ in range(40):
        now[0] += 10
        per_s = 100.0 if now[0] < 200 else 10.0  # as if learning began only then
        if pace.news(Progress(int(100 * min(now[0], 200)), per_s, 0.0)):
            news.append((now[0], round(pace.left_s)))
    assert news[0] == (20.0, 980)
    assert 2 <= len(news) <= 4
    assert news[-1][1] > 3000


def test_only_one_process_trains_in_a_folder(tmp_path):
    folder = begun(tmp_path)
    with folder.lock(), pytest.raises(RoboGuitaristError, match="another process"):
        run(folder, Counter(100))


def test_a_folder_is_begun_once(tmp_path):
    folder = begun(tmp_path)
    with pytest.raises(RoboGuitaristError, match="--resume"):
        folder.begin({}, {})
    with pytest.raises(RoboGuitaristError, match="no run"):
        RunFolder(tmp_path / "other").read()


def test_what_a_killed_process_left_is_swept_away(tmp_path):
    folder = begun(tmp_path)
    (folder.path / ".part-123.pt").write_bytes(b"half")
    folder.curve.write_text(json.dumps({"steps": 10, "score": 1}) + '\n{"steps": 2')
    assert [row["steps"] for row in folder.rows()] == [10]
    run(folder, Counter(100))
    assert not list(folder.path.glob(".part-*"))


def test_scalars_go_to_tensorboard(tmp_path):
    board = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    folder = begun(tmp_path)
    run(folder, Counter(100))
    events = board.EventAccumulator(str(folder.path / "tensorboard")).Reload()
    assert {"train/key", "evaluation/tune/frame/f1"} <= set(events.Tags()["scalars"])
    assert [e.step for e in events.Scalars("evaluation/score")] == [20, 40, 60, 80, 100]
