import mido
import numpy as np
import pytest

from builders import moving
from complaints import complaint
from roboguitarist import cli_export, live, video
from roboguitarist.cli import main
from roboguitarist.tablature import Note, Tablature

TAB = Tablature((Note(0.0, 3, 0, 0.4), Note(0.5, 2, 1, 0.5), Note(1.0, 1, 3, 0.5)), title="Three")


@pytest.fixture
def recording(tmp_path):
    moving(TAB).save(tmp_path / "three.npz")
    return tmp_path / "three.npz"


def test_view_makes_the_page_beside_the_recording(recording, capsys, monkeypatch):
    opened = []
    monkeypatch.setattr(cli_export.webbrowser, "open", opened.append)
    monkeypatch.setattr(live, "has_screen", lambda: True)
    assert main(["view", str(recording)]) == 0
    page = recording.with_suffix(".html")
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert capsys.readouterr().out == f"Written: {page}\n"
    assert opened == [page.as_uri()]
    assert (
        main(["view", str(recording), "--no-open", "--out", str(recording.parent / "b.html")]) == 0
    )
    assert (recording.parent / "b.html").exists()
    assert len(opened) == 1


def test_export_writes_what_the_suffixes_say(recording, tmp_path, capsys):
    names = ["a.glb", "b.mid", "c.csv", "d.html", "e.wav"]
    paths = [str(tmp_path / "new" / name) for name in names]
    assert main(["export", str(recording), *paths]) == 0
    assert capsys.readouterr() == (f"Written: {', '.join(paths)}\n", "")
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == names
    assert (tmp_path / "new" / "a.glb").read_bytes()[:4] == b"glTF"
    assert len(mido.MidiFile(paths[1]).tracks) == 2
    assert (tmp_path / "new" / "c.csv").read_text().startswith("time_s,lh_forearm_x_m")


def test_a_picture_is_of_the_time_and_the_camera_that_were_asked_for(
    recording, tmp_path, monkeypatch
):
    asked = []

    def still(played, time_s, camera, *, size, quality, overlay):
        asked.append((time_s, camera, quality, overlay))
        return np.zeros((size[1], size[0], 3), np.uint8)

    monkeypatch.setattr(video, "still", still)
    pytest.importorskip("PIL")
    args = ["--at", "0.5", "--camera", "left", "--quality", "high"]
    assert main(["export", str(recording), str(tmp_path / "a.png"), *args]) == 0
    assert asked == [(0.5, "left", "high", True)]
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["three.npz"], "no file to write"),
        (["three.npz", "a.obj"], ".glb, .mid, .csv"),
        (["three.npz", "a"], "no such export"),
        (["none.npz", "a.glb"], "cannot read none.npz"),
        (["text.npz", "a.glb"], "not a saved Performance"),
    ],
)
def test_what_cannot_be_exported_gives_one_line(args, message, recording, capsys, monkeypatch):
    monkeypatch.chdir(recording.parent)
    (recording.parent / "text.npz").write_text("no recording")
    before = sorted(recording.parent.iterdir())
    assert main(["export", *args]) == 2
    assert message in complaint(capsys)
    assert sorted(recording.parent.iterdir()) == before


@pytest.mark.parametrize("name", ["none.npz", "text.npz"])
def test_what_cannot_be_viewed_gives_one_line(name, recording, capsys, monkeypatch):
    monkeypatch.chdir(recording.parent)
    (recording.parent / "text.npz").write_text("no recording")
    assert main(["view", name]) == 2
    assert name in complaint(capsys)


def test_a_live_view_without_a_screen_gives_one_line(recording, capsys, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["view", str(recording), "--live"]) == 2
    assert "no window for the live view" in complaint(capsys)
