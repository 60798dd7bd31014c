"""When each finger of the left hand is down, and where: the fingering as a timetable."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, groupby

import numpy as np
from scipy.optimize import minimize

from roboguitarist.fingering import Fingering
from roboguitarist.guitar import Guitar
from roboguitarist.hands import TIP_RADIUS_M

MERGE_S = 0.06
"""A finger stays down between two notes on one place that are this close."""
ALONG = (0.60, 0.65, 0.70, 0.75)
"""Where in the fret space fingers 1 to 4 press if they have room: 1 is at the sounding wire."""
TIP_GAP_M = 0.0162
"""Distance at which two fingertips that are down do not push each other aside."""
WIRE_GAP_M = 0.003
"""Distance that places of presses keep from the sounding wire."""
ROOM_GAP_M = 0.0042
"""Distance that the inverse kinematics keeps from both wires."""


@dataclass(frozen=True)
class Press:
    """A finger is down on a string.

    Attributes:
        finger: 1 to 4.
        string: 1 to 6; of a barre the one nearest the bass.
        fret: From the nut, at least 1.
        start_s, end_s: When the note or run of notes on this place sounds.
        x_m: Where the fingertip presses, distance from the nut.
        barre_to: Of a barre the string nearest the treble, else `string`.
        barre: The fingering calls it a part of a barre.
    """

    finger: int
    string: int
    fret: int
    start_s: float
    end_s: float
    x_m: float = 0.0
    barre_to: int = 0
    barre: bool = False

    @property
    def flat(self) -> bool:
        """Whether the finger lies over several strings."""
        return 0 < self.barre_to < self.string


def find_presses(fingering: Fingering, guitar: Guitar) -> tuple[tuple[Press, ...], ...]:
    """Presses of fingers 1 to 4, each in order of time and without overlaps.

    Notes that no finger can stop are left out. Fingertips that are down together are set apart
    along the strings as far as their fret spaces allow.
    """
    presses = _merge(_notes_down(fingering))
    return _spread(presses, guitar)


def _notes_down(fingering: Fingering) -> list[Press]:
    """One press for each fretted note; the notes of a barre are one press."""
    tablature, presses = fingering.tablature, {}
    for index, note in enumerate(tablature.notes):
        finger = int(fingering.left[index])
        if finger < 1:
            continue
        fret = tablature.stopped_fret(note)
        press = Press(
            finger,
            note.string,
            fret,
            note.onset_s,
            float(fingering.release_s[index]),
            barre_to=note.string,
            barre=bool(fingering.barre[index]),
        )
        key = (finger, note.onset_s)
        if press.barre and key in presses:
            press = _lay_over(presses[key], press)
        presses[key] = press
    return sorted(presses.values(), key=lambda press: (press.finger, press.start_s))


def _lay_over(barre: Press, press: Press) -> Press:
    return replace(
        barre,
        string=max(barre.string, press.string),
        barre_to=min(barre.barre_to, press.string),
        end_s=max(barre.end_s, press.end_s),
    )


def _merge(presses: list[Press]) -> list[Press]:
    """Join presses that a finger can stay for; others end where it is next needed."""
    merged: list[Press] = []
    for press in presses:
        last = merged[-1] if merged and merged[-1].finger == press.finger else None
        if last is None:
            merged.append(press)
        elif _goes_on(last, press) and press.start_s <= last.end_s + MERGE_S:
            merged[-1] = _lay_over(last, press)
        else:
            merged[-1] = replace(last, end_s=min(last.end_s, press.start_s))
            merged.append(press)
    return merged


def _goes_on(last: Press, press: Press) -> bool:
    """Whether a finger can stay where it is; a barre also for strings that join later."""
    if last.fret != press.fret:
        return False
    same = (last.string, last.barre_to) == (press.string, press.barre_to)
    return same or (last.barre and press.barre)


def _spread(presses: list[Press], guitar: Guitar) -> tuple[tuple[Press, ...], ...]:
    """Give every press its x, together with those that start with it or are still down."""
    fingers: dict[int, list[Press]] = {finger: [] for finger in range(1, 5)}
    ordered = sorted(presses, key=lambda press: press.start_s)
    for start_s, group in groupby(ordered, key=lambda press: press.start_s):
        held = [row[-1] for row in fingers.values() if row and row[-1].end_s > start_s + 1e-3]
        new = list(group)
        for press, x_m in zip(new, _places(new, held, guitar), strict=True):
            fingers[press.finger].append(replace(press, x_m=float(x_m)))
    return tuple(tuple(row) for row in fingers.values())


def _places(presses: list[Press], held: list[Press], guitar: Guitar) -> np.ndarray:
    """Distances from the nut at which new presses go down beside those that are held.

    Least squares from the favoured places; higher fingers lie nearer the bridge.
    """
    favoured = np.array(
        [guitar.press_point(p.string, p.fret, ALONG[p.finger - 1])[0] for p in presses]
    )
    low, high = _bounds(presses, guitar)
    fixed = np.array([press.x_m for press in held])
    apart = _too_close([*presses, *held], len(presses), guitar)
    if not apart:
        return favoured

    def gaps(x: np.ndarray) -> np.ndarray:
        every = np.concatenate([x, fixed])
        return np.array([sign * (every[b] - every[a]) - gap for a, b, sign, gap in apart])

    # Soft, since three fingertips do not always fit into one fret space.
    def cost(x: np.ndarray) -> float:
        return float(((x - favoured) ** 2).sum() + 30 * (np.minimum(gaps(x), 0) ** 2).sum()) * 1e6

    bounds = list(zip(low, high, strict=True))
    return minimize(cost, np.clip(favoured, low, high), bounds=bounds, method="L-BFGS-B").x


def _too_close(
    presses: list[Press], n_new: int, guitar: Guitar
) -> list[tuple[int, int, int, float]]:
    """Pairs of which one is new and whose strings are near: first, second, sign, gap along x."""
    sides = [guitar.string_y(np.array([p.string, p.barre_to or p.string]), p.x_m) for p in presses]
    pairs = []
    for first, second in combinations(range(len(presses)), 2):
        (bass, treble), (other_bass, other_treble) = sides[first], sides[second]
        across = max(0.0, float(bass - other_treble), float(other_bass - treble))
        if first < n_new and across < TIP_GAP_M:
            sign = 1 if presses[second].finger > presses[first].finger else -1
            pairs.append((first, second, sign, np.sqrt(TIP_GAP_M**2 - across**2)))
    return pairs


def _bounds(presses: list[Press], guitar: Guitar) -> tuple[np.ndarray, np.ndarray]:
    low = [float(guitar.fret_x(press.fret - 1)) + TIP_RADIUS_M for press in presses]
    high = [float(guitar.fret_x(press.fret)) - WIRE_GAP_M for press in presses]
    # High up the neck a fret space is narrower than a fingertip.
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    return np.minimum(low, middle), np.maximum(high, middle)


def tip_height(guitar: Guitar) -> float:
    """Height of a fingertip's centre over the strings' axes when it touches."""
    return TIP_RADIUS_M + guitar.string_radius_m


def press_point(press: Press, guitar: Guitar) -> np.ndarray:
    """Centre (3,) of the fingertip that just touches the string there, in metres."""
    y = float(guitar.string_y(press.string, press.x_m))
    return np.array([press.x_m, y, tip_height(guitar)])


def press_room(press: Press, guitar: Guitar) -> tuple[float, float]:
    """How far from its place a press can be along the string, towards nut (0 or less) and bridge.

    Its centre stays `ROOM_GAP_M` away from both fret wires, where the fret space is that long.
    """
    low = float(guitar.fret_x(press.fret - 1)) + ROOM_GAP_M - press.x_m
    high = float(guitar.fret_x(press.fret)) - ROOM_GAP_M - press.x_m
    return min(low, 0.0), max(high, 0.0)
