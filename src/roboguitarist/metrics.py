"""How well a tablature was played: fretting, notes, onsets, timing and motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from roboguitarist.alignment import ONSET_TOLERANCE_S, ROUNDING_S, match
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.performance import DEAD, PRESS_THRESHOLD_N, Performance
from roboguitarist.tablature import N_STRINGS, Tablature

N_SLIDES = 3
"""The left hand's first joint positions, in metres; the others are in radians."""


@dataclass(frozen=True, slots=True)
class Score:
    """Precision, recall and their harmonic mean, each in [0, 1]."""

    precision: float
    recall: float
    f1: float

    @classmethod
    def of(cls, right: int, done: int, asked: int) -> Score:
        """Score of `right` hits among `done` and `asked` ones; 0 where there were none."""
        precision = right / done if done else 0.0
        recall = right / asked if asked else 0.0
        f1 = 2 * right / (done + asked) if done + asked else 0.0
        return cls(precision, recall, f1)


@dataclass(frozen=True, slots=True)
class Timing:
    """Median and 95th percentile of the right notes' absolute onset errors in milliseconds."""

    median: float
    p95: float


@dataclass(frozen=True, slots=True)
class Motion:
    """How calmly the left hand moves.

    Attributes:
        power_w: Mean absolute mechanical power in watts.
        jerk: Mean absolute third derivative of the hinge angles in rad/s^3; None if there are
            fewer than four ticks.
    """

    power_w: float
    jerk: float | None


@dataclass(frozen=True, slots=True)
class Counts:
    """Notes asked for, plucks played, and notes that were right."""

    asked: int
    played: int
    right: int


@dataclass(frozen=True, slots=True)
class Metrics:
    """All figures of one performance; None where there is nothing to measure.

    Attributes:
        frame: Fretted cells against the tab's, over all control ticks.
        frame_free: The same, forgiving frets below a wanted fret that is held.
        note: Notes that were right.
        onset: Pitch and onset of what sounded, by mir_eval.
        timing_ms: Onset errors of the right notes.
        motion: Calmness of the left hand.
        counts: What `note` is made of.
        speed: Simulated seconds per wall second of each stage, if measured.
    """

    frame: Score | None
    frame_free: Score | None
    note: Score | None
    onset: Score | None
    timing_ms: Timing | None
    motion: Motion | None
    counts: Counts
    speed: Mapping[str, float] | None = None

    def as_dict(self) -> dict[str, Any]:
        """These figures as a JSON object; None becomes null."""
        return asdict(self)


def evaluate(
    performance: Performance,
    tablature: Tablature | None = None,
    speed: Mapping[str, float] | None = None,
) -> Metrics:
    """All metrics of a performance.

    Args:
        performance: What was done.
        tablature: What was asked; by default what the performance says.
        speed: Passed on.

    Raises:
        RoboGuitaristError: If the performance's arrays do not fit together.
    """
    tablature = tablature or performance.tablature
    validate(performance)
    pluck = match(performance, tablature)
    return Metrics(
        frame(performance, tablature),
        frame(performance, tablature, freedom=True),
        note(performance, tablature, pluck),
        onset(performance, tablature),
        timing(performance, tablature, pluck),
        motion(performance),
        Counts(len(tablature.notes), performance.pluck_time_s.size, int((pluck >= 0).sum())),
        speed,
    )


def validate(performance: Performance) -> None:
    """Check that a performance's arrays fit together.

    Raises:
        RoboGuitaristError: On a wrong shape, times that do not increase, a string out of range.
    """
    ticks, plucks = performance.time_s.size, performance.pluck_time_s.size
    fits = {
        "time_s": np.all(np.diff(performance.time_s) > 0),
        "pluck_time_s": np.all(np.diff(performance.pluck_time_s) >= 0),
        "pluck_string": np.isin(performance.pluck_string, np.arange(1, N_STRINGS + 1)).all()
        and performance.pluck_string.shape == (plucks,),
        "pluck_fret": performance.pluck_fret.shape == (plucks,),
        "press_force_n": performance.press_force_n.shape[:2] == (ticks, N_STRINGS),
        "qpos": performance.qpos.shape[:1] == (ticks,),
        "power_w": performance.power_w.shape == (ticks,),
    }
    broken = [name for name, fit in fits.items() if not fit]
    if broken:
        raise RoboGuitaristError(f"not a sound performance: {', '.join(broken)} out of order")


