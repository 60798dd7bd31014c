from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from builders import idle, perfect, tablatures, with_pluck, without_plucks
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.metrics import Score, evaluate, frame, motion, note, onset, validate
from roboguitarist.performance import DEAD, Performance
from roboguitarist.tablature import Note, Tablature

PERFECT, NOTHING = Score(1, 1, 1), Score(0, 0, 0)
FOUR = Tablature(
    (
        Note(0.0, 5, 3, 0.4),
        Note(0.4, 4, 2, 0.4),
        Note(0.8, 2, 0, 0.4),
        Note(0.8, 3, 2, 0.4),
    )
)


def pressing(
    performance: Performance, string: int, fret: int, start_s: float, end_s: float
) -> Performance:
    force_n = performance.press_force_n.copy()
    ticks = (performance.time_s >= start_s - 1e-6) & (performance.time_s < end_s - 1e-6)
    force_n[ticks, string - 1, fret - 1] = 2.0
    return replace(performance, press_force_n=force_n)


def test_four_notes_by_hand():
    # 20 ticks a second: the three fretted notes ask for eight ticks each.
    performance = perfect(FOUR, control_hz=20)
    force_n = performance.press_force_n.copy()
    force_n[performance.time_s < 0.1 - 1e-6, 4, 2] = 0  # string 5 comes two ticks late
    force_n[:, 3, 1] = 0.99  # string 4 is pressed too lightly
    fret = performance.pluck_fret.copy()
    fret[1] = DEAD
    time_s = performance.pluck_time_s + np.array([0.02, 0.0, 0.0, 0.04])
    played = replace(performance, press_force_n=force_n, pluck_fret=fret, pluck_time_s=time_s)
    played = pressing(played, 1, 5, 0.0, 0.1)  # and two ticks on a string nobody asked for
    metrics = evaluate(played)
    assert metrics.frame == Score(14 / 16, 14 / 24, 2 * 14 / (16 + 24))
    assert metrics.frame_free == metrics.frame
    # Wrong are string 4, dead, and string 5, which was not down when plucked at 20 ms.
    assert metrics.note == Score(2 / 4, 2 / 4, 2 / 4)
    assert metrics.onset is not None
    assert astuple(metrics.onset) == pytest.approx((3 / 3, 3 / 4, 6 / 7))
    assert metrics.timing_ms is not None
    assert metrics.timing_ms.median == pytest.approx(20)
    assert metrics.timing_ms.p95 == pytest.approx(38)
    assert (metrics.counts.asked, metrics.counts.played, metrics.counts.right) == (4, 4, 2)


def test_a_performance_is_measured_against_another_tablature():
    other = replace(FOUR, notes=FOUR.notes[:2])
    metrics = evaluate(perfect(FOUR), other)
    assert metrics.note == Score(2 / 4, 1, 2 * 2 / (4 + 2))


@given(tablatures(min_notes=1))
def test_perfect_is_one(tablature: Tablature):
    metrics = evaluate(perfect(tablature))
    fretted = any(item.fret for item in tablature.notes)
    assert metrics.frame == metrics.frame_free == (PERFECT if fretted else None)
    assert metrics.note == metrics.onset == PERFECT
    assert metrics.timing_ms is not None
    assert metrics.timing_ms.p95 == pytest.approx(0)
    assert metrics.motion is not None
    assert metrics.motion.jerk == 0


@given(tablatures(min_notes=1))
def test_doing_nothing_is_zero(tablature: Tablature):
    metrics = evaluate(idle(tablature))
    fretted = any(item.fret for item in tablature.notes)
    assert metrics.frame == metrics.frame_free == (NOTHING if fretted else None)
    assert metrics.note == metrics.onset == NOTHING
    assert metrics.timing_ms is None


