"""What the sensors of the scene say: which string is stopped where, and what was plucked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.scene import CONTACTS_PER_STRING, NAILS, SENSOR_WIDTH

PRESS_THRESHOLD_N = 1.0
"""Normal force from which a string is fretted (the seed's training value)."""
DEAD = -1
"""Sounding fret of a string that is touched but not fretted."""


@dataclass(frozen=True)
class Stops:
    """How the left hand stops the strings at N moments.

    Attributes:
        force_n: (N, 6, F) normal force in each fret space of each string.
        touched_fret: (N, 6) highest fret space in which the string is touched, 0 for none.
    """

    force_n: np.ndarray
    touched_fret: np.ndarray

    def sounding_fret(self, capo: int = 0) -> np.ndarray:
        """Frets (N, 6) that the strings would sound: from `capo`, or `DEAD`.

        A string sounds at its highest fretted fret, open if nothing touches it above the capo.
        A touch below the threshold beyond the highest fretted fret deadens it.
        """
        fretted = self.force_n >= PRESS_THRESHOLD_N
        frets = np.arange(1, fretted.shape[-1] + 1)
        highest = np.where(fretted, frets, 0).max(axis=-1)
        sounding = np.maximum(highest, capo)
        return np.where(self.touched_fret > sounding, DEAD, sounding).astype(np.int8)


def stops(model: mujoco.MjModel, sensordata: np.ndarray, guitar: Guitar) -> Stops:
    """Read the strings' contact sensors.

    Args:
        model: The scene.
        sensordata: (N, nsensordata) readings.
        guitar: Where the frets are.
    """
    shape = len(STRINGS), CONTACTS_PER_STRING, SENSOR_WIDTH
    start = columns(model, "string_1")[0]  # the strings' sensors follow each other
    readings = sensordata[:, start : start + math.prod(shape)].reshape(-1, *shape)
    found = readings[..., 0] > 0
    fret = guitar.fret_at(readings[..., 4]) * found
    force = np.zeros((len(readings), len(STRINGS), guitar.n_frets + 2))
    moment, string, contact = found.nonzero()
    cell = moment, string, fret[moment, string, contact]
    np.add.at(force, cell, np.abs(readings[moment, string, contact, 1]))
    return Stops(force[..., 1:-1], fret.max(axis=2))


@dataclass(frozen=True)
class Plucks:
    """P crossings of strings by fingertips, in order of time.

    Attributes:
        time_s: (P,) time of the crossing.
        step: (P,) index of the sample after it.
        string: (P,) 1 to 6.
        finger: (P,) 0 to 3 for p, i, m, a.
        speed_m_s: (P,) speed across the string.
        x_m: (P,) distance from the nut.
    """

    time_s: np.ndarray
    step: np.ndarray
    string: np.ndarray
    finger: np.ndarray
    speed_m_s: np.ndarray
    x_m: np.ndarray


def plucks(
    model: mujoco.MjModel, sensordata: np.ndarray, time_s: np.ndarray, guitar: Guitar
) -> Plucks:
    """Find where the right fingertips' ends cross strings.

    A crossing counts when the end of the fingertip passes a string below its axis and over the
    sound hole, whichever finger it is and whichever way it goes.

    Args:
        model: The scene.
        sensordata: (S, nsensordata) readings at consecutive physics steps.
        time_s: (S,) their times.
        guitar: Where strings and sound hole are.
    """
    nail = sensordata[:, np.array([columns(model, nail) for nail in NAILS])]
    x, y, z = nail[..., 0], nail[..., 1], nail[..., 2]
    offset = y[..., None] - guitar.string_y(STRINGS, x[..., None])
    step, finger, string = np.nonzero((offset[:-1] < 0) != (offset[1:] < 0))
    before, after = offset[step, finger, string], offset[step + 1, finger, string]
    share = before / (before - after)

    def between(values: np.ndarray) -> np.ndarray:
        first, second = values[step, finger], values[step + 1, finger]
        return first + share * (second - first)

    x_m, z_m = between(x), between(z)
    plucked = (z_m < 0) & (np.abs(x_m - guitar.sound_hole_x_m) <= guitar.sound_hole_radius_m)
    step_s = time_s[step + 1] - time_s[step]
    found = Plucks(
        time_s[step] + share * step_s,
        step + 1,
        (string + 1).astype(np.int8),
        finger.astype(np.int8),
        np.abs(after - before) / step_s,
        x_m,
    )
    order = np.flatnonzero(plucked)
    order = order[np.argsort(found.time_s[order], kind="stable")]
    return Plucks(**{name: values[order] for name, values in vars(found).items()})


def left_power(model: mujoco.MjModel, sensordata: np.ndarray) -> np.ndarray:
    """Absolute mechanical power (N,) in watts of the left hand's actuators."""
    force, velocity = (sensordata[:, found_at] for found_at in power_columns(model))
    return np.abs(force * velocity).sum(axis=1)


def power_columns(model: mujoco.MjModel) -> tuple[list[int], list[int]]:
    """Where forces and velocities of the left hand's actuators are in `sensordata`."""
    names = [model.sensor(index).name for index in range(model.nsensor)]
    actuators = [name.removesuffix("_force") for name in names if name.endswith("_force")]
    force, velocity = (
        [columns(model, f"{actuator}_{kind}")[0] for actuator in actuators]
        for kind in ("force", "velocity")
    )
    return force, velocity


def columns(model: mujoco.MjModel, sensor: str) -> list[int]:
    """Where a sensor's readings are in `sensordata`."""
    index = model.sensor(sensor).id
    start = model.sensor_adr[index]
    return list(range(start, start + model.sensor_dim[index]))
