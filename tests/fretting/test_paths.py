import numpy as np
import pytest

from roboguitarist.fingering import assign
from roboguitarist.fretting.paths import tip_plan
from roboguitarist.fretting.presses import find_presses, press_point, tip_height
from roboguitarist.fretting.schedule import Pace, schedule
from roboguitarist.guitar import Guitar
from roboguitarist.plan import plan_times
from roboguitarist.tablature import Note, Tablature

GUITAR, PACE = Guitar(), Pace()
TUNE = Tablature(
    (
        Note(0.0, 3, 1, 0.5),
        Note(0.5, 3, 2, 0.5),
        Note(1.0, 2, 1, 0.5),
        Note(1.5, 2, 0, 2.0),
        Note(3.5, 5, 3, 0.5),
    )
)


@pytest.fixture(scope="module")
def planned():
    fingering = assign(TUNE)
    timetable = schedule(find_presses(fingering, GUITAR), GUITAR, PACE)
    time_s = plan_times(TUNE.duration_s)
    return timetable, time_s, tip_plan(timetable, fingering, time_s, GUITAR, PACE)


def test_a_pressing_fingertip_stands_still_on_its_string(planned):
    timetable, time_s, tips = planned
    for finger, (row, moments) in enumerate(zip(timetable.presses, timetable.moments, strict=True)):
        for press, moment in zip(row, moments, strict=True):
            down = (time_s >= moment.down_s) & (time_s <= moment.leave_s)
            error = tips.position_m[down, finger] - press_point(press, GUITAR)
            assert np.abs(error).max() < 1e-9
            assert np.all(tips.grip[down, finger] == 1)


def test_fingertips_never_go_below_the_strings(planned):
    _, _, tips = planned
    assert tips.position_m[..., 2].min() >= tip_height(GUITAR) - 1e-9


def test_idle_fingers_wait_over_the_frets_of_the_hold_position(planned):
    _, time_s, tips = planned
    rest = tips.position_m[(time_s > 2.5) & (time_s < 2.6)].mean(axis=0)
    assert [int(fret) for fret in GUITAR.fret_at(rest[:, 0])] == [1, 2, 3, 4]
    assert rest[:, 2] == pytest.approx(tip_height(GUITAR) + PACE.hover_m)


def test_force_is_there_during_the_note_and_gone_in_the_air(planned):
    timetable, time_s, tips = planned
    for finger, moments in enumerate(timetable.moments):
        inside = np.zeros(len(time_s), bool)
        for m in moments:
            held = (time_s > m.down_s + PACE.ramp_s) & (time_s < m.leave_s - PACE.ramp_s)
            assert np.all(tips.force[held, finger] == 1)
            inside |= (time_s > m.down_s - PACE.ramp_s) & (time_s < m.leave_s + PACE.ramp_s)
        assert np.all(tips.force[~inside, finger] == 0)


def test_fingertips_move_without_jumps(planned):
    _, time_s, tips = planned
    speed = np.abs(np.gradient(tips.position_m, time_s, axis=0))
    assert speed.max() < 2.0
