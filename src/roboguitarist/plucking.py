"""The right hand's strokes: thumb on a straight line, the other fingers on an ellipse.

After section 6 of Luo et al., Learning to Play Guitar with Robotic Hands (2024). There the
ellipse is p = (0, a cos t, b sin t) with p' = T + R p; here x runs along the strings, so R is the
tilt about x alone, and T places the ellipse's lower arc on the string.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from roboguitarist.fingering import Fingering
from roboguitarist.guitar import Guitar
from roboguitarist.kinematics import Solver, TipPaths, follow
from roboguitarist.plan import PLAN_HZ, SERVO_DELAY_S, HandPlan, plan_times
from roboguitarist.scene import NAILS, SceneConfig, build
from roboguitarist.servo import servo_targets
from roboguitarist.tablature import Note

THUMB = 0
ELLIPSE_M = (0.005, 0.0025)
"""Half axes a and b (section 6)."""
TILT_RAD = -np.pi / 9
"""The stroke rises towards the bass side, out of the strings (section 6: 20 degrees)."""
LOW_TURN = (0.15, 0.65)
"""Part of the turn around the ellipse in which the fingertip's end is less than 1.1 mm above the
string's axis or below it."""
DEPTH_M = 0.0012
"""How far below the string's axis the fingertip's end crosses it."""
HALF_STROKE_S = 0.09
"""Time that a finger takes from its place over the strings to the crossing."""
THUMB_REACH_M = 0.005
THUMB_HOVER_M = 0.004
THUMB_REACH_S = 0.045
"""The thumb starts and ends its stroke that far beside the string, and as long before and after."""
THUMB_SLOPE = 0.5
"""The thumb's line rises out of the strings by this much per metre."""
UP_STROKE_COST = 0.05
"""What an up-stroke costs beside the squared speeds (m^2/s^2) that it saves."""
HOP_M = 0.02
"""Way that hopping over a string costs."""
SWEEP_S = 0.03
"""Time between two neighbouring strings that the thumb plays as one chord."""
TOGETHER_S = 0.002
"""Onsets of one finger this close are one stroke."""
PLUCK_X_M = (-0.029, -0.011, 0.011, 0.032)
"""Where p, i, m, a pluck, measured from the centre of the sound hole towards the bridge."""
SOLVE_EVERY = 2
"""Inverse kinematics is solved at every second sample and interpolated between."""

REST_RAD = {
    "THJ5": -0.35, "THJ4": 0.82, "THJ3": 0.1, "THJ2": 0.4, "THJ1": 0.9,
    **{f"{f}J{j}": v for f in ("FF", "MF", "RF") for j, v in ((3, 0.72), (2, 0.85), (1, 0.85))},
    "LFJ3": 0.5, "LFJ2": 0.8, "LFJ1": 0.8, "WRJ1": 0.03, "WRJ2": -0.104,
}  # fmt: skip


@dataclass(frozen=True)
class Stroke:
    """One movement of a finger through one string or, for the thumb, several.

    Attributes:
        finger: 0 to 3 for p, i, m, a.
        time_s: When it crosses the string, or the middle of the strings.
        strings: In the order in which they are crossed.
    """

    finger: int
    time_s: float
    strings: tuple[int, ...]


def plan(fingering: Fingering, config: SceneConfig | None = None) -> HandPlan:
    """Plan the right hand's motion for a piece.

    Args:
        fingering: Who plucks what and when.
        config: The scene; only its guitar, hand and time step matter.

    Returns:
        The motion, with servo targets for the right hand.
    """
    config = config or SceneConfig()
    guitar = config.guitar
    strokes = find_strokes(fingering)
    time_s = plan_times(fingering.tablature.duration_s)
    coarse = time_s[::SOLVE_EVERY]
    model = right_hand(config)
    rest = rest_posture(model)
    ahead = coarse + SERVO_DELAY_S
    tips = np.stack([tip_path(f, strokes[f], ahead, guitar) for f in range(4)], axis=1)
    solver = Solver(model, NAILS, _posture_cost(model))
    paths = TipPaths(tips, np.full(tips.shape[:2], 100.0), np.tile(rest, (len(coarse), 1)))
    qpos = CubicSpline(coarse, follow(solver, paths), axis=0)(np.minimum(time_s, coarse[-1]))
    return HandPlan(time_s, qpos, servo_targets(model, qpos, PLAN_HZ))


