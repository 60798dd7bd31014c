import ctypes
import json
import os
import subprocess
import sys
import time
import wave
from pathlib import Path

import numpy as np
import pytest

from builders import moving
from complaints import complaint
from roboguitarist import __version__, cli_play, formats, performance, pieces, video
from roboguitarist.cli import Evaluate, Export, Finger, Pieces, Play, Train, View, main, parse
from roboguitarist.fingering import assign
from roboguitarist.performance import Performance
from roboguitarist.tablature import Note, Tablature

TAB = Tablature((Note(0.0, 3, 0, 0.4), Note(0.5, 2, 1, 0.5), Note(1.0, 1, 3, 0.5)), title="Three")
RUN = [sys.executable, "-c", "import sys; from roboguitarist.cli import main; sys.exit(main())"]


@pytest.fixture
def tab(tmp_path):
    path = tmp_path / "three.json"
    path.write_text(TAB.to_json())
    return str(path)


@pytest.fixture
def no_physics(monkeypatch):
    def perform(fingering, config, progress):
        progress(1.0)
        return moving(fingering.tablature)

    monkeypatch.setattr(performance, "perform", perform)


def test_no_piece_of_that_name_lists_those_that_there_are(capsys):
    assert main(["finger", "twinkel"]) == 2
    line = complaint(capsys)
    assert "did you mean twinkle?" in line
    assert all(name in line for name in pieces.names())


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ([], "play"),
        (["sing", "twinkle"], "sing"),
        (["play"], "SCORE"),
        (["play", "twinkle", "--hand", "claw"], "linkage"),
        (["play", "twinkle", "--controller", "me"], "planner"),
        (["play", "twinkle", "--louder"], "--louder"),
        (["play", "twinkle", "--seed", "x"], "--seed"),
        (["play", "twinkle", "--speed", "0"], "speed 0 (0.1 to 10"),
        (["finger", "twinkle", "--track", "2"], "no part '2'"),
        (["evaluate"], "no score"),
    ],
)
def test_arguments_that_make_no_sense_give_one_line(args, reason, capsys):
    assert main(args) == 2
    assert reason in complaint(capsys)


def test_every_command_parses_its_defaults():
    assert parse(["play", "x"]) == Play(score="x", out=Path("out"))
    assert parse(["evaluate", "x", "y"]) == Evaluate(scores=("x", "y"))
    assert parse(["finger", "x"]) == Finger(score="x")
    assert parse(["train", "x"]) == Train(scores=("x",))
    assert parse(["train", "--resume"]) == Train(resume=True)
    assert parse(["view", "x.npz"]) == View(recording=Path("x.npz"))
    assert parse(["export", "x.npz", "a.glb", "b.mid"]) == Export(
        recording=Path("x.npz"), out=(Path("a.glb"), Path("b.mid"))
    )
    assert parse(["pieces"]) == Pieces(names=False)
    assert parse(["play", "x"]) == parse(
        "play x --controller planner --speed 1.0 --seed 0 --camera front".split()
    )


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--help"], ["play", "evaluate", "train", "finger", "pieces"]),
        (["play", "--help"], ["--out DIR", "--no-video", "--speed", "--track N", "--seed"]),
        (["evaluate", "--help"], ["--json FILE", "--hand {linkage,tendon}"]),
        (["train", "--help"], ["--algorithm", "droq", "--resume", "--out DIR", "--steps"]),
    ],
)
def test_help_names_what_there_is(args, words, capsys):
    with pytest.raises(SystemExit) as stop:
        main(args)
    assert stop.value.code in (0, None)
    out, err = capsys.readouterr()
    assert all(word in out for word in words)
    assert err == ""


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"roboguitarist {__version__}\n"