def frame(performance: Performance, tablature: Tablature, freedom: bool = False) -> Score | None:
    """The paper's score: fretted (string, fret) cells against the tab's, tick by tick.

    A note asks for its cell in [onset, end); open strings ask for nothing. Hits are pooled over
    the piece.

    Args:
        performance: What was done.
        tablature: What was asked.
        freedom: Do not count a fret false below a wanted fret that is held on the same string,
            since it cannot be heard.

    Returns:
        None if nothing was asked and nothing pressed, or if the piece has no notes.
    """
    asked, pressed = _cells(performance, tablature)
    held = asked & pressed
    done = pressed
    if freedom:
        above = np.flip(np.logical_or.accumulate(np.flip(held, axis=2), axis=2), axis=2)
        done = pressed & (asked | ~above)
    if not tablature.notes or not (asked.any() or pressed.any()):
        return None
    return Score.of(int(held.sum()), int(done.sum()), int(asked.sum()))


def _cells(performance: Performance, tablature: Tablature) -> tuple[np.ndarray, np.ndarray]:
    """Asked and pressed cells, both (T, 6, F) bool, F large enough for every asked fret."""
    frets = [tablature.stopped_fret(note) for note in tablature.notes]
    ticks, strings, width = performance.press_force_n.shape
    asked = np.zeros((ticks, strings, max(width, *frets, 0)), bool)
    pressed = np.zeros_like(asked)
    pressed[:, :, :width] = performance.press_force_n >= PRESS_THRESHOLD_N
    for note, fret in zip(tablature.notes, frets, strict=True):
        if fret:
            span = np.array([note.onset_s, note.end_s]) - ROUNDING_S
            start, stop = np.searchsorted(performance.time_s, span)
            asked[start:stop, note.string - 1, fret - 1] = True
    return asked, pressed


def note(
    performance: Performance, tablature: Tablature, pluck: np.ndarray | None = None
) -> Score | None:
    """Right notes among the plucks and among the notes asked; see `match`.

    Args:
        performance: What was done.
        tablature: What was asked.
        pluck: Result of `match`, if at hand.

    Returns:
        None if the piece has no notes.
    """
    if not tablature.notes:
        return None
    pluck = match(performance, tablature) if pluck is None else pluck
    right = int((pluck >= 0).sum())
    return Score.of(right, performance.pluck_time_s.size, len(tablature.notes))


def onset(performance: Performance, tablature: Tablature) -> Score | None:
    """Pitch within 50 cents and onset within 50 ms, offsets ignored, as mir_eval counts.

    Only what sounded is compared: plucks of dead strings are left out.

    Returns:
        None if the piece has no notes.
    """
    import mir_eval  # noqa: PLC0415 - slow to import, and nothing else needs it

    sounded = performance.pluck_fret != DEAD
    if not tablature.notes:
        return None
    if not sounded.any():
        return Score(0.0, 0.0, 0.0)
    tuning = np.array(tablature.tuning)[performance.pluck_string[sounded] - 1]
    asked_s = np.array([note.onset_s for note in tablature.notes])
    played_s = performance.pluck_time_s[sounded]
    start_s = min(asked_s.min(), played_s.min())  # mir_eval knows no time before 0
    precision, recall, f1, _ = mir_eval.transcription.precision_recall_f1_overlap(
        (asked_s - start_s)[:, None] + [0.0, 1.0],
        mir_eval.util.midi_to_hz(np.array([tablature.pitch(note) for note in tablature.notes])),
        (played_s - start_s)[:, None] + [0.0, 1.0],
        mir_eval.util.midi_to_hz(tuning + performance.pluck_fret[sounded]),
        onset_tolerance=ONSET_TOLERANCE_S,
        offset_ratio=None,  # pyright: ignore[reportArgumentType] - mir_eval has no types
    )
    return Score(float(precision), float(recall), float(f1))


def timing(
    performance: Performance, tablature: Tablature, pluck: np.ndarray | None = None
) -> Timing | None:
    """Onset errors of the right notes, None if there are none; arguments as for `note`."""
    pluck = match(performance, tablature) if pluck is None else pluck
    right = np.flatnonzero(pluck >= 0)
    if not right.size:
        return None
    asked_s = np.array([tablature.notes[index].onset_s for index in right])
    error_ms = 1e3 * np.abs(performance.pluck_time_s[pluck[right]] - asked_s)
    return Timing(float(np.median(error_ms)), float(np.percentile(error_ms, 95)))


def motion(performance: Performance) -> Motion | None:
    """Power and jerk of the left hand, None if there are no ticks."""
    if not performance.time_s.size:
        return None
    angles = performance.qpos[:, N_SLIDES : performance.left_nq].astype(float)
    jerk = np.abs(np.diff(angles, 3, axis=0)) * performance.control_hz**3
    return Motion(float(performance.power_w.mean()), float(jerk.mean()) if jerk.size else None)
