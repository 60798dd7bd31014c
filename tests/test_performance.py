from __future__ import annotations

from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest

from roboguitarist import performance, plucking
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering, assign
from roboguitarist.fretting import planner
from roboguitarist.guitar import PRESETS
from roboguitarist.hands import VARIANTS
from roboguitarist.metrics import validate
from roboguitarist.performance import (
    CONTROLLERS,
    DEAD,
    PRESS_THRESHOLD_N,
    Performance,
    PerformConfig,
    perform,
    scene_config,
    simulate,
)
from roboguitarist.plan import LEAD_IN_S, HandPlan
from roboguitarist.scene import build
from roboguitarist.tablature import Note, Tablature

PIECE = Tablature(
    (
        Note(0.0, 6, 0, 0.5),
        Note(0.5, 3, 0, 0.5),
        Note(1.0, 2, 1, 1.0),
        Note(1.0, 5, 0, 1.0),
    ),
    title="Three open strings and a stopped one",
)
FRETTED = PIECE.notes[2]


@pytest.fixture(scope="module")
def fingering() -> Fingering:
    return assign(PIECE)


@pytest.fixture(scope="module")
def done(fingering) -> Performance:
    return perform(fingering)


def test_every_note_is_heard_as_it_was_asked(done):
    played = sorted(zip(done.pluck_string.tolist(), done.pluck_fret.tolist(), strict=True))
    assert played == [(2, 1), (3, 0), (5, 0), (6, 0)]
    order = np.argsort(done.pluck_string)
    asked = [note.onset_s for note in sorted(PIECE.notes, key=lambda note: note.string)]
    np.testing.assert_allclose(done.pluck_time_s[order], asked, rtol=0, atol=0.025)
    fingers = dict(zip(done.pluck_string.tolist(), done.pluck_finger.tolist(), strict=True))
    assert fingers == {6: 0, 5: 0, 3: 1, 2: 2}


def test_the_stopped_note_is_pressed_while_it_sounds(done):
    sounding = (done.time_s > FRETTED.onset_s) & (done.time_s < FRETTED.onset_s + 0.66)
    force_n = done.press_force_n[sounding, FRETTED.string - 1, FRETTED.fret - 1]
    assert np.all(force_n >= PRESS_THRESHOLD_N)
    assert np.all(done.sounding_fret[sounding, FRETTED.string - 1] == FRETTED.fret)
    assert not done.press_force_n[done.time_s < 0].any()
    assert np.all(done.sounding_fret[done.time_s < 0] == 0)


def test_arrays_fit_together_and_time_increases(done):
    validate(done)
    ticks, plucks = len(done.time_s), len(done.pluck_time_s)
    assert done.qpos.shape == (ticks, 51)
    assert done.press_force_n.shape == (ticks, 6, PRESETS["classical"].n_frets)
    assert done.sounding_fret.shape == (ticks, 6)
    np.testing.assert_allclose(np.diff(done.time_s), 1 / 30, atol=1e-9)
    assert np.all(np.diff(done.pluck_time_s) >= 0)
    for name in ("string", "finger", "fret", "speed_m_s", "x_m"):
        assert getattr(done, f"pluck_{name}").shape == (plucks,)
    assert done.time_s[0] < 0 < PIECE.duration_s < done.time_s[-1]
    assert np.all((done.pluck_time_s > -0.05) & (done.pluck_time_s < PIECE.duration_s))
    assert np.all((done.sounding_fret >= DEAD) & (done.sounding_fret <= 20))


def test_what_happened_is_physically_plausible(done):
    assert np.all((done.pluck_speed_m_s > 0.02) & (done.pluck_speed_m_s < 3))
    guitar = PRESETS["classical"]
    aside = np.abs(done.pluck_x_m - guitar.sound_hole_x_m)
    assert np.all(aside <= guitar.sound_hole_radius_m)
    assert np.all((done.power_w >= 0) & (done.power_w < 100))
    assert done.press_force_n.max() < 30
    assert np.abs(np.diff(done.qpos, axis=0)).max() * done.control_hz < 25


def test_the_same_again_is_the_same_to_the_last_byte(fingering, done, tmp_path):
    done.save(tmp_path / "first.npz")
    perform(fingering).save(tmp_path / "second.npz")
    assert (tmp_path / "first.npz").read_bytes() == (tmp_path / "second.npz").read_bytes()


def test_what_is_saved_is_what_is_loaded(done, tmp_path):
    done.save(tmp_path / "done.npz")
    loaded = Performance.load(tmp_path / "done.npz")
    for entry in fields(Performance):
        first, second = getattr(done, entry.name), getattr(loaded, entry.name)
        if isinstance(first, np.ndarray):
            np.testing.assert_array_equal(first, second)
            assert first.dtype == second.dtype
        else:
            assert first == second