def test_no_notes_no_score():
    noisy = with_pluck(perfect(Tablature(())), 0.1, 2, 0)
    played = pressing(noisy, 1, 1, 0.0, 0.2).press_force_n
    metrics = evaluate(replace(noisy, press_force_n=played)).as_dict()
    assert [metrics[key] for key in ("frame", "frame_free", "note", "onset", "timing_ms")] == (
        [None] * 5
    )
    assert metrics["counts"] == {"asked": 0, "played": 1, "right": 0}


@given(tablatures(min_notes=1), st.integers(1, 6), st.floats(0, 3), st.integers(0, 12), st.data())
def test_a_false_pluck_never_helps(
    tablature: Tablature, string: int, time_s: float, fret: int, data: st.DataObject
):
    count = len(tablature.notes)
    drop = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    before = without_plucks(perfect(tablature), drop)
    free = [abs(n.onset_s - time_s) > 0.051 for n in tablature.notes if n.string == string]
    if not all(free):
        return
    old, new = evaluate(before), evaluate(with_pluck(before, time_s, string, fret))
    assert old.note is not None
    assert new.note is not None
    assert new.note.precision <= old.note.precision
    assert new.note.f1 <= old.note.f1
    for score in (new.frame, new.frame_free, new.note, new.onset):
        assert score is None or all(
            0 <= value <= 1 for value in (score.precision, score.recall, score.f1)
        )


@given(tablatures(min_notes=1))
def test_a_frame_score_is_the_harmonic_mean(tablature: Tablature):
    score = frame(pressing(perfect(tablature), 1, 13, 0.0, 1.0), tablature)
    assert score is not None
    if score.precision + score.recall:
        mean = 2 * score.precision * score.recall / (score.precision + score.recall)
        assert score.f1 == pytest.approx(mean)


@given(tablatures(min_notes=1), st.data())
def test_note_agrees_with_mir_eval_on_open_strings(tablature: Tablature, data: st.DataObject):
    tablature = replace(tablature, notes=tuple(replace(n, fret=0) for n in tablature.notes))
    errors_ms = st.integers(-70, 70).filter(lambda error: abs(error) != 50)
    count = len(tablature.notes)
    errors = data.draw(st.lists(errors_ms, min_size=count, max_size=count))
    played = perfect(tablature)
    time_s = np.add(played.pluck_time_s, np.divide(errors, 1000))
    order = np.argsort(time_s)
    played = replace(
        played,
        pluck_time_s=time_s[order],
        pluck_string=played.pluck_string[order],
        pluck_fret=played.pluck_fret[order],
    )
    ours, theirs = note(played, tablature), onset(played, tablature)
    assert ours is not None
    assert theirs is not None
    assert ours.f1 == pytest.approx(theirs.f1)


@pytest.mark.parametrize(
    ("late_s", "right"), [(0.0, 1), (0.05, 1), (-0.05, 1), (0.0502, 0), (-0.0502, 0)]
)
def test_a_note_may_be_fifty_milliseconds_off(late_s: float, right: int):
    tablature = Tablature((Note(1.0, 2, 0, 1.0),))
    played = replace(perfect(tablature), pluck_time_s=np.array([1.0 + late_s]))
    assert evaluate(played).counts.right == right


@pytest.mark.parametrize(("held_s", "right"), [(0.5, 0), (0.66, 0), (0.7, 1), (1.0, 1)])
def test_a_note_is_held_two_thirds(held_s: float, right: int):
    tablature = Tablature((Note(0.0, 2, 3, 1.0),))
    played = perfect(tablature, control_hz=100)
    force_n = np.zeros_like(played.press_force_n)
    played = pressing(replace(played, press_force_n=force_n), 2, 3, -0.1, held_s)
    assert evaluate(played).counts.right == right


def test_a_note_is_held_until_its_string_is_plucked_again():
    tablature = Tablature((Note(0.0, 2, 3, 1.0), Note(0.4, 2, 0, 0.5)))
    played = perfect(tablature)
    force_n = np.zeros_like(played.press_force_n)
    played = replace(played, press_force_n=force_n)
    assert evaluate(pressing(played, 2, 3, -0.1, 0.4)).counts.right == 2
    assert evaluate(pressing(played, 2, 3, -0.1, 0.3)).counts.right == 1


