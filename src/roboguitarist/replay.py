"""A recorded performance as postures of the scene in which it was played."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import mujoco
import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.guitar import Guitar, preset
from roboguitarist.hands import TIP_Z_M, VARIANTS
from roboguitarist.performance import PRESS_THRESHOLD_N, Performance
from roboguitarist.scene import SceneConfig, build

LEAD_S = 0.5
"""Films, pages and animations begin that long before the piece."""
FINGERS = ("ff", "mf", "rf", "lf")
_ALONG_FINGER = np.linspace(0.0, 1.0, 6)


def scene(performance: Performance) -> mujoco.MjModel:
    """The model, with everything that is seen, in which a performance was played.

    Raises:
        RoboGuitaristError: If its hand or guitar is not known, or its joints are not the hand's.
    """
    if performance.hand not in VARIANTS:
        raise RoboGuitaristError(f"no hand {performance.hand!r} (there are {', '.join(VARIANTS)})")
    model = build(SceneConfig(preset(performance.guitar), performance.hand))
    if performance.qpos.ndim != 2 or performance.qpos.shape[1] != model.nq:
        found = performance.qpos.shape
        raise RoboGuitaristError(f"the performance has joints {found}, the scene {model.nq}")
    return model


def frame_times(performance: Performance, fps: float, end_s: float = 0.0) -> np.ndarray:
    """Times (F,) of pictures in seconds from the start of the piece.

    They begin `LEAD_S` before the piece, or with the first tick if that is later, and go on to
    the last tick, or to `end_s` if that is later.

    Raises:
        RoboGuitaristError: If the performance has no ticks.
    """
    if not performance.time_s.size:
        raise RoboGuitaristError("nothing to show: the performance has no ticks")
    start_s = max(float(performance.time_s[0]), -LEAD_S)
    end_s = max(float(performance.time_s[-1]), end_s)
    return start_s + np.arange(max(1, round((end_s - start_s) * fps))) / fps


def sound_from(start_s: float, samples: np.ndarray, rate_hz: int) -> np.ndarray:
    """Sound (N, 2) of a piece from `start_s` on, with silence before the piece."""
    skipped = round(start_s * rate_hz)
    silence = np.zeros((max(0, -skipped), 2), np.float32)
    return np.concatenate([silence, samples[max(0, skipped) :]])


def postures(performance: Performance, times_s: np.ndarray) -> np.ndarray:
    """Joint positions (F, nq) at given times, between ticks by interpolation."""
    place = np.interp(times_s, performance.time_s, np.arange(len(performance.time_s)))
    before = place.astype(int)
    after = np.minimum(before + 1, len(performance.time_s) - 1)
    share = (place - before)[:, None]
    return (1 - share) * performance.qpos[before] + share * performance.qpos[after]


def body_poses(model: mujoco.MjModel, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (F, nbody, 3) in metres and orientations (F, nbody, 4), w first, in the world.

    Args:
        model: The scene.
        qpos: (F, nq) postures.
    """
    data = mujoco.MjData(model)
    positions = np.empty((len(qpos), model.nbody, 3))
    orientations = np.empty((len(qpos), model.nbody, 4))
    for frame, posture in enumerate(qpos):
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        positions[frame], orientations[frame] = data.xpos, data.xquat
    return positions, orientations


@dataclass(frozen=True, slots=True)
class Press:
    """One finger holding one string down behind a fret for a while.

    Attributes:
        start_s, end_s: First and last tick of it, in seconds from the start of the piece.
        string: 1 to 6.
        fret: Counted from the nut.
        finger: 1 to 4, whichever is nearest.
    """

    start_s: float
    end_s: float
    string: int
    fret: int
    finger: int


def presses(performance: Performance, model: mujoco.MjModel | None = None) -> tuple[Press, ...]:
    """What the left hand held down, in order of time.

    Args:
        performance: What was done.
        model: Its `scene`, if at hand.

    Raises:
        RoboGuitaristError: As `scene`.
    """
    model = model or scene(performance)
    held = performance.press_force_n >= PRESS_THRESHOLD_N
    ticks, strings, frets = (index.tolist() for index in np.nonzero(held))
    fingers = _nearest_fingers(performance, model, np.argwhere(held))
    cells = sorted(zip(strings, frets, fingers.tolist(), ticks, strict=True))
    found = []
    # Ticks that follow each other have the same difference to their rank.
    for (string, fret, finger, _), run in groupby(
        enumerate(cells), key=lambda item: (*item[1][:3], item[1][3] - item[0])
    ):
        span = [cell[3] for _, cell in run]
        start_s, end_s = performance.time_s[[span[0], span[-1]]].tolist()
        found.append(Press(start_s, end_s, string + 1, fret + 1, finger + 1))
    return tuple(sorted(found, key=lambda press: (press.start_s, press.string, press.fret)))


def _nearest_fingers(
    performance: Performance, model: mujoco.MjModel, cells: np.ndarray
) -> np.ndarray:
    """For cells (C, 3) of tick, string and fret from 0, the finger (C,) nearest to it, from 0."""
    positions, orientations = body_poses(model, performance.qpos)
    distances = []
    for finger in FINGERS:
        middle = positions[:, model.body(f"lh_{finger}middle").id]
        distal = model.body(f"lh_{finger}distal").id
        start = positions[:, distal]
        tip = start + TIP_Z_M * _z_axis(orientations[:, distal])
        points = np.concatenate(
            [a[:, None] + _ALONG_FINGER[:, None] * (b - a)[:, None]
             for a, b in ((middle, start), (start, tip))], axis=1
        )  # fmt: skip
        spots = _cell_points(preset(performance.guitar), cells)
        gaps = points[cells[:, 0], :, None] - spots[:, None]
        distances.append(np.linalg.norm(gaps, axis=-1).min(axis=(1, 2)))
    return np.argmin(distances, axis=0)


def _cell_points(guitar: Guitar, cells: np.ndarray) -> np.ndarray:
    """Points (C, 4, 3) on the string in the fret space of each cell, in metres."""
    string, fret = cells[:, 1, None] + 1, cells[:, 2, None] + 1
    wires = guitar.fret_x(fret - 1), guitar.fret_x(fret)
    x = wires[0] + np.array([0.2, 0.4, 0.6, 0.8]) * (wires[1] - wires[0])
    return np.stack(np.broadcast_arrays(x, guitar.string_y(string, x), 0.0), axis=-1)


def _z_axis(quat: np.ndarray) -> np.ndarray:
    """Where orientations (n, 4), w first, turn the z axis to, (n, 3)."""
    w, x, y, z = quat.T
    return np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
