"""Where the left fingertips are to be at every moment: down, waiting over a string, or at home."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from roboguitarist.fingering import Fingering
from roboguitarist.fretting.presses import ALONG, Press
from roboguitarist.guitar import Guitar
from roboguitarist.hands import TIP_RADIUS_M


@dataclass(frozen=True)
class Pace:
    """How the fingers move.

    Attributes:
        hover_m: Height of an idle fingertip over the strings.
        ready_m: Height of a fingertip that waits over its next place.
        early_s: A finger is down that long before the onset.
        release_s: It begins to leave that long before the end.
        drop_s, lift_s: Time to come down from the waiting height, and to go up to it.
        reach_s, reach_s_m: A finger that plays two places in a row leaves the first
            `reach_s` + `reach_s_m` x distance before the second onset.
        home_s: Idle fingers set out for their next place that long before its onset.
        ramp_s: Time in which the force is built up and taken away.
    """

    hover_m: float = 0.0277
    ready_m: float = 0.010
    early_s: float = 0.04
    release_s: float = 0.015
    drop_s: float = 0.07
    lift_s: float = 0.06
    reach_s: float = 0.09
    reach_s_m: float = 1.0
    home_s: float = 0.5
    ramp_s: float = 0.03


@dataclass(frozen=True)
class TipPlan:
    """Fingertips of fingers 1 to 4 over T samples.

    Attributes:
        position_m: (T, 4, 3) centres of the fingertips' spheres.
        grip: (T, 4) from 0 for a finger in the air to 1 for one that is down.
        force: (T, 4) share of the full force with which each presses, 0 to 1.
    """

    position_m: np.ndarray
    grip: np.ndarray
    force: np.ndarray


def tip_plan(
    presses: tuple[tuple[Press, ...], ...],
    fingering: Fingering,
    time_s: np.ndarray,
    guitar: Guitar,
    pace: Pace,
) -> TipPlan:
    """Paths of the fingertips for a timetable of presses.

    Args:
        presses: Presses of fingers 1 to 4.
        fingering: Its hold positions say where idle fingers are at home.
        time_s: (T,) sample times.
        guitar: Where strings and frets are.
        pace: How to move.
    """
    home = home_path(presses, fingering, time_s, guitar, pace.hover_m)
    tips, grip, force = [], [], []
    for finger, row in enumerate(presses):
        moments = _moments(row, guitar, pace)
        away = _away(moments, time_s, pace)
        played = _played(row, moments, time_s, guitar, pace)
        tips.append(away[:, None] * played + (1 - away[:, None]) * home[:, finger])
        grip.append(_grip(moments, time_s))
        force.append(_pressure(moments, time_s, pace))
    return TipPlan(np.stack(tips, 1), np.stack(grip, 1), np.stack(force, 1))


@dataclass(frozen=True)
class _Moment:
    """Times of one press: over the string, down, leaving, up again."""

    over_s: float
    down_s: float
    leave_s: float
    up_s: float


def turning_times(
    presses: tuple[tuple[Press, ...], ...], guitar: Guitar, pace: Pace
) -> list[float]:
    """Times at which some finger begins or ends a movement, in seconds."""
    times = set()
    for row in presses:
        for moment in _moments(row, guitar, pace):
            times |= {moment.over_s, moment.down_s, moment.leave_s, moment.up_s}
    return sorted(times)


def tip_height(guitar: Guitar) -> float:
    """Height of a fingertip's centre over the strings' axes when it touches."""
    return TIP_RADIUS_M + guitar.string_radius_m


def press_point(press: Press, guitar: Guitar) -> np.ndarray:
    """Centre (3,) of the fingertip that just touches the string there, in metres."""
    y = float(guitar.string_y(press.string, press.x_m))
    return np.array([press.x_m, y, tip_height(guitar)])


def _moments(row: tuple[Press, ...], guitar: Guitar, pace: Pace) -> list[_Moment]:
    down = [press.start_s - pace.early_s for press in row]
    leave = []
    for index, press in enumerate(row):
        leave_s = press.end_s - pace.release_s
        if index + 1 < len(row):
            way = np.linalg.norm(press_point(row[index + 1], guitar) - press_point(press, guitar))
            needed = pace.reach_s + pace.reach_s_m * float(way)
            leave_s = min(leave_s, down[index + 1] - needed)
        # Never less than half of the note, however short the time for the next.
        leave.append(max(leave_s, (press.start_s + press.end_s) / 2))
    moments = []
    for index in range(len(row)):
        before = down[index] - leave[index - 1] if index else np.inf
        after = down[index + 1] - leave[index] if index + 1 < len(row) else np.inf
        drop, lift = min(pace.drop_s, 0.4 * before), min(pace.lift_s, 0.4 * after)
        moments.append(_Moment(down[index] - drop, down[index], leave[index], leave[index] + lift))
    return moments


def _away(moments: list[_Moment], time_s: np.ndarray, pace: Pace) -> np.ndarray:
    """1 while a finger plays or waits to, 0 at home."""
    knots: list[tuple[float, float]] = [(time_s[0] - 2.0, 0.0)]
    for moment in moments:
        starts = moment.over_s - pace.home_s
        if starts > knots[-1][0]:
            knots.append((starts, 0.0))
        else:
            knots.pop()  # not worth going home
        knots += [(moment.over_s, 1.0)] if moment.over_s > knots[-1][0] else []
        knots += [(moment.up_s, 1.0), (moment.up_s + pace.home_s, 0.0)]
    knots.append((max(time_s[-1], knots[-1][0]) + 2.0, 0.0))
    times, values = zip(*knots, strict=True)
    return PchipInterpolator(times, values)(time_s)


def _played(
    row: tuple[Press, ...],
    moments: list[_Moment],
    time_s: np.ndarray,
    guitar: Guitar,
    pace: Pace,
) -> np.ndarray:
    if not row:
        return np.zeros((len(time_s), 3))
    up = np.array([0.0, 0.0, pace.ready_m])
    times, points = [], []
    for press, moment in zip(row, moments, strict=True):
        point = press_point(press, guitar)
        times += [moment.over_s, moment.down_s, moment.leave_s, moment.up_s]
        points += [point + up, point, point, point + up]
    times = [times[0] - 1.0, *times, times[-1] + 1.0]
    points = [points[0], *points, points[-1]]
    inside = np.clip(time_s, times[0], times[-1])
    return PchipInterpolator(times, points, axis=0)(inside)


def _grip(moments: list[_Moment], time_s: np.ndarray) -> np.ndarray:
    times, values = [time_s[0] - 1.0], [0.0]
    for moment in moments:
        times += [moment.over_s, moment.down_s, moment.leave_s, moment.up_s]
        values += [0.0, 1.0, 1.0, 0.0]
    return np.interp(time_s, times, values)


def _pressure(moments: list[_Moment], time_s: np.ndarray, pace: Pace) -> np.ndarray:
    times, values = [time_s[0] - 1.0], [0.0]
    for moment in moments:
        rise = min(pace.ramp_s, (moment.leave_s - moment.down_s) / 3)
        for time, value in (
            (moment.down_s - rise / 2, 0.0),
            (moment.down_s + rise / 2, 1.0),
            (moment.leave_s - rise / 2, 1.0),
            (moment.leave_s + rise / 2, 0.0),
        ):
            times.append(max(time, times[-1] + 1e-6))
            values.append(value)
    return np.interp(time_s, times, values)


def home_path(
    presses: tuple[tuple[Press, ...], ...],
    fingering: Fingering,
    time_s: np.ndarray,
    guitar: Guitar,
    hover_m: float,
) -> np.ndarray:
    """Places (T, 4, 3) of idle fingertips: over the frets of the hold position."""
    rate_hz = 1.0 / (time_s[1] - time_s[0])
    onsets = np.array([note.onset_s for note in fingering.tablature.notes] or [0.0])
    holds = fingering.hold_position if len(fingering.hold_position) else np.array([1])
    # The hand is under way to a new position in the last quarter second before it.
    index = np.clip(np.searchsorted(onsets, time_s + 0.25, side="right") - 1, 0, None)
    hold = np.asarray(holds, float)[index]
    fret = hold[:, None] + np.arange(4)
    x = guitar.fret_x(fret - 1)
    x += np.array(ALONG) * (guitar.fret_x(fret) - x)
    x = gaussian_filter1d(x, 0.08 * rate_hz, axis=0, mode="nearest")
    y = gaussian_filter1d(_side(presses, time_s, guitar), 0.15 * rate_hz, mode="nearest")
    z = np.full_like(x, tip_height(guitar) + hover_m)
    return np.stack([x, np.repeat(y[:, None], 4, axis=1), z], axis=2)


def _side(presses: tuple[tuple[Press, ...], ...], time_s: np.ndarray, guitar: Guitar) -> np.ndarray:
    """Mean y (T,) of the strings that are pressed or, between presses, last were."""
    total, count = np.zeros_like(time_s), np.zeros_like(time_s)
    for row in presses:
        for press in row:
            inside = (time_s >= press.start_s - 0.1) & (time_s < press.end_s)
            total[inside] += float(guitar.string_y(press.string, press.x_m))
            count[inside] += 1
    known = count > 0
    if not known.any():
        return np.zeros_like(time_s)
    return np.interp(time_s, time_s[known], total[known] / count[known])