def test_a_finger_that_lifts_for_a_moment_does_not_hold():
    tablature = Tablature((Note(0.0, 2, 3, 1.0),))
    played = perfect(tablature)
    force_n = played.press_force_n.copy()
    force_n[np.searchsorted(played.time_s, 0.3), 1, 2] = 0
    assert note(replace(played, press_force_n=force_n), tablature) == NOTHING


def test_freedom_forgives_lower_frets_of_a_held_string_only():
    tablature = Tablature((Note(0.0, 2, 5, 1.0), Note(0.0, 3, 0, 1.0)))
    played = perfect(tablature, control_hz=10)
    below = pressing(played, 2, 3, 0.0, 1.0)
    assert frame(below, tablature) == Score(1 / 2, 1, 2 / 3)
    assert frame(below, tablature, freedom=True) == PERFECT
    above = pressing(played, 2, 6, 0.0, 1.0)
    assert frame(above, tablature, freedom=True) == Score(1 / 2, 1, 2 / 3)
    elsewhere = pressing(played, 3, 1, 0.0, 1.0)
    assert frame(elsewhere, tablature, freedom=True) == Score(1 / 2, 1, 2 / 3)
    late = pressing(played, 2, 3, 0.0, 1.0)
    late.press_force_n[:, 1, 4] = 0
    assert frame(late, tablature, freedom=True) == NOTHING


def test_frames_are_half_open():
    tablature = Tablature((Note(0.0, 2, 3, 0.5), Note(0.5, 2, 4, 0.5)))
    assert frame(perfect(tablature, control_hz=10), tablature) == PERFECT
    late = pressing(perfect(tablature, control_hz=10), 2, 3, 0.5, 0.6)
    assert frame(late, tablature) == Score(10 / 11, 1, 20 / 21)


def test_frets_beyond_the_sensors_are_missed():
    tablature = Tablature((Note(0.0, 2, 3, 1.0),))
    played = perfect(tablature)
    played = replace(played, press_force_n=played.press_force_n[:, :, :2])
    metrics = evaluate(played)
    assert metrics.frame == NOTHING
    assert metrics.note == NOTHING


def test_jerk_of_a_cubic_is_constant():
    played = perfect(FOUR)
    angle = 0.5 * played.time_s**3  # third derivative 3 rad/s^3
    qpos = np.zeros_like(played.qpos, dtype=float)
    qpos[:, 3:27] = angle[:, None]
    qpos[:, :3] = qpos[:, 27:] = 100 * angle[:, None]  # slides and right hand do not count
    power_w = np.linspace(0, 2, played.time_s.size)
    result = motion(replace(played, qpos=qpos, power_w=power_w))
    assert result is not None
    assert result.jerk == pytest.approx(3.0)
    assert result.power_w == pytest.approx(1.0)


def test_the_json_has_the_documented_keys():
    metrics = evaluate(perfect(FOUR), speed={"physics": 3.0}).as_dict()
    assert set(metrics) == (
        {"frame", "frame_free", "note", "onset", "timing_ms", "motion", "counts", "speed"}
    )
    assert set(metrics["note"]) == {"precision", "recall", "f1"}
    assert set(metrics["timing_ms"]) == {"median", "p95"}
    assert set(metrics["motion"]) == {"power_w", "jerk"}
    assert metrics["speed"] == {"physics": 3.0}


def test_arrays_that_do_not_fit_are_named():
    with pytest.raises(RoboGuitaristError, match="pluck_string"):
        validate(replace(perfect(FOUR), pluck_string=np.array([7, 1, 1, 1])))
    with pytest.raises(RoboGuitaristError, match="press_force_n"):
        validate(replace(perfect(FOUR), time_s=np.arange(3.0)))
