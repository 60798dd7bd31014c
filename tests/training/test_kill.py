"""A run that is killed again and again: in a process of its own, for it forks."""

import subprocess
import sys

import pytest

pytest.importorskip("torch")

KILLS = 20
SCRIPT = """
import os, random, signal, sys, time
from pathlib import Path
import torch
from roboguitarist.fretting.episodes import FrettingBatch
from roboguitarist.fretting.policy import Policy
from roboguitarist.fretting.ppo import PPO, PPOConfig
from roboguitarist.fretting.task import TaskConfig
from roboguitarist.tablature import Note, Tablature
from roboguitarist.training.folder import RunFolder
from roboguitarist.training.loop import Evaluation, Rhythm, train

torch.set_num_threads(1)
kills, where = int(sys.argv[1]), Path(sys.argv[2])
tune = Tablature((Note(0.0, 3, 2, 0.4), Note(0.4, 2, 1, 0.4)))
task = TaskConfig(random_start=True, max_ticks=20)
config = PPOConfig(steps=64 * 60, ticks=8, minibatch=64, hidden=16, warm_up=0)
learner = PPO(FrettingBatch([tune], task, 8), config)  # what forks inherit


def begin(name):
    folder = RunFolder(where / name)
    folder.begin({}, {"tune": tune})
    return folder


def go_on(folder):
    pid = os.fork()
    if pid == 0:
        rhythm = Rhythm(config.steps, 640, checkpoint_s=0.0)
        score = lambda policy: Evaluation(float(policy.weight_1.sum()))
        done = train(folder, learner, rhythm, score, lambda line: None)
        os._exit(0 if done else 1)
    return pid


def ended(pid):
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


whole, broken = begin("whole"), begin("broken")
start = time.perf_counter()
assert ended(go_on(whole)) == 0
took_s = time.perf_counter() - start
rng, count, steps = random.Random(0), 0, []
while count < kills:
    pid = go_on(broken)
    time.sleep(rng.uniform(0.0, took_s / kills))
    os.kill(pid, signal.SIGKILL)
    if ended(pid) == 0:
        break
    count += 1
    steps.append(broken.state()["learner"]["steps"] if broken.checkpoint.exists() else 0)
    if steps[-1] >= config.steps - 64:
        break
assert steps == sorted(steps), steps
assert ended(go_on(broken)) == 0
first, second = Policy.load(whole.last), Policy.load(broken.last)
assert (first.weight_1 == second.weight_1).all() and (first.mean == second.mean).all()
kept = [[(row["steps"], row["score"]) for row in run.rows()] for run in (whole, broken)]
assert kept[0] == kept[1] and len(kept[0]) == 6, kept
assert not list(broken.path.glob(".part-*"))
print(count, "kills at", steps)
"""


@pytest.mark.slow
def test_a_run_killed_twenty_times_ends_as_the_unbroken_one(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(KILLS), str(tmp_path)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) >= KILLS, done.stdout