def test_pieces_by_name_and_as_a_table(capsys):
    assert main(["pieces", "--names"]) == 0
    assert capsys.readouterr().out.split() == list(pieces.names())
    assert main(["pieces"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + len(pieces.PIECES)
    assert len({len(line) for line in lines}) == 1


def test_finger_writes_the_fingers_into_a_score_that_reads_back(tmp_path, capsys):
    out = tmp_path / "fingered.musicxml"
    assert main(["finger", "happy-birthday", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    tablature = formats.load(pieces.path("happy-birthday"))
    fingering = assign(tablature, method="search")
    again = formats.load(out)
    assert again.notes == fingering.marked().notes
    assert assign(again, method="search").left.tolist() == fingering.left.tolist()
    text = out.read_text(encoding="utf-8")
    for tag in ("<fingering>", "<pluck>", "<string>", "<fret>"):
        assert text.count(tag) >= len(tablature.notes) / 2, tag
    assert main(["finger", str(out)]) == 0
    music = slice(4, None)
    assert capsys.readouterr().out.splitlines()[music] == printed.splitlines()[music]


def test_finger_offers_the_papers_rule(capsys):
    assert main(["finger", "fur-elise", "--method", "paper"]) == 0
    assert "fingering paper" in capsys.readouterr().out


def test_finger_prints_the_tab_and_every_piece_is_found_by_name(capsys):
    assert main(["finger", "fur-elise"]) == 0
    out, err = capsys.readouterr()
    assert "Für Elise" in out
    assert err == ""


def test_play_writes_what_it_played(tab, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["play", tab, "--out", str(out), "--no-video"]) == 0
    assert sorted(path.name for path in out.iterdir()) == [
        "three.html",
        "three.json",
        "three.npz",
        "three.wav",
    ]
    recording = Performance.load(out / "three.npz")
    assert recording.tablature == TAB
    assert recording.pluck_string.tolist() == [3, 2, 1]
    with wave.open(str(out / "three.wav")) as file:
        assert file.getparams()[:3] == (2, 2, 44100)
        assert file.getnframes() / 44100 > TAB.duration_s
        assert np.frombuffer(file.readframes(44100), "<i2").any()
    report = json.loads((out / "three.json").read_text())
    assert {key: report[key] for key in ("name", "controller", "hand", "seed")} == {
        "name": "three", "controller": "planner", "hand": "linkage", "seed": 0,
    }  # fmt: skip
    assert {"frame", "frame_free", "note", "onset", "timing_ms", "motion"} <= set(report["metrics"])
    assert set(report["metrics"]["speed"]) == {"performance", "sound"}
    assert "three" in capsys.readouterr().out


@pytest.mark.usefixtures("no_physics")
def test_a_machine_without_renderer_gets_everything_but_the_video(
    tab, tmp_path, capsys, monkeypatch
):
    def render(*_, **__):
        raise video.UnavailableError("no OpenGL library found")

    monkeypatch.setattr(video, "render", render)
    out = tmp_path / "out"
    assert main(["play", tab, "--out", str(out)]) == 0
    assert capsys.readouterr().err == "roboguitarist: no video: no OpenGL library found\n"
    assert sorted(path.suffix for path in out.iterdir()) == [".html", ".json", ".npz", ".wav"]


@pytest.mark.usefixtures("no_physics")
def test_the_video_gets_the_sound_that_was_written(tab, tmp_path, capsys, monkeypatch):
    def render(played, path, camera, *, quality, samples, progress):
        progress(1.0)
        path.write_bytes(samples.tobytes() + f"{camera} {quality}".encode())

    monkeypatch.setattr(video, "render", render)
    out = tmp_path / "out"
    assert main(["play", tab, "--out", str(out), "--camera", "player", "--quality", "high"]) == 0
    film = (out / "three.mp4").read_bytes()
    assert film.endswith(b"player high")
    assert len(film) - len("player high") == 2 * (len((out / "three.wav").read_bytes()) - 44)
    written = capsys.readouterr().out.splitlines()[-1].removeprefix("Written: ").split(", ")
    assert sorted(map(Path, written)) == sorted(out.iterdir())


def test_a_renderer_that_is_not_there_does_not_keep_the_hands_from_playing(tab):
    try:
        ctypes.CDLL("libOSMesa.so.8")
    except OSError:
        environment = {**os.environ, "MUJOCO_GL": "osmesa"}
        done = subprocess.run(
            [*RUN, "evaluate", tab], env=environment, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")
    else:
        pytest.skip("OSMesa is there")


def test_play_twice_gives_the_same_bytes(tab, tmp_path):
    for folder in ("a", "b"):
        assert main(["play", tab, "--out", str(tmp_path / folder), "--no-video"]) == 0
    for name in ("three.npz", "three.wav"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_speed_and_hand_reach_the_performance(tab, tmp_path):
    args = ["play", tab, "--out", str(tmp_path), "--no-video", "--hand", "tendon", "--speed", "2"]
    assert main([*args, "--seed", "7", "--out", str(tmp_path / "out")]) == 0
    recording = Performance.load(tmp_path / "out" / "three.npz")
    assert (recording.hand, recording.seed) == ("tendon", 7)
    assert recording.tablature == TAB.at_speed(2)


@pytest.mark.usefixtures("no_physics")
def test_evaluate_prints_a_row_for_each_score_and_writes_a_list(tab, tmp_path, capsys):
    file = tmp_path / "deep" / "metrics.json"
    assert main(["evaluate", tab, "twinkle", "--json", str(file)]) == 0
    out, err = capsys.readouterr()
    assert [line.split()[1] for line in out.splitlines()[2:]] == ["three", "twinkle"]
    assert err == ""
    reports = json.loads(file.read_text())
    assert [report["name"] for report in reports] == ["three", "twinkle"]
    assert reports[1]["metrics"]["note"] == {"precision": 1.0, "recall": 1.0, "f1": 1.0}
    assert reports[1]["misses"] == {}


@pytest.mark.usefixtures("no_physics")
def test_a_piece_without_notes_has_no_score(tmp_path, capsys):
    (tmp_path / "rest.json").write_text(Tablature(()).to_json())
    assert main(["evaluate", str(tmp_path / "rest.json")]) == 0
    assert capsys.readouterr().out.splitlines()[2].split()[3:10:2] == ["-"] * 4


@pytest.mark.usefixtures("no_physics")
def test_what_was_not_played_as_written_is_said_on_stderr(tmp_path, capsys):
    chord = [Note(0.0, 1, 1, 1.0, bar=3), Note(0.0, 2, 12, 1.0, bar=3)]
    (tmp_path / "wide.json").write_text(Tablature(tuple(chord)).to_json())
    assert main(["evaluate", str(tmp_path / "wide.json")]) == 0
    err = capsys.readouterr().err
    assert err.startswith("roboguitarist: wide: bar 3, beat 1: string ")
    assert "out of reach" in err


@pytest.mark.usefixtures("no_physics")
@pytest.mark.parametrize("out", ["file", "file/below", "/proc/nowhere"])
def test_an_output_folder_that_cannot_be_written(out, tab, tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    folder = tmp_path / out
    assert main(["play", tab, "--out", str(folder), "--no-video"]) == 2
    assert str(folder) in complaint(capsys)
    assert main(["evaluate", tab, "--json", str(folder / "metrics.json")]) == 2
    assert str(folder) in complaint(capsys)


@pytest.mark.usefixtures("no_physics")
def test_a_score_is_never_replaced_by_its_own_metrics(tab, tmp_path, capsys):
    assert main(["play", tab, "--out", str(tmp_path), "--no-video"]) == 2
    assert "would replace the score" in complaint(capsys)
    assert Path(tab).read_text() == TAB.to_json()


@pytest.mark.usefixtures("no_physics")
def test_a_full_disk_leaves_nothing_half_written(tab, tmp_path, capsys):
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)]
    if os.name != "posix" or os.getuid() or subprocess.run(mount, check=False).returncode:
        pytest.skip("only root can make a small disk")
    try:
        assert main(["play", tab, "--out", str(disk / "out"), "--no-video"]) == 2
        left = [path.name for path in (disk / "out").iterdir()]
    finally:
        subprocess.run(["umount", str(disk)], check=True)
    line = complaint(capsys)
    assert "three.wav" in line
    assert "No space left" in line
    assert left == ["three.npz"]


@pytest.mark.usefixtures("no_physics")
def test_a_disk_that_fills_up_while_a_file_is_written(tab, tmp_path, capsys, monkeypatch):
    def full(path, text, **_):
        with path.open("w") as file:
            file.write(text[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    assert main(["evaluate", tab, "--json", str(tmp_path / "out" / "metrics.json")]) == 2
    assert "No space left" in capsys.readouterr().err
    assert list((tmp_path / "out").iterdir()) == []


def test_an_interrupt_is_quiet(tab, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli_play, "read", interrupted)
    assert main(["finger", tab]) == 130
    assert capsys.readouterr() == ("", "")


def test_a_defect_of_ours_is_not_hidden(tab, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr(cli_play, "read", broken)
    with pytest.raises(ZeroDivisionError):
        main(["finger", tab])


def test_a_reader_that_has_gone_is_no_error():
    with subprocess.Popen(
        [*RUN, "pieces"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_output_that_cannot_be_printed_gives_one_line():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*RUN, "pieces"], stdout=full, stderr=subprocess.PIPE, check=False, text=True
        )
    assert done.returncode == 2
    assert done.stderr == "roboguitarist: No space left on device\n"


def test_help_comes_quickly_and_without_heavy_modules():
    code = (
        "import sys; from roboguitarist.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: print([m for m in ('mujoco', 'scipy') if m in sys.modules])"
    )
    start = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert time.perf_counter() - start < 2
    assert done.stdout.endswith("[]\n")