def find_strokes(fingering: Fingering) -> tuple[tuple[Stroke, ...], ...]:
    """The strokes of p, i, m and a, each in order of time.

    Notes of one finger with one onset are one stroke, from the bass to the treble side.
    """
    strokes = []
    for finger in range(4):
        groups: list[list[Note]] = []
        for note, right in zip(fingering.tablature.notes, fingering.right, strict=True):
            if right != finger:
                continue
            if not groups or note.onset_s - groups[-1][0].onset_s > TOGETHER_S:
                groups.append([])
            groups[-1].append(note)
        strokes.append(
            tuple(
                Stroke(finger, group[0].onset_s, tuple(sorted({n.string for n in group})[::-1]))
                for group in groups
            )
        )
    return tuple(strokes)


def right_hand(config: SceneConfig) -> mujoco.MjModel:
    """Model of the right hand alone, for planning."""
    return build(
        SceneConfig(config.guitar, config.hand, ("right",), config.timestep_s, visuals=False)
    )


def rest_posture(model: mujoco.MjModel) -> np.ndarray:
    """Joint positions (nq,) of the right hand with every finger over its string."""
    rest = np.zeros(model.nq)
    for name, value in REST_RAD.items():
        rest[model.joint(f"rh_{name}").qposadr[0]] = value
    return rest


def _posture_cost(model: mujoco.MjModel) -> np.ndarray:
    cost = np.full(model.nv, 0.03)
    for name in ("WRJ1", "WRJ2", "LFJ5", "LFJ4", "LFJ3", "LFJ2", "LFJ1"):
        cost[model.joint(f"rh_{name}").dofadr[0]] = 30.0
    # The index finger's way reaches 1.4 mm beyond its range: there it would flip without a pull.
    cost[model.joint("rh_FFJ4").dofadr[0]] = 0.3
    return cost


def tip_path(
    finger: int, strokes: tuple[Stroke, ...], time_s: np.ndarray, guitar: Guitar
) -> np.ndarray:
    """Positions (T, 3) in metres of a finger's end, over `time_s`.

    Args:
        finger: 0 to 3 for p, i, m, a.
        strokes: What it plays.
        time_s: (T,) sample times.
        guitar: Where the strings are.
    """
    x = guitar.sound_hole_x_m + PLUCK_X_M[finger]
    across = _thumb_path if finger == THUMB else _finger_path
    y, z = across(strokes, time_s, x, guitar, finger)
    return np.column_stack([np.full_like(y, x), y, z])


def _finger_path(
    strokes: tuple[Stroke, ...], time_s: np.ndarray, x: float, guitar: Guitar, finger: int
) -> tuple[np.ndarray, np.ndarray]:
    """Once around the ellipse for each stroke, half a turn before the crossing."""
    knots, turns = [time_s[0] - 1.0], [0.0]
    for index, stroke in enumerate(strokes):
        before = _room(strokes, index - 1, index)
        after = _room(strokes, index, index + 1)
        knots += [stroke.time_s - before, stroke.time_s, stroke.time_s + after]
        turns += [index, index + 0.5, index + 1.0]
    knots.append(max(time_s[-1], knots[-1]) + 1.0)
    turns.append(turns[-1])
    turn = PchipInterpolator(*_increasing(knots, turns))(time_s)
    a, b = ELLIPSE_M
    # From the top (angle pi / 2) over the treble side to the bottom, as turn goes 0 to 1 / 2.
    angle = np.pi / 2 - 2 * np.pi * turn
    cos, sin = np.cos(TILT_RAD), np.sin(TILT_RAD)
    y = a * np.cos(angle) * cos - b * np.sin(angle) * sin
    z = a * np.cos(angle) * sin + b * np.sin(angle) * cos
    bottom_y, bottom_z = b * sin, -b * cos
    return y + _string_path(strokes, turn, x, guitar, finger) - bottom_y, z - DEPTH_M - bottom_z


