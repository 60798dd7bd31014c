"""What the physics did: joint paths, press forces and plucks as they happened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import mujoco.rollout
import numpy as np

from roboguitarist import plucking, policies, storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering import Fingering
from roboguitarist.fretting.pilot import Pilot
from roboguitarist.fretting.policy import Policy
from roboguitarist.guitar import preset
from roboguitarist.hands import VARIANTS, Variant
from roboguitarist.plan import PLAN_HZ, HandPlan
from roboguitarist.scene import SceneConfig, build
from roboguitarist.sensing import DEAD, PRESS_THRESHOLD_N, left_power, plucks, stops
from roboguitarist.tablature import Tablature

__all__ = ["DEAD", "PRESS_THRESHOLD_N", "PerformConfig", "Performance", "perform"]


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


CONTROLLERS = ("policy", "planner")


@dataclass(frozen=True)
class PerformConfig:
    """How to perform.

    Attributes:
        hand: Variant of both hands, see `roboguitarist.hands.VARIANTS`.
        guitar: Name of a guitar preset.
        controller: What drives the left hand, one of `CONTROLLERS`: the planner alone, or
            corrected by a policy.
        policy: The policy; without one, that which comes with the package for this hand.
        control_hz: Ticks per second at which the performance is sampled.
        seed: Written into the performance; the planner uses no chance.
    """

    hand: Variant = "linkage"
    guitar: str = "classical"
    controller: str = "planner"
    policy: Policy | None = None
    control_hz: float = 30.0
    seed: int = 0


def perform(
    fingering: Fingering,
    config: PerformConfig | None = None,
    progress: Callable[[float], None] | None = None,
    left: HandPlan | None = None,
    right: HandPlan | None = None,
) -> Performance:
    """Play a piece with both hands in physics.

    The hands are placed where their plans begin; from then on only their servos move them.

    Args:
        fingering: What to play, with which fingers.
        config: How to play it.
        progress: Called with the share of the work that is done, from 0 to 1.
        left: What `planner.plan` gives for the piece, if it is at hand.
        right: What `plucking.plan` gives for it.

    Returns:
        What happened, the same for the same arguments.

    Raises:
        RoboGuitaristError: If the configuration names something that there is not.
    """
    config, progress = config or PerformConfig(), progress or (lambda _: None)
    scene = scene_config(config)
    progress(0.0)
    right = right or plucking.plan(fingering, scene)
    progress(0.2)
    model = build(scene)
    policy = None
    if config.controller == "policy":
        policy = config.policy or policies.load(config.hand)
    pilot = Pilot(policy, fingering, scene, model, guitar=config.guitar, plan=left)
    progress(0.6)
    recording = simulate(model, pilot.plan, right, lambda share: progress(0.6 + 0.4 * share), pilot)
    return _observe(fingering, config, scene, model, recording)


def scene_config(config: PerformConfig) -> SceneConfig:
    """The scene in which `perform` plays, without what only the eye needs.

    Raises:
        RoboGuitaristError: If the configuration names something that there is not.
    """
    for kind, name, names in (
        ("hand", config.hand, VARIANTS),
        ("controller", config.controller, CONTROLLERS),
    ):
        if name not in names:
            raise RoboGuitaristError(f"no {kind} {name!r} (there are {', '.join(names)})")
    return SceneConfig(preset(config.guitar), config.hand, visuals=False)


@dataclass(frozen=True)
class Recording:
    """Every physics step of a simulation.

    Attributes:
        time_s: (S,) time after each step.
        qpos: (S, nq) positions.
        sensordata: (S, nsensordata) readings.
    """

    time_s: np.ndarray
    qpos: np.ndarray
    sensordata: np.ndarray


_FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
CHUNK_SAMPLES = 2400
"""Samples of the plans simulated in one call: progress can be told and memory stays bounded."""


def simulate(
    model: mujoco.MjModel,
    left: HandPlan,
    right: HandPlan,
    progress: Callable[[float], None] | None = None,
    pilot: Pilot | None = None,
) -> Recording:
    """Let the servos follow both plans.

    Args:
        model: Scene with both hands.
        left: Plan of the left hand.
        right: Plan of the right hand, over the same times.
        progress: Called with the share that is done, from 0 to 1.
        pilot: Moves the left hand, or corrects its plan, while the piece lasts.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([left.qpos[0], right.qpos[0]])
    mujoco.mj_forward(model, data)
    state = np.empty(mujoco.mj_stateSize(model, _FULL))
    mujoco.mj_getState(model, data, state, _FULL)
    sensed = data.sensordata[None].copy()
    substeps = round(1.0 / (PLAN_HZ * model.opt.timestep))
    plan, n_left = np.hstack([left.ctrl, right.ctrl]), left.ctrl.shape[1]
    time_s = left.time_s[0] + model.opt.timestep * np.arange(1, len(plan) * substeps + 1)
    qpos, readings, start = [], [], 0
    while start < len(plan):
        tick, size = -1, CHUNK_SAMPLES
        if pilot:
            tick = (start - pilot.first) // pilot.parts
            size = pilot.first - start if tick < 0 else size
            size = pilot.parts if 0 <= tick < pilot.n_ticks else size
        chunk = plan[start : start + size].copy()
        if pilot and 0 <= tick < pilot.n_ticks:
            joints = state[1 : 1 + model.nq + model.nv]
            targets = pilot.ctrl(tick, joints[: model.nq], joints[model.nq :], sensed)
            chunk[:, :n_left] = targets[: len(chunk)]
        states, sensordata = mujoco.rollout.rollout(
            model, data, state, np.repeat(chunk, substeps, axis=0)
        )
        state, sensed = states[0, -1], sensordata[0]
        qpos.append(states[0, :, 1 : 1 + model.nq].astype(np.float32))
        readings.append(sensordata[0].astype(np.float32))
        start += len(chunk)
        if progress:
            progress(start / len(plan))
    return Recording(time_s, np.concatenate(qpos), np.concatenate(readings))


def _observe(
    fingering: Fingering,
    config: PerformConfig,
    scene: SceneConfig,
    model: mujoco.MjModel,
    recording: Recording,
) -> Performance:
    """Sample a simulation at the control ticks and at the plucks."""
    tablature, guitar = fingering.tablature, scene.guitar
    steps = round(1.0 / (config.control_hz * model.opt.timestep))
    ticks = np.arange(steps - 1, len(recording.time_s), steps)
    held = stops(model, recording.sensordata[ticks], guitar)
    found = plucks(model, recording.sensordata, recording.time_s, guitar)
    at_pluck = stops(model, recording.sensordata[found.step], guitar)
    sounded = at_pluck.sounding_fret(tablature.capo)[np.arange(len(found.step)), found.string - 1]
    power = left_power(model, recording.sensordata)[: len(ticks) * steps]
    return Performance(
        tablature=tablature,
        left=fingering.left,
        right=fingering.right,
        time_s=recording.time_s[ticks],
        qpos=recording.qpos[ticks],
        press_force_n=held.force_n.astype(np.float32),
        sounding_fret=held.sounding_fret(tablature.capo),
        pluck_time_s=found.time_s,
        pluck_string=found.string,
        pluck_finger=found.finger,
        pluck_fret=sounded,
        pluck_speed_m_s=found.speed_m_s.astype(np.float32),
        pluck_x_m=found.x_m.astype(np.float32),
        power_w=power.reshape(-1, steps).mean(axis=1).astype(np.float32),
        hand=config.hand,
        guitar=config.guitar,
        controller=config.controller,
        control_hz=config.control_hz,
        seed=config.seed,
    )
