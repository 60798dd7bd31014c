from itertools import pairwise

from hypothesis import given, settings

from builders import tablatures
from roboguitarist.fingering import assign
from roboguitarist.fretting.presses import Press, find_presses
from roboguitarist.fretting.schedule import Moment, Pace, schedule
from roboguitarist.guitar import Guitar

GUITAR, PACE = Guitar(), Pace()


def moments(*presses: Press) -> list[Moment]:
    rows = tuple(tuple(p for p in presses if p.finger == finger) for finger in range(1, 5))
    timetable = schedule(rows, GUITAR, PACE)
    pairs = [
        pair
        for row, times in zip(rows, timetable.moments, strict=True)
        for pair in zip(row, times, strict=True)
    ]
    return [times for _, times in sorted(pairs, key=lambda pair: pair[0].start_s)]


def press(finger: int, fret: int, start_s: float, end_s: float, string: int = 3) -> Press:
    x_m = float(GUITAR.press_point(string, fret)[0])
    return Press(finger, string, fret, start_s, end_s, x_m, string)


def test_a_finger_is_down_before_the_onset_and_leaves_at_the_end():
    (moment,) = moments(press(1, 1, 1.0, 2.0))
    assert moment.over_s < moment.down_s == 1.0 - PACE.early_s
    assert moment.leave_s == 2.0 - PACE.release_s < moment.up_s


def test_a_finger_leaves_early_for_its_next_place_the_more_the_further():
    near, _ = moments(press(1, 1, 0.0, 1.0), press(1, 2, 1.0, 2.0))
    far, _ = moments(press(1, 1, 0.0, 1.0), press(1, 5, 1.0, 2.0))
    assert far.leave_s < near.leave_s < 1.0 - PACE.release_s


def test_fingers_in_reach_overlap_but_a_shift_is_made_way_for():
    legato, _ = moments(press(1, 1, 0.0, 1.0), press(2, 2, 1.0, 2.0))
    shift, _ = moments(press(1, 1, 0.0, 1.0), press(2, 9, 1.0, 2.0))
    assert legato.leave_s == 1.0 - PACE.release_s
    assert shift.leave_s < 1.0 - PACE.early_s - PACE.shift_s


def test_a_finger_stays_for_its_share_of_the_note():
    fast, _ = moments(press(1, 1, 0.0, 0.1), press(1, 12, 0.1, 0.2))
    assert fast.leave_s >= PACE.keep * 0.1


@settings(max_examples=60, deadline=None)
@given(tablatures())
def test_the_times_of_a_finger_increase(tablature):
    timetable = schedule(find_presses(assign(tablature), GUITAR), GUITAR, PACE)
    for row in timetable.moments:
        times = [t for m in row for t in (m.over_s, m.down_s, m.leave_s, m.up_s)]
        assert all(a < b for a, b in pairwise(times))
    assert timetable.turning_times() == sorted(set(timetable.turning_times()))
