"""What is asked of the left hand at every control tick: the fingering as arrays over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting.presses import Press, find_presses, tip_height
from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.tablature import Tablature

NEVER_S = 1e6
"""Time until the next press of a finger that has none left."""
ROUNDING_S = 1e-6
"""Times in a tablature are whole microseconds, those of the ticks are not."""


@dataclass(frozen=True)
class Goals:
    """What is to be held at T control ticks.

    Notes and presses last over [start, end). `fret` is what the tab asks, also of notes that no
    finger can stop or that lie beyond the neck; the fields of the fingers are what the fingering
    makes of it, so that a finger stays down in a short gap between two notes on one place.

    Attributes:
        time_s: (T,) float64, time of each tick; 0 is the start of the piece.
        fret: (T, 6) int8, fret from the nut to be held on string 1 to 6, 0 where nothing is to
            be pressed. A note ends where its string is played again.
        finger_string: (T, 4) int8, string that finger 1 to 4 presses, 0 for an idle finger; of
            a barre the string nearest the bass.
        finger_span: (T, 4) int8, how many more strings it lies over, 0 unless it is a barre.
        finger_fret: (T, 4) int8, fret from the nut that it presses, 0 for an idle finger.
        finger_point_m: (T, 4, 3) float32, where its fingertip's centre is in the middle of the
            key, see `key_centres`; zeros for an idle finger.
        next_string, next_span, next_fret, next_point_m: The same for the finger's next press
            after the one of this tick; zeros if there is none.
        until_next_s: (T, 4) float32, time until that press begins, above 0; `NEVER_S` if there
            is none.
        hold_position: (T,) int8, fret at which the index finger stands: that of the last note
            begun, before the first note its.
        control_hz: Ticks per second.
    """

    time_s: np.ndarray
    fret: np.ndarray
    finger_string: np.ndarray
    finger_span: np.ndarray
    finger_fret: np.ndarray
    finger_point_m: np.ndarray
    next_string: np.ndarray
    next_span: np.ndarray
    next_fret: np.ndarray
    next_point_m: np.ndarray
    until_next_s: np.ndarray
    hold_position: np.ndarray
    control_hz: float

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file."""
        storage.save(path, self)

    @classmethod
    def load(cls, path: str | Path) -> Goals:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        return storage.load(path, cls)


def goals(
    fingering: Fingering, guitar: Guitar, control_hz: float = 30.0, lead_s: float = 0.0
) -> Goals:
    """Sample a fingering at control ticks, until the end of the piece.

    Args:
        fingering: What is to be played, with which fingers.
        guitar: Where the frets are.
        control_hz: Ticks per second.
        lead_s: Time before the start of the piece that is sampled too, for the hand to get
            ready: tick k is at k / `control_hz` - `lead_s`.

    Returns:
        At least one tick.

    Raises:
        RoboGuitaristError: If `control_hz` is not positive or `lead_s` negative.
    """
    if not 0 < control_hz < np.inf:
        raise RoboGuitaristError(f"{control_hz:g} ticks per second (more than 0)")
    if not 0 <= lead_s < np.inf:
        raise RoboGuitaristError(f"{lead_s:g} s before the start (0 or more)")
    ticks = np.ceil((fingering.tablature.duration_s + lead_s - ROUNDING_S) * control_hz)
    time_s = np.arange(max(int(ticks), 1)) / control_hz - lead_s
    presses = find_presses(fingering, guitar)
    sampled = [_presses_at(row, time_s) for row in presses]
    string, fret, span, next_string, next_fret, next_span, until_next_s = np.stack(sampled, axis=-1)
    return Goals(
        time_s=time_s,
        fret=_asked(fingering.tablature, time_s),
        finger_string=string.astype(np.int8),
        finger_span=span.astype(np.int8),
        finger_fret=fret.astype(np.int8),
        finger_point_m=key_centres(string, fret, guitar),
        next_string=next_string.astype(np.int8),
        next_span=next_span.astype(np.int8),
        next_fret=next_fret.astype(np.int8),
        next_point_m=key_centres(next_string, next_fret, guitar),
        until_next_s=until_next_s.astype(np.float32),
        hold_position=_hold_position(fingering, time_s),
        control_hz=control_hz,
    )