def test_the_servos_alone_move_the_hands(fingering):
    """The joints, stepped one by one from the plans' first posture, are those recorded."""
    scene = scene_config(PerformConfig())
    left, right = planner.plan(fingering, scene), plucking.plan(fingering, scene)
    short = [HandPlan(p.time_s[:300], p.qpos[:300], p.ctrl[:300]) for p in (left, right)]
    model = build(scene)
    recording = simulate(model, short[0], short[1])
    data = mujoco.MjData(model)
    data.qpos[:] = np.hstack([plan.qpos[0] for plan in short])
    targets = np.hstack([plan.ctrl for plan in short])
    for step, ctrl in enumerate(np.repeat(targets, 2, axis=0)):
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data)
        np.testing.assert_allclose(recording.qpos[step], data.qpos, rtol=0, atol=1e-6)
    assert recording.time_s[-1] == pytest.approx(-LEAD_IN_S + 600 * model.opt.timestep)
    assert np.abs(np.ptp(recording.qpos, axis=0)).max() > 0.05


def test_a_plan_changes_only_what_comes_after(fingering):
    scene = scene_config(PerformConfig())
    left, right = planner.plan(fingering, scene), plucking.plan(fingering, scene)
    other = right.ctrl.copy()
    other[360:] += 0.1
    recordings = [simulate(build(scene), left, replace(right, ctrl=c)) for c in (right.ctrl, other)]
    before = 360 * 2
    np.testing.assert_array_equal(recordings[0].qpos[:before], recordings[1].qpos[:before])
    assert np.abs(recordings[0].qpos[before:] - recordings[1].qpos[before:]).max() > 0.01


def test_chunks_leave_no_trace(fingering, monkeypatch):
    scene = scene_config(PerformConfig())
    left, right = planner.plan(fingering, scene), plucking.plan(fingering, scene)
    whole = simulate(build(scene), left, right)
    monkeypatch.setattr(performance, "CHUNK_SAMPLES", 250)
    shares: list[float] = []
    parts = simulate(build(scene), left, right, shares.append)
    # The solver of contacts starts anew in each chunk, which shows in the seventh digit.
    np.testing.assert_allclose(whole.qpos, parts.qpos, rtol=0, atol=1e-5)
    np.testing.assert_array_equal(whole.time_s, parts.time_s)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_progress_goes_from_nothing_to_all(fingering):
    shares: list[float] = []
    faster = perform(fingering, PerformConfig(control_hz=60, seed=7), shares.append)
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    np.testing.assert_allclose(np.diff(faster.time_s), 1 / 60, atol=1e-9)
    assert (faster.control_hz, faster.seed) == (60, 7)


def test_the_control_rate_changes_nothing_that_happens(fingering, done):
    slower = perform(fingering, PerformConfig(control_hz=10))
    np.testing.assert_array_equal(slower.pluck_time_s, done.pluck_time_s)
    np.testing.assert_array_equal(slower.qpos[0], done.qpos[2])


def test_a_piece_without_notes_is_played_in_silence():
    silent = perform(assign(Tablature(())))
    assert silent.pluck_time_s.size == 0
    assert not silent.press_force_n.any()


def test_a_capo_raises_the_open_strings():
    capo = Tablature((Note(0.0, 1, 0, 0.3),), capo=2)
    played = perform(assign(capo))
    assert (played.pluck_string.tolist(), played.pluck_fret.tolist()) == ([1], [2])


@pytest.mark.parametrize("hand", VARIANTS)
@pytest.mark.parametrize("guitar", PRESETS)
def test_open_strings_are_played_with_every_hand_on_every_guitar(hand, guitar):
    strings = [6, 3, 2, 1, 4]
    piece = Tablature(tuple(Note(0.2 * k, s, 0, 0.2) for k, s in enumerate(strings)))
    played = perform(assign(piece), PerformConfig(hand=hand, guitar=guitar))
    assert played.pluck_string.tolist() == strings
    assert played.pluck_fret.tolist() == [0] * len(strings)
    onsets = [note.onset_s for note in piece.notes]
    np.testing.assert_allclose(played.pluck_time_s, onsets, rtol=0, atol=0.01)
    assert (played.hand, played.guitar) == (hand, guitar)


@pytest.mark.parametrize(
    ("setting", "names"), [("hand", VARIANTS), ("controller", CONTROLLERS), ("guitar", PRESETS)]
)
def test_an_unknown_setting_is_refused_with_the_names_there_are(fingering, setting, names):
    with pytest.raises(RoboGuitaristError) as caught:
        perform(fingering, replace(PerformConfig(), **{setting: "theremin"}))
    assert "theremin" in str(caught.value)
    assert all(name in str(caught.value) for name in names)