def _string_path(
    strokes: tuple[Stroke, ...], turn: np.ndarray, x: float, guitar: Guitar, finger: int
) -> np.ndarray:
    """Sideways place (T,) of the string in play, changed only while the finger is above it."""
    if not strokes:
        return np.full_like(turn, guitar.string_y(4 - finger, x))
    turns = np.add.outer(np.arange(len(strokes)), LOW_TURN).ravel()
    strings = np.repeat([stroke.strings[0] for stroke in strokes], 2)
    path = PchipInterpolator(turns, guitar.string_y(strings, x))
    return path(np.clip(turn, turns[0], turns[-1]))


def _room(strokes: tuple[Stroke, ...], first: int, second: int) -> float:
    if first < 0 or second >= len(strokes):
        return HALF_STROKE_S
    return min(HALF_STROKE_S, (strokes[second].time_s - strokes[first].time_s) / 2)


def _increasing(knots: list[float], values: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Knots without the duplicates that strokes following at once leave."""
    pairs = [(knots[0], values[0])]
    for knot, value in zip(knots[1:], values[1:], strict=True):
        if knot > pairs[-1][0] + 1e-6:
            pairs.append((knot, value))
    times, kept = zip(*pairs, strict=True)
    return np.array(times), np.array(kept)


def _thumb_path(
    strokes: tuple[Stroke, ...], time_s: np.ndarray, x: float, guitar: Guitar, finger: int
) -> tuple[np.ndarray, np.ndarray]:
    """Through the strings on straight lines, over them in between."""
    strings_y = guitar.string_y(np.arange(1, 7), x)
    points = [(time_s[0] - 1.0, strings_y[4] + THUMB_REACH_M, THUMB_HOVER_M)]
    for index, (stroke, down) in enumerate(
        zip(strokes, thumb_directions(strokes, strings_y), strict=True)
    ):
        passage = _thumb_stroke(stroke, strings_y, down, _reaches(strokes, index))
        points += [*_thumb_transfer(points[-1], passage[0], strings_y), *passage]
    last_s, last_y, _ = points[-1]
    points.append((last_s + 0.06, last_y, THUMB_HOVER_M))
    points.append((max(time_s[-1], last_s) + 1.0, last_y, THUMB_HOVER_M))
    times, y, z = (np.array(column) for column in zip(*points, strict=True))
    return PchipInterpolator(times, y)(time_s), PchipInterpolator(times, z)(time_s)


def thumb_directions(strokes: tuple[Stroke, ...], strings_y: np.ndarray) -> list[bool]:
    """Which thumb strokes go down, towards the treble side; the others go up (alzapua).

    Down is the rule. Up-strokes come where notes follow so fast that bringing the thumb back
    would cost too much speed: the choice with the least sum of squared speeds, by dynamic
    programming.

    Args:
        strokes: The thumb's strokes in order of time.
        strings_y: (6,) positions of strings 1 to 6 in metres.
    """
    up = [UP_STROKE_COST * len(stroke.strings) ** 2 for stroke in strokes]
    cost, came_from = np.array([0.0, *up[:1]]), []
    for index in range(1, len(strokes)):
        gap_s = _gap(strokes, index - 1, index)
        step = np.empty((2, 2))
        for before, after in np.ndindex(2, 2):
            exit_y = strings_y[_crossed(strokes[index - 1], before == 0)[-1] - 1]
            entry_y = strings_y[_crossed(strokes[index], after == 0)[0] - 1]
            exit_y += THUMB_REACH_M * (1 if before == 0 else -1)
            entry_y -= THUMB_REACH_M * (1 if after == 0 else -1)
            hop_m = HOP_M * _strings_between(exit_y, entry_y, strings_y)
            speed = (abs(entry_y - exit_y) + hop_m) / gap_s
            step[before, after] = cost[before] + speed**2 + after * up[index]
        came_from.append(step.argmin(axis=0))
        cost = step.min(axis=0)
    choice = [int(cost.argmin())]
    for previous in reversed(came_from):
        choice.append(int(previous[choice[-1]]))
    return [direction == 0 for direction in reversed(choice[-len(strokes) :] if strokes else [])]


def _crossed(stroke: Stroke, down: bool) -> tuple[int, ...]:
    return stroke.strings if down else stroke.strings[::-1]


def _strings_between(first_y: float, second_y: float, strings_y: np.ndarray) -> int:
    low, high = sorted((first_y, second_y))
    return int(((strings_y > low) & (strings_y < high)).sum())


def _gap(strokes: tuple[Stroke, ...], first: int, second: int) -> float:
    """Time between two strokes, infinite beyond the first and the last."""
    if first < 0 or second >= len(strokes):
        return np.inf
    return strokes[second].time_s - strokes[first].time_s


def _reaches(strokes: tuple[Stroke, ...], index: int) -> tuple[float, float]:
    """Times from the start of a thumb stroke to its string, and from there to its end."""
    times = []
    for other, (first, second) in (
        (index - 1, (index - 1, index)),
        (index + 1, (index, index + 1)),
    ):
        gap_s = _gap(strokes, first, second)
        # On one string nothing has to be crossed between two strokes.
        same = gap_s < np.inf and strokes[other].strings == strokes[index].strings
        share = (0.4 if same else 0.2) / len(strokes[index].strings)
        times.append(min(THUMB_REACH_S, share * gap_s))
    return times[0], times[1]


def _thumb_stroke(
    stroke: Stroke, strings_y: np.ndarray, down: bool, reaches_s: tuple[float, float]
) -> list[tuple[float, float, float]]:
    """Points (time, y, z) of one stroke, towards the treble side if `down`."""
    sign, strings = (1 if down else -1), _crossed(stroke, down)
    before_s, after_s = reaches_s
    before_m, after_m = (
        sign * THUMB_REACH_M * max(0.5, reach_s / THUMB_REACH_S) for reach_s in reaches_s
    )
    sweep_s = min(SWEEP_S, *reaches_s)
    steps = range(strings[0], strings[-1] - sign, -sign)
    times = stroke.time_s + sweep_s * (np.arange(len(steps)) - (len(steps) - 1) / 2)
    start_y, end_y = strings_y[strings[0] - 1] - before_m, strings_y[strings[-1] - 1] + after_m
    points = [(times[0] - before_s, start_y, -DEPTH_M - THUMB_SLOPE * abs(before_m))]
    for time_s, string in zip(times, steps, strict=True):
        z = -DEPTH_M if string in strings else THUMB_HOVER_M / 2
        points.append((time_s, strings_y[string - 1], z))
    points.append((times[-1] + after_s, end_y, THUMB_SLOPE * abs(after_m) - DEPTH_M))
    return points


def _thumb_transfer(
    start: tuple[float, float, float], end: tuple[float, float, float], strings_y: np.ndarray
) -> list[tuple[float, float, float]]:
    """Points between two strokes: over the strings, or none if no string lies between."""
    (start_s, start_y, _), (end_s, end_y, _) = start, end
    step_s = min(0.06, (end_s - start_s) / 4)
    if step_s < 0.0225 and not _strings_between(start_y, end_y, strings_y):
        return []
    # The way across begins while the thumb still rises: less than half the way to a string.
    lead_m = 0.1 * (end_y - start_y)
    return [
        (start_s + step_s, start_y + lead_m, THUMB_HOVER_M),
        (end_s - step_s, end_y - lead_m, THUMB_HOVER_M),
    ]
