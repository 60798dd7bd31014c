"""Many left hands stepped together, on all cores, by `mujoco.rollout`."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from mujoco import rollout

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.posture import left_alone
from roboguitarist.fretting.randomisation import Randomisation, delays, varied
from roboguitarist.scene import LEFT_TIPS, SceneConfig
from roboguitarist.sensing import Stops, columns, power_columns, stops

WILD_RAD = 1.0
"""A joint that is that far outside its range has been thrown there by a broken contact."""
SAMPLES = 5
"""Moments of a tick at which rewards look at the strings."""
_FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS


class HandBatch:
    """N copies of one left hand on the guitar, each with its own state.

    The same states and targets give the same next states for any number of threads and any
    number of copies. A copy whose state is no longer finite, or with a joint far outside its range,
    is counted and put back.

    Args:
        scene: Guitar, hand variant and time step.
        n_envs: Number of copies, at least 1.
        control_hz: Control ticks per second; a tick is a whole number of time steps.
        n_threads: Threads that step; 0 steps in the calling thread.
        randomisation: How far the copies' physics differ from the model's.
        seed: Of that.

    Attributes:
        model: The model that all copies share.
        substeps: Time steps in a control tick.
        qpos, qvel: (N, nq) and (N, nv) positions and velocities, views of the state.
        n_failures: How many states had to be put back so far.

    Raises:
        RoboGuitaristError: If the rates do not fit each other.
    """

    def __init__(
        self,
        scene: SceneConfig,
        n_envs: int,
        control_hz: float = 30.0,
        n_threads: int = 0,
        *,
        randomisation: Randomisation | None = None,
        seed: int = 0,
    ) -> None:
        self.model = left_alone(scene)
        steps = 1.0 / (control_hz * scene.timestep_s)
        self.substeps = round(steps)
        if n_envs < 1 or abs(steps - self.substeps) > 1e-6 or self.substeps < 1:
            raise RoboGuitaristError(
                f"{n_envs} hands at {control_hz:g} Hz with steps of {scene.timestep_s:g} s"
                " (at least one, and whole steps in a tick)"
            )
        self.guitar, self.n_failures = scene.guitar, 0
        model = self.model
        size = mujoco.mj_stateSize(model, _FULL)
        self._states = np.zeros((n_envs, self.substeps, size))
        self._sensors = np.zeros((n_envs, self.substeps, model.nsensordata))
        self._control = np.zeros((n_envs, self.substeps, model.nu))
        self._state = np.zeros((n_envs, size))
        self.qpos = self._state[:, 1 : 1 + model.nq]
        self.qvel = self._state[:, 1 + model.nq : 1 + model.nq + model.nv]
        randomisation, rng = randomisation or Randomisation(), np.random.default_rng(seed)
        late = delays(randomisation, n_envs, scene.timestep_s, self.substeps, rng)
        self._late = [(steps, late == steps) for steps in np.unique(late[late > 0])]
        self.models = [model] * n_envs
        if randomisation != Randomisation(delay_s=randomisation.delay_s):
            self.models = [varied(model, randomisation, rng) for _ in range(n_envs)]
        self._widest = model.jnt_range.T + np.array([[-WILD_RAD], [WILD_RAD]])
        self._pool = rollout.Rollout(nthread=n_threads)
        self._data = [mujoco.MjData(model) for _ in range(max(1, n_threads))]
        self._force_n: np.ndarray | None = None
        self._power = np.array(power_columns(model))
        self._tips = np.array([columns(model, tip) for tip in LEFT_TIPS])

    @property
    def n_envs(self) -> int:
        """Number of copies."""
        return len(self._state)

    def put(self, index: np.ndarray, qpos: np.ndarray) -> None:
        """Place copies at rest in given positions, with what their sensors say there.

        Args:
            index: (M,) which copies.
            qpos: (M, nq) positions in rad and m.
        """
        self._force_n = None
        self._state[index] = 0.0
        self._state[index, 0] = 1.0  # a clock that a failure can put back
        self.qpos[index] = qpos
        data = self._data[0]
        for copy in index:
            mujoco.mj_resetData(self.models[copy], data)
            data.qpos[:] = self.qpos[copy]
            mujoco.mj_forward(self.models[copy], data)
            self._sensors[copy] = data.sensordata

    def step(self, ctrl: np.ndarray) -> np.ndarray:
        """Hold servo targets for one control tick.

        Args:
            ctrl: (N, nu) targets in rad and m, or (N, k, nu): one after the other, each for the
                same whole number of time steps.

        Returns:
            (N,) bool, copies that failed in this tick and are at the model's start again.
        """
        self._force_n = None
        parts = ctrl[:, None] if ctrl.ndim == 2 else ctrl
        before = self._control[:, -1].copy()
        each = self._control.reshape(self.n_envs, parts.shape[1], -1, parts.shape[2])
        each[:] = parts[:, :, None]
        for steps, late in self._late:
            self._control[late, steps:] = self._control[late, :-steps]
            self._control[late, :steps] = before[late, None]
        self._pool.rollout(
            self.models,
            self._data,
            self._state,
            self._control,
            nstep=self.substeps,
            state=self._states,
            sensordata=self._sensors,
            skip_checks=True,
        )
        last = self._states[:, -1]
        # MuJoCo puts a state that breaks back to the model's, at time 0: its clock falls behind.
        elapsed_s = last[:, 0] - self._state[:, 0]
        failed = elapsed_s < (self.substeps - 0.5) * self.model.opt.timestep
        qpos = last[:, 1 : 1 + self.model.nq]
        wild = ((qpos < self._widest[0]) | (qpos > self._widest[1])).any(axis=1)
        if wild.any():
            last[wild] = 0.0
            last[wild, 0] = 1.0
            qpos[wild] = self.model.qpos0
            failed |= wild
        self.n_failures += int(failed.sum())
        self._state[:] = last
        return failed

    def state(self) -> dict[str, np.ndarray]:
        """Where all copies are and what their sensors say, as arrays."""
        return {
            "state": self._state.copy(),
            "sensors": self._sensors.copy(),
            "control": self._control[:, -1].copy(),
        }

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Be where `state` was taken, with as many copies and the same model."""
        self._force_n = None
        self._state[:], self._sensors[:] = state["state"], state["sensors"]
        self._control[:, -1] = state["control"]

    def follow(self, leaders: np.ndarray, followers: np.ndarray) -> None:
        """Put copies (M,) where others (M,) are, with what their sensors say there."""
        self._force_n = None
        for array in (self._state, self._sensors[:, -1], self._control[:, -1]):
            array[followers] = array[leaders]

    @property
    def tip_m(self) -> np.ndarray:
        """Centres (N, 4, 3) of the fingertips of fingers 1 to 4 in metres."""
        return self._sensors[:, -1][:, self._tips]

    def press_force_n(self) -> np.ndarray:
        """Normal force (N, 6, F) in each fret space, read once for each tick."""
        if self._force_n is None:
            self._force_n = stops(self.model, self._sensors[:, -1], self.guitar).force_n
        return self._force_n

    def sounding_fret(self, capo: int = 0) -> np.ndarray:
        """Frets (N, 6) that the strings would sound, see `sensing.Stops.sounding_fret`."""
        return stops(self.model, self._sensors[:, -1], self.guitar).sounding_fret(capo)

    def over_tick(self) -> Stops:
        """How the strings were stopped at `SAMPLES` moments of the last tick, the last its end.

        Copy after copy, each with its moments in order of time: N x SAMPLES in all.
        """
        chosen = self._sensors[:, sample_steps(self.substeps)]
        return stops(self.model, chosen.reshape(-1, chosen.shape[-1]), self.guitar)

    def power_w(self) -> np.ndarray:
        """Absolute mechanical power (N,) of the servos, mean over the last tick."""
        force, velocity = (self._sensors.take(found_at, axis=2) for found_at in self._power)
        return np.abs(force * velocity).sum(axis=(1, 2)) / self.substeps

    def close(self) -> None:
        """Stop the threads."""
        self._pool.close()


def sample_steps(substeps: int) -> np.ndarray:
    """Indices (SAMPLES,) of physics steps that are spread evenly over a tick, the last its end."""
    return np.ceil(np.arange(1, SAMPLES + 1) * substeps / SAMPLES).astype(int) - 1
