"""Where the left fingertips are to be at every moment: down, waiting over a string, or at home."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from roboguitarist.fingering import Fingering
from roboguitarist.fretting.presses import ALONG, Press, press_point, press_room, tip_height
from roboguitarist.fretting.schedule import Moment, Pace, Timetable
from roboguitarist.guitar import Guitar


@dataclass(frozen=True)
class TipPlan:
    """Fingertips of fingers 1 to 4 over T samples.

    Attributes:
        position_m: (T, 4, 3) centres of the fingertips' spheres.
        grip: (T, 4) from 0 for a finger in the air to 1 for one that is down.
        force: (T, 4) share of the full force with which each presses, 0 to 1.
        flat: (T, 4) how much each lies over several strings, 0 to 1.
        room_m: (T, 4, 2) how far each may be from its position, towards the nut (0 or less) and
            towards the bridge, while it is down.
    """

    position_m: np.ndarray
    grip: np.ndarray
    force: np.ndarray
    flat: np.ndarray
    room_m: np.ndarray


def tip_plan(
    timetable: Timetable,
    fingering: Fingering,
    time_s: np.ndarray,
    guitar: Guitar,
    pace: Pace,
) -> TipPlan:
    """Paths of the fingertips for a timetable of presses.

    Args:
        timetable: Presses of fingers 1 to 4 and their times.
        fingering: Its hold positions say where idle fingers are at home.
        time_s: (T,) sample times.
        guitar: Where strings and frets are.
        pace: How to move.
    """
    home = home_path(timetable.presses, fingering, time_s, guitar, pace.hover_m)
    tips, grip, force, flat, room = [], [], [], [], []
    for finger, (row, times) in enumerate(zip(timetable.presses, timetable.moments, strict=True)):
        away = _away(times, time_s, pace)
        played = _played(row, times, time_s, guitar, pace)
        tips.append(away[:, None] * played + (1 - away[:, None]) * home[:, finger])
        grip.append(_grip(times, time_s))
        barres = tuple(m for press, m in zip(row, times, strict=True) if press.flat)
        flat.append(_grip(barres, time_s))
        force.append(_pressure(times, time_s, pace))
        room.append(grip[-1][:, None] * _room(row, times, time_s, guitar))
    columns = (np.stack(column, axis=1) for column in (tips, grip, force, flat, room))
    return TipPlan(*columns)


def _away(moments: tuple[Moment, ...], time_s: np.ndarray, pace: Pace) -> np.ndarray:
    """1 while a finger plays or waits to, 0 at home."""
    knots: list[tuple[float, float]] = [(time_s[0] - 2.0, 0.0)]
    for moment in moments:
        if moment.over_s - pace.home_s > knots[-1][0]:
            knots += [(moment.over_s - pace.home_s, 0.0), (moment.over_s, 1.0)]
        else:
            knots.pop()  # not worth going home
        knots += [(moment.up_s, 1.0), (moment.up_s + pace.home_s, 0.0)]
    knots.append((max(time_s[-1], knots[-1][0]) + 2.0, 0.0))
    times, values = zip(*knots, strict=True)
    return PchipInterpolator(times, values)(time_s)


def _played(
    row: tuple[Press, ...],
    moments: tuple[Moment, ...],
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


def _room(
    row: tuple[Press, ...], moments: tuple[Moment, ...], time_s: np.ndarray, guitar: Guitar
) -> np.ndarray:
    """Room (T, 2) along the string that each press leaves to its finger, see `press_room`."""
    room = np.zeros((len(time_s), 2))
    for press, moment in zip(row, moments, strict=True):
        room[(time_s >= moment.over_s) & (time_s <= moment.up_s)] = press_room(press, guitar)
    return room


def _grip(moments: tuple[Moment, ...], time_s: np.ndarray) -> np.ndarray:
    times, values = [time_s[0] - 1.0], [0.0]
    for moment in moments:
        times += [moment.over_s, moment.down_s, moment.leave_s, moment.up_s]
        values += [0.0, 1.0, 1.0, 0.0]
    return np.interp(time_s, times, values)


def _pressure(moments: tuple[Moment, ...], time_s: np.ndarray, pace: Pace) -> np.ndarray:
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
