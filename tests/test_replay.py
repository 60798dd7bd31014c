from dataclasses import replace

import mujoco
import numpy as np
import pytest

from builders import idle, moving, perfect
from roboguitarist import replay
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import assign
from roboguitarist.performance import perform
from roboguitarist.tablature import Note, Tablature

NOTES = (Note(0.0, 2, 1, 0.5), Note(0.5, 4, 2, 0.5), Note(1.0, 1, 3, 0.5))
SHORT = Tablature(NOTES)


@pytest.fixture(scope="module")
def played():
    return perform(assign(SHORT))


def test_frames_begin_before_the_piece_and_end_with_hands_and_sound():
    performance = perfect(SHORT, lead_s=0.1)
    times = replay.frame_times(performance, 30)
    assert times[0] == pytest.approx(-0.1)
    assert times[-1] == pytest.approx(performance.time_s[-1], abs=1 / 15)
    assert replay.frame_times(performance, 30, 3.0)[-1] == pytest.approx(3.0, abs=1 / 15)
    early = replace(performance, time_s=performance.time_s - 2)
    assert replay.frame_times(early, 30)[0] == -replay.LEAD_S
    np.testing.assert_allclose(np.diff(times), 1 / 30)


def test_nothing_to_show_is_a_clear_error():
    with pytest.raises(RoboGuitaristError, match="no ticks"):
        replay.frame_times(replace(perfect(SHORT), time_s=np.zeros(0)), 30)


def test_sound_is_cut_or_filled_up_to_the_start():
    samples = np.arange(10.0, dtype=np.float32).repeat(2).reshape(-1, 2)
    assert replay.sound_from(0.3, samples, 10)[:, 0].tolist() == list(range(3, 10))
    assert replay.sound_from(-0.2, samples, 10)[:, 0].tolist() == [0, 0, *range(10)]


def test_postures_are_the_ticks_and_between_them_the_mean():
    performance = moving(SHORT)
    np.testing.assert_allclose(
        replay.postures(performance, performance.time_s), performance.qpos, atol=1e-6
    )
    middle = performance.time_s[:2].mean(keepdims=True)
    np.testing.assert_allclose(
        replay.postures(performance, middle)[0], performance.qpos[:2].mean(axis=0), atol=1e-6
    )
    beyond = np.array([-99.0, 99.0])
    np.testing.assert_array_equal(replay.postures(performance, beyond), performance.qpos[[0, -1]])


def test_poses_are_mujocos_own():
    performance = moving(SHORT)
    model = replay.scene(performance)
    positions, orientations = replay.body_poses(model, performance.qpos[[0, 20]])
    data = mujoco.MjData(model)
    data.qpos[:] = performance.qpos[20]
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(positions[1], data.xpos)
    np.testing.assert_allclose(orientations[1], data.xquat)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hand": "hook"}, "no hand 'hook'"),
        ({"guitar": "kazoo"}, "no guitar 'kazoo'"),
        ({"qpos": np.zeros((3, 4), np.float32)}, "joints"),
    ],
)
def test_what_does_not_fit_a_scene_is_named(change, message):
    with pytest.raises(RoboGuitaristError, match=message):
        replay.scene(replace(moving(SHORT), **change))


def test_presses_name_the_finger_that_the_fingering_chose(played):
    held = replay.presses(played)
    for note, finger in zip(SHORT.notes, played.left.tolist(), strict=True):
        (press,) = [p for p in held if (p.string, p.fret) == (note.string, note.fret)]
        assert press.finger == finger
        assert press.start_s <= note.onset_s + 0.05
        assert press.end_s >= note.onset_s + 0.3


def test_presses_are_every_pressed_tick_once(played):
    held = played.press_force_n >= 1.0
    counted = np.zeros_like(held)
    for press in replay.presses(played):
        ticks = (played.time_s >= press.start_s) & (played.time_s <= press.end_s)
        assert not counted[ticks, press.string - 1, press.fret - 1].any()
        counted[ticks, press.string - 1, press.fret - 1] = True
    np.testing.assert_array_equal(counted, held)


def test_nothing_pressed_gives_no_presses():
    still = replace(idle(SHORT), qpos=moving(SHORT).qpos)
    assert replay.presses(still) == ()
