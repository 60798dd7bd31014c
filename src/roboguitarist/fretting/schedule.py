"""When each finger of the left hand comes down and leaves, so that the others can follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.fretting.presses import Press, press_point
from roboguitarist.guitar import Guitar
from roboguitarist.hands import KNUCKLE_GAP_M

TOUCHING_S = 0.1
"""Presses that follow each other within this time compete for the hand's place."""

LEAST_S = 0.01
"""Shortest time that a finger is down, and that it takes from one place to the next."""


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
        span_m: Two fingers can be down together if the distance between their places differs
            by no more than this from that between their knuckles.
        shift_s: If not, the first leaves `shift_s` + `reach_s_m` x excess before the second
            is down, since the hand has to move.
        keep: Share of a note for which its finger stays in any case.
        home_s: Idle fingers set out for their next place that long before its onset.
        ramp_s: Time in which the force is built up and taken away.
    """

    hover_m: float = 0.0277
    ready_m: float = 0.010
    early_s: float = 0.0479
    release_s: float = 0.03
    drop_s: float = 0.07
    lift_s: float = 0.0657
    reach_s: float = 0.07
    reach_s_m: float = 1.12
    span_m: float = 0.0314
    shift_s: float = 0.06
    keep: float = 0.68
    home_s: float = 0.5
    ramp_s: float = 0.0226


@dataclass(frozen=True)
class Moment:
    """Times of one press in seconds: over the string, down, leaving, up again."""

    over_s: float
    down_s: float
    leave_s: float
    up_s: float


@dataclass(frozen=True)
class Timetable:
    """Presses of fingers 1 to 4 and the moments of each, in order of time."""

    presses: tuple[tuple[Press, ...], ...]
    moments: tuple[tuple[Moment, ...], ...]

    def turning_times(self) -> list[float]:
        """Times at which some finger begins or ends a movement, in seconds."""
        moments = [moment for row in self.moments for moment in row]
        return sorted({time for m in moments for time in (m.over_s, m.down_s, m.leave_s, m.up_s)})


def schedule(presses: tuple[tuple[Press, ...], ...], guitar: Guitar, pace: Pace) -> Timetable:
    """Find the times of all presses of fingers 1 to 4.

    A finger leaves before its note ends where it is needed elsewhere, or where the hand must
    move on for another finger.
    """
    everyone = sorted((press for row in presses for press in row), key=lambda p: p.start_s)
    starts = np.array([press.start_s for press in everyone])
    rows = []
    for row in presses:
        leave = []
        for index, press in enumerate(row):
            leave_s = press.end_s - pace.release_s
            if index + 1 < len(row):
                leave_s = min(leave_s, _before_next(press, row[index + 1], guitar, pace))
            first, last = np.searchsorted(
                starts, [press.end_s - TOUCHING_S, press.end_s + TOUCHING_S]
            )
            for other in everyone[first:last]:
                if other.finger != press.finger and other.start_s > press.start_s:
                    leave_s = min(leave_s, _before_shift(press, other, pace))
            kept_s = press.start_s + pace.keep * (press.end_s - press.start_s)
            leave.append(max(leave_s, kept_s))
        rows.append(_moments(row, leave, pace))
    return Timetable(presses, tuple(rows))


def _before_next(press: Press, following: Press, guitar: Guitar, pace: Pace) -> float:
    way_m = float(np.linalg.norm(press_point(following, guitar) - press_point(press, guitar)))
    return following.start_s - pace.early_s - pace.reach_s - pace.reach_s_m * way_m


def _before_shift(press: Press, other: Press, pace: Pace) -> float:
    knuckles_m = KNUCKLE_GAP_M * (other.finger - press.finger)
    excess_m = abs(other.x_m - press.x_m - knuckles_m) - pace.span_m
    if excess_m <= 0:
        return np.inf
    return other.start_s - pace.early_s - pace.shift_s - pace.reach_s_m * excess_m


def _moments(row: tuple[Press, ...], leave: list[float], pace: Pace) -> tuple[Moment, ...]:
    """Times of a finger's presses, however fast they follow each other."""
    down: list[float] = []
    for index, press in enumerate(row):
        ready_s = leave[index - 1] + LEAST_S if index else -np.inf
        down.append(max(press.start_s - pace.early_s, ready_s))
        leave[index] = max(leave[index], down[index] + LEAST_S)
    moments = []
    for index in range(len(row)):
        before = down[index] - leave[index - 1] if index else np.inf
        after = down[index + 1] - leave[index] if index + 1 < len(row) else np.inf
        drop, lift = min(pace.drop_s, 0.4 * before), min(pace.lift_s, 0.4 * after)
        moments.append(Moment(down[index] - drop, down[index], leave[index], leave[index] + lift))
    return tuple(moments)
