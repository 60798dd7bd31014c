"""What N environments are to play, as arrays that they all read at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from roboguitarist import fingering
from roboguitarist.fretting.goals import Goals, goals, one_hot, simplified
from roboguitarist.fretting.task import Place, TaskConfig
from roboguitarist.guitar import Guitar
from roboguitarist.tablature import Tablature

HORIZON_S = 2.0
"""Times until something are counted up to this."""


@dataclass(frozen=True)
class Bank:
    """Goals of K tablatures, padded to T ticks.

    Attributes:
        length: (K,) ticks of each.
        capo: (K,) fret at which open strings sound.
        fret: (K, T, 6) fret to be held on each string, 0 for none.
        asked: (K, T, 6) bool, strings on which a note sounds, open ones too.
        until_onset_s: (K, T, 6) time until the string's next note begins, at most `HORIZON_S`.
        next_fret: (K, T, 6) the fret of that note.
        active: (K, T, 4) bool, fingers that have a key.
        string: (K, T, 4) string on which it is, of a barre the one nearest the bass; 0 for none.
        key_m, key_length_m: (K, T, 4, 3) and (K, T, 4) where it is, and its length.
        span: (K, T, 4) how many more strings its finger lies over, 0 unless it is a barre.
        next_key_m, next_key_length_m, next_span: The same for each finger's next key.
        left_s, until_next_s: (K, T, 4) time until the finger's key changes, and until its next
            key begins; at most `HORIZON_S`.
        hold_position: (K, T) fret at which the index finger stands.
    """

    length: np.ndarray
    capo: np.ndarray
    fret: np.ndarray
    asked: np.ndarray
    until_onset_s: np.ndarray
    next_fret: np.ndarray
    active: np.ndarray
    string: np.ndarray
    key_m: np.ndarray
    key_length_m: np.ndarray
    span: np.ndarray
    next_key_m: np.ndarray
    next_key_length_m: np.ndarray
    next_span: np.ndarray
    left_s: np.ndarray
    until_next_s: np.ndarray
    hold_position: np.ndarray

    def last(self, at: Place) -> np.ndarray:
        """(N,) bool, places beyond which the tablature has run out."""
        return at[1] >= self.length[at[0]]


def fingered(tablatures: Sequence[Tablature]) -> list[fingering.Fingering]:
    """Fingerings of all tablatures."""
    return [fingering.assign(tablature) for tablature in tablatures]


def fill(
    fingerings: Sequence[fingering.Fingering], config: TaskConfig, guitar: Guitar | None = None
) -> tuple[Bank, list[Goals]]:
    """Sample fingerings at control ticks, on the task's guitar or another."""
    guitar = guitar or config.scene().guitar
    every = [goals(one, guitar, config.control_hz, config.lead_s) for one in fingerings]
    notes = [
        _notes(one.tablature, goal.time_s) for one, goal in zip(fingerings, every, strict=True)
    ]
    bank = Bank(
        length=np.array([len(goal.fret) for goal in every]),
        capo=np.array([one.tablature.capo for one in fingerings]),
        fret=padded([goal.fret for goal in every]),
        asked=padded([asked for asked, _, _ in notes]),
        until_onset_s=padded([until for _, until, _ in notes]),
        next_fret=padded([fret for _, _, fret in notes]),
        active=padded([goal.finger_string > 0 for goal in every]),
        string=padded([goal.finger_string for goal in every]),
        key_m=padded([goal.finger_point_m for goal in every]),
        key_length_m=padded([_key_length(goal.finger_fret, guitar) for goal in every]),
        span=padded([goal.finger_span for goal in every]),
        next_span=padded([goal.next_span for goal in every]),
        next_key_m=padded([goal.next_point_m for goal in every]),
        next_key_length_m=padded([_key_length(goal.next_fret, guitar) for goal in every]),
        left_s=padded([_left_s(goal) for goal in every]),
        until_next_s=padded([np.minimum(goal.until_next_s, HORIZON_S) for goal in every]),
        hold_position=padded([goal.hold_position for goal in every]),
    )
    return bank, every


def string_goals(every: list[Goals], config: TaskConfig) -> np.ndarray:
    """The paper's string goals (K, T, size), see `Goals`."""
    n_frets, ahead = config.scene().guitar.n_frets, config.n_step_lookahead
    if config.string_goal == "one_hot":
        return padded([one_hot(goal, ahead, n_frets).astype(np.float32) for goal in every])
    return padded([simplified(goal, ahead).astype(np.float32) / n_frets for goal in every])


def padded(rows: list[np.ndarray]) -> np.ndarray:
    """Arrays (T_k, ...) of different lengths as one (K, T, ...), zeros at the ends."""
    out = np.zeros((len(rows), max(map(len, rows)), *rows[0].shape[1:]), rows[0].dtype)
    for row, values in zip(out, rows, strict=True):
        row[: len(values)] = values
    return out


def _key_length(fret: np.ndarray, guitar: Guitar) -> np.ndarray:
    fret = fret.astype(float)
    length = guitar.fret_x(fret) - guitar.fret_x(fret - 1)
    return np.where(fret > 0, length, 0.0).astype(np.float32)


def _left_s(goal: Goals) -> np.ndarray:
    """Time (T, 4) until each finger's key changes, 0 where it has none."""
    key = 32 * goal.finger_string.astype(int) + goal.finger_fret
    ticks = np.zeros(key.shape)
    for tick in range(len(key) - 2, -1, -1):
        ticks[tick] = np.where(key[tick + 1] == key[tick], ticks[tick + 1] + 1, 0)
    left = np.minimum((ticks + 1) / goal.control_hz, HORIZON_S)
    return np.where(key > 0, left, 0.0).astype(np.float32)


def _notes(tablature: Tablature, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whether a note sounds, time until the next one, its fret: (T, 6) each."""
    asked = np.zeros((len(time_s), 6), bool)
    until = np.full((len(time_s), 6), HORIZON_S, np.float32)
    fret = np.zeros((len(time_s), 6), np.int8)
    for string in range(1, 7):
        notes = [note for note in tablature.notes if note.string == string]
        if not notes:
            continue
        start = np.array([note.onset_s for note in notes])
        end = np.array([note.end_s for note in notes])
        stopped = np.array([tablature.stopped_fret(note) for note in notes])
        begun = np.searchsorted(start - 1e-6, time_s, side="right")
        asked[:, string - 1] = (begun > 0) & (time_s < end[begun - 1] - 1e-6)
        wait = np.append(start, np.inf)[begun] - time_s
        until[:, string - 1] = np.minimum(wait, HORIZON_S)
        fret[:, string - 1] = np.append(stopped, 0)[begun]
    return asked, until, fret
