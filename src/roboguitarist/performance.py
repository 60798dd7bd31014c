"""What the physics did: joint paths, press forces and plucks as they happened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from roboguitarist import storage
from roboguitarist.tablature import Tablature

PRESS_THRESHOLD_N = 1.0
"""Normal force from which a string is fretted (the seed's training value)."""
DEAD = -1
"""Sounding fret of a string that is touched but not fretted."""


@dataclass(frozen=True)
class Performance:
    """One playing of a tablature, sampled at T control ticks, with P plucks.

    Strings are indexed 0 to 5 for string 1 (high E) to 6. Frets count from the nut, as on the
    neck: a capo at fret 2 makes an open string sound fret 2.

    Attributes:
        tablature: What was asked.
        left, right: (n,) int8, the fingers that were to play each note (see `Fingering`).
        time_s: (T,) float64, time of each tick; 0 is the start of the piece, the hands may
            begin to move before it.
        qpos: (T, nq) float32, MuJoCo generalised positions: the left hand's first, its three
            slides in metres, then its hinges in radians.
        press_force_n: (T, 6, F) float32, normal force in each fret space; [:, s, f - 1] is
            string s + 1 pressed behind fret f.
        sounding_fret: (T, 6) int8, fret that each string would sound if plucked, `DEAD` if it
            is touched but not fretted.
        pluck_time_s: (P,) float64, increasing.
        pluck_string: (P,) int8, 1 to 6.
        pluck_finger: (P,) int8, 0 to 3 for p, i, m, a.
        pluck_fret: (P,) int8, what sounded: a fret from 0 or `DEAD`.
        pluck_speed_m_s: (P,) float32, speed of the fingertip as it crossed the string.
        pluck_x_m: (P,) float32, distance from the nut of the point plucked.
        power_w: (T,) float32, mean absolute mechanical power of the left hand since the last
            tick.
        hand: Hand variant, `linkage` or `tendon`.
        guitar: Name of the guitar preset.
        controller: What drove the left hand.
        control_hz: Ticks per second.
        seed: Seed of the run.
        left_nq: Number of columns of `qpos` that are the left hand's.
    """

    tablature: Tablature
    left: np.ndarray
    right: np.ndarray
    time_s: np.ndarray
    qpos: np.ndarray
    press_force_n: np.ndarray
    sounding_fret: np.ndarray
    pluck_time_s: np.ndarray
    pluck_string: np.ndarray
    pluck_finger: np.ndarray
    pluck_fret: np.ndarray
    pluck_speed_m_s: np.ndarray
    pluck_x_m: np.ndarray
    power_w: np.ndarray
    hand: str = "linkage"
    guitar: str = "classical"
    controller: str = "planner"
    control_hz: float = 30.0
    seed: int = 0
    left_nq: int = 27

    def save(self, path: str | Path) -> None:
        """Write to an `.npz` file; the bytes depend on the content only."""
        storage.save(path, self, {"tablature": Tablature.to_json})

    @classmethod
    def load(cls, path: str | Path) -> Performance:
        """Read what `save` wrote.

        Raises:
            RoboGuitaristError: If it is not such a file.
        """
        return storage.load(path, cls, {"tablature": Tablature.from_json})
