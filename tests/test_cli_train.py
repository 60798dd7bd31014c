import json
import subprocess
import sys

import pytest

from roboguitarist.cli import main
from roboguitarist.tablature import Note, Tablature

pytest.importorskip("torch")


@pytest.fixture
def tune(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "tune.json"
    path.write_text(Tablature((Note(0.0, 3, 2, 0.3),)).to_json())
    return str(path)


def complaint(capsys):
    _, err = capsys.readouterr()
    assert err.count("\n") == 1
    return err


@pytest.mark.slow
def test_a_run_is_kept_resumed_and_its_policy_plays(tune, tmp_path, capsys):
    few = ["--steps", "48", "--n-envs", "2", "--seed", "3"]
    assert main(["train", tune, *few]) == 0
    out = capsys.readouterr().out
    run = tmp_path / "runs" / "tune-batch-ppo-seed3"
    assert f"roboguitarist play {tune} --policy runs/tune-batch-ppo-seed3/best.npz" in out
    assert "Ctrl-C" in out
    assert json.loads((run / "config.json").read_text())["learner"]["seed"] == 3
    (row,) = map(json.loads, (run / "curve.jsonl").read_text().splitlines())
    assert row["steps"] == 48
    assert 0.0 <= row["tune/frame/f1"] <= 1.0

    assert main(["train", tune, *few]) == 2
    assert "--resume" in complaint(capsys)
    assert main(["train", "--resume", "--out", str(run)]) == 0
    assert "Best policy" in capsys.readouterr().out
    assert main(["train", "--resume", "--out", str(run), "--steps", "96"]) == 2
    assert "other settings" in complaint(capsys)

    best = str(run / "best.npz")
    assert main(["play", tune, "--policy", best, "--no-video", "--out", "out"]) == 0
    report = json.loads((tmp_path / "out" / "tune.json").read_text())
    assert (report["controller"], report["hand"]) == ("policy", "tendon")
    assert report["metrics"]["frame"]["f1"] == pytest.approx(row["tune/frame/f1"])
    capsys.readouterr()
    assert main(["play", tune, "--policy", best, "--hand", "linkage", "--no-video"]) == 2
    assert "'tendon'" in complaint(capsys)


def test_what_cannot_be_trained_is_refused(tune, tmp_path, capsys):
    assert main(["train"]) == 2
    assert "no score" in complaint(capsys)
    assert main(["train", "--resume", "--out", "nowhere"]) == 2
    assert "no run in nowhere" in complaint(capsys)
    assert main(["train", tune, "--control-hz", "-1"]) == 2
    assert complaint(capsys)
    assert not (tmp_path / "runs" / "tune-batch-ppo" / "config.json").exists()
    assert main(["play", tune, "--policy", tune]) == 2
    assert "not a saved Policy" in complaint(capsys)


@pytest.mark.parametrize("missing", ["torch", "tensorboard", "sbx"])
def test_what_is_not_installed_is_said_with_the_remedy(tune, missing):
    code = (
        "import sys\n"
        "class Without:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name.partition('.')[0] == {missing!r}:\n"
        "            raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, Without())\n"
        "from roboguitarist.cli import main\n"
        f"sys.exit(main(['train', {tune!r}, '--algorithm', 'droq']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "roboguitarist[train]" in done.stderr