def key_centres(string: np.ndarray, fret: np.ndarray, guitar: Guitar) -> np.ndarray:
    """Centres (..., 3) float32 of fingertips that touch strings in the middle of fret spaces.

    Args:
        string: (...) 1 to 6, or 0 for nowhere: zeros.
        fret: (...) from the nut, at least 1 where there is a string.
        guitar: Where strings and frets are.
    """
    x = (guitar.fret_x(fret - 1) + guitar.fret_x(fret)) / 2
    point = np.stack([x, guitar.string_y(string, x), np.full_like(x, tip_height(guitar))], axis=-1)
    return np.where(string[..., None] > 0, point, 0.0).astype(np.float32)


def simplified(goals: Goals, n_lookahead: int) -> np.ndarray:
    """String goals as frets: (T, 6 (n + 1)) int8, "String state (simplified goal)" of Table 1.

    Strings 1 to 6 of the tick itself, then of each of the next n; zeros after the end.

    Raises:
        RoboGuitaristError: If `n_lookahead` is negative.
    """
    if n_lookahead < 0:
        raise RoboGuitaristError(f"{n_lookahead} steps of lookahead (0 or more)")
    ticks = len(goals.fret)
    padded = np.pad(goals.fret, ((0, n_lookahead), (0, 0)))
    ahead = np.arange(ticks)[:, None] + np.arange(n_lookahead + 1)
    return padded[ahead].reshape(ticks, -1)


def one_hot(goals: Goals, n_lookahead: int, n_frets: int) -> np.ndarray:
    """String goals as keys: (T, 6 F (n + 1)) int8, "String state (goal)" of Table 1.

    1 for each of the F = `n_frets` keys that is to be held, in order of tick, string and fret;
    the paper has 20 frets, thus 120 (n + 1). Frets beyond have no key.

    Raises:
        RoboGuitaristError: If `n_lookahead` is negative.
    """
    fret = simplified(goals, n_lookahead)
    keys = fret[..., None] == np.arange(1, n_frets + 1)
    return keys.reshape(len(fret), -1).astype(np.int8)


def _current(start_s: np.ndarray, end_s: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Index (T,) of the span that has begun last if it lasts, else -1; starts increase."""
    last = _begun(start_s, time_s)
    lasts = time_s < np.append(end_s, -np.inf)[last] - ROUNDING_S
    return np.where(lasts, last, -1)


def _begun(start_s: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Index (T,) of the last start that is not after each time, -1 if there is none."""
    return np.searchsorted(start_s - ROUNDING_S, time_s, side="right") - 1


def _presses_at(row: tuple[Press, ...], time_s: np.ndarray) -> np.ndarray:
    """String, fret and span now, the same next, time until then: (7, T) of one finger."""
    start_s = np.array([press.start_s for press in row])
    end_s = np.array([press.end_s for press in row])
    # The last entry, which is index -1, stands for no press.
    rows = [(press.string, press.fret, press.string - press.barre_to) for press in row]
    place = np.array([*rows, (0, 0, 0)])
    now = _current(start_s, end_s, time_s)
    following = _begun(start_s, time_s) + 1
    until_s = np.append(start_s, np.inf)[following] - time_s
    return np.vstack([place[now].T, place[following].T, np.minimum(until_s, NEVER_S)])


def _asked(tablature: Tablature, time_s: np.ndarray) -> np.ndarray:
    """Frets (T, 6) int8 from the nut that the notes ask for."""
    asked = np.zeros((len(time_s), len(STRINGS)), np.int8)
    for string in STRINGS:
        notes = [note for note in tablature.notes if note.string == string]
        fret = np.array([*map(tablature.stopped_fret, notes), 0], np.int8)
        start_s = np.array([note.onset_s for note in notes])
        end_s = np.array([note.end_s for note in notes])
        asked[:, string - 1] = fret[_current(start_s, end_s, time_s)]
    return asked


def _hold_position(fingering: Fingering, time_s: np.ndarray) -> np.ndarray:
    if not fingering.hold_position.size:
        return np.ones(len(time_s), np.int8)
    start_s = np.array([note.onset_s for note in fingering.tablature.notes])
    return fingering.hold_position[np.maximum(_begun(start_s, time_s), 0)].astype(np.int8)
