import base64
import gzip
import json
import re
import sys
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest

from builders import moving, unpacked_glb, without_plucks
from roboguitarist import viewer
from roboguitarist.alignment import misses
from roboguitarist.metrics import evaluate
from roboguitarist.tablature import Bar, Note, Tablature
from roboguitarist.viewer.sound_file import encoded

NOTES = (Note(0.0, 2, 1, 0.5), Note(0.5, 4, 2, 0.5), Note(1.0, 1, 0, 0.5))
SHORT = Tablature(NOTES, (Bar(0.0, 1), Bar(1.0, 2)), title="</script><b>Für & zwei")


def part(text, name):
    (found,) = re.findall(rf'<script type="[^"]*" id="{name}"[^>]*>(.*?)</script>', text, re.DOTALL)
    return found


@pytest.fixture(scope="module")
def performance():
    return without_plucks(moving(SHORT), np.array([False, False, True]))


@pytest.fixture(scope="module")
def text(performance):
    return viewer.page(performance)


def test_the_page_holds_notes_misses_and_metrics(text, performance):
    data = json.loads(part(text, "data"))
    assert data["title"] == SHORT.title
    assert [note[:4] for note in data["notes"]] == [
        [0.0, 2, 1, 0.5], [0.5, 4, 2, 0.5], [1.0, 1, 0, 0.5],
    ]  # fmt: skip
    assert data["misses"] == [[2, str(misses(performance)[0])]]
    assert data["score"] == "2 of 3 notes right"
    note = evaluate(performance).note
    assert note
    assert dict(data["metrics"])["Notes, F1"] == f"{note.f1:.3f}"
    assert data["bars"] == [[0.0, 1], [1.0, 2]]
    assert [(p[2], p[3]) for p in data["presses"]] == [(2, 1), (4, 2)]
    assert len(data["plucks"]) == len(data["rings"]) == 2


def test_the_page_holds_the_scene_from_the_same_start(text):
    data = json.loads(part(text, "data"))
    content, _ = unpacked_glb(gzip.decompress(base64.b64decode(part(text, "scene"))))
    root = content["nodes"][content["scenes"][0]["nodes"][0]]
    assert root["extras"]["start_s"] == data["start_s"] == -0.5
    inputs = content["accessors"][content["animations"][0]["samplers"][0]["input"]]
    assert inputs["max"][0] == pytest.approx(data["end_s"] - data["start_s"], abs=1e-4)


def test_a_title_cannot_end_its_element(text):
    assert text.count("</script>") == text.count("<script")
    assert "<title>&lt;/script&gt;&lt;b&gt;Für &amp; zwei</title>" in text


def test_the_page_names_no_place_outside_itself(text):
    ours = text.replace(viewer._asset("three.min.js"), "")
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]', ours)
    assert not re.findall(r"https?://(?!www.w3.org|threejs.org)", ours.split("MIT License")[0])
    assert "default-src 'none'" in text


def test_the_licence_of_what_is_bundled_is_in_the_page(text):
    licence = part(text, "licence-text")
    assert "three.js authors" in licence
    assert "Permission is hereby granted" in licence
    assert "Apache-2.0" in licence


def test_the_page_is_the_same_twice_and_appears_when_complete(performance, text, tmp_path):
    viewer.write_page(performance, tmp_path / "a.html")
    again = (tmp_path / "a.html").read_text(encoding="utf-8")
    sound = re.compile(r'id="sound"[^>]*>[^<]*<')
    assert sound.sub("", again) == sound.sub("", text)


def test_a_performance_without_notes_has_a_page_too():
    data = json.loads(part(viewer.page(moving(Tablature(()))), "data"))
    assert data["title"] == "Untitled"
    assert data["notes"] == data["misses"] == data["rings"] == []


def sounded(file):
    """Samples (n, 2) and rate of an encoded sound."""
    av = pytest.importorskip("av")
    with av.open(BytesIO(file)) as container:
        frames = list(container.decode(audio=0))
    return np.concatenate([f.to_ndarray() for f in frames], axis=1).T, frames[0].sample_rate


def test_the_sound_comes_back_in_time():
    pytest.importorskip("av")
    samples = np.zeros((44100, 2), np.float32)
    samples[22050:, 0] = 0.5 * np.sin(np.arange(22050) * 0.06)
    kind, file = encoded(samples, 44100)
    assert kind == "audio/webm"
    back, rate_hz = sounded(file)
    first = np.flatnonzero(np.abs(back).max(axis=1) > 0.1)[0]
    assert first / rate_hz == pytest.approx(0.5, abs=0.01)
    assert len(file) < 30_000


def test_without_an_encoder_the_sound_is_a_wav(monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    kind, file = encoded(np.full((44100, 2), 0.25, np.float32), 44100)
    assert kind == "audio/wav"
    assert len(file) == 44 + 2 * 22050
    assert np.frombuffer(file[44:], "<i2")[10000] == pytest.approx(8192, abs=60)


@pytest.mark.slow
def test_a_minute_with_both_hands_takes_less_than_six_megabytes():
    notes = [Note(round(0.25 * k, 6), 1 + k % 6, k % 5, 1.4) for k in range(235)]
    busy = moving(Tablature(tuple(sorted(notes, key=lambda note: note.place))))
    since_s = busy.time_s - busy.time_s[0]
    rng = np.random.default_rng(0)
    # Every joint moves all the time, with five frequencies and the unrest of a servo.
    rates, phases = rng.uniform(0.5, 12, (5, 51)), rng.uniform(0, 6, (5, 51))
    waves = np.sin(rates[:, None] * since_s[:, None] + phases[:, None]).sum(axis=0)
    qpos = 0.3 + 0.05 * waves + rng.normal(0, 1e-3, waves.shape)
    qpos[:, :3] *= 0.1
    text = viewer.page(replace(busy, qpos=qpos.astype(np.float32)))
    assert len(text.encode()) < 6_000_000
