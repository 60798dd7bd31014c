"""What the hand can fret in physics: shapes held by a search over constant servo targets.

The search is the cross-entropy method (Rubinstein and Kroese, 2004) around the planner's targets:
all candidates of a round are tried at once, each by a hand that waits over the strings and then
holds the targets still.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.exercises.shapes import Shape
from roboguitarist.fingering import Fingering
from roboguitarist.fretting import planner
from roboguitarist.fretting.batch import HandBatch
from roboguitarist.hands import TIP_RADIUS_M
from roboguitarist.plan import PLAN_HZ
from roboguitarist.scene import SceneConfig
from roboguitarist.sensing import DEAD
from roboguitarist.tablature import Note, Tablature

ONSET_S, HELD_S = 0.5, 1.0
"""The shape is planned to be struck then, and to be held that long."""
FIRM_N = 3.0
"""Forces above that are no better."""
ALL_FIRM = 1.49
"""Score from which a search is over; more than 1.5 there is not."""
_SPREAD = {"forearm": 0.006, "WRJ1": 0.12, "WRJ2": 0.08, "LFJ5": 0.1, "J0": 0.3, "TH": 0.0}
_OTHER_SPREAD = 0.12


@dataclass(frozen=True)
class SearchConfig:
    """How thoroughly to search.

    Attributes:
        rounds: Rounds of the cross-entropy method.
        ticks: Control ticks for which targets are held; the last three are judged.
    """

    rounds: int = 12
    ticks: int = 12


@dataclass(frozen=True)
class Hold:
    """How well a shape was held.

    Attributes:
        force_n: Least force of each stopped string over the last ticks, in the order of
            `Shape.stops`, in N; for an open string 0.
        held: Every stopped string was held with the threshold or more at the right fret and
            would sound it, and every open string would sound open.
        reason: Why not: `reach`, `finger width`, `force` or `muted`; empty if held.
        ctrl: (nu,) servo targets in rad and m.
    """

    force_n: tuple[float, ...]
    held: bool
    reason: str
    ctrl: np.ndarray


def hold(
    shape: Shape, hands: HandBatch, scene: SceneConfig, config: SearchConfig, seed: int = 0
) -> Hold:
    """Search for servo targets that hold a shape.

    Args:
        shape: What to hold, with at least one stopped string.
        hands: As many candidates at a time as it has copies.
        scene: The scene of these hands.
        config: How long to search.
        seed: Of the search.
    """
    rng, model = np.random.default_rng(seed), hands.model
    ready, mean = planned(shape, scene)
    names = [model.actuator(index).name.removeprefix("lh_A_") for index in range(model.nu)]
    spread = np.array([_spread(name) for name in names])
    least, (low, high) = 0.05 * spread, model.actuator_ctrlrange.T
    best, best_score = mean, -1.0
    for _ in range(config.rounds):
        tried = np.clip(mean + spread * rng.normal(size=(hands.n_envs, model.nu)), low, high)
        tried[:2] = mean, best
        score = _scores(shape, hands, _try(hands, ready, tried, config.ticks))
        order = np.argsort(-score, kind="stable")[: max(hands.n_envs // 8, 2)]
        if score[order[0]] > best_score:
            best, best_score = tried[order[0]], float(score[order[0]])
        if best_score >= ALL_FIRM:
            break
        mean = 0.3 * mean + 0.7 * tried[order].mean(axis=0)
        spread = np.maximum(0.4 * spread + 0.6 * tried[order].std(axis=0), least)
    force, sounding = _try(hands, ready, np.tile(best, (hands.n_envs, 1)), config.ticks)
    return _judged(shape, hands, force[:, 0], sounding[:, 0], best)


def planned(shape: Shape, scene: SceneConfig) -> tuple[np.ndarray, np.ndarray]:
    """Posture (nq,) over the strings, and servo targets (nu,) when the planner holds a shape."""
    notes = tuple(Note(ONSET_S, string, fret, HELD_S) for string, fret, _ in shape.stops)
    fingers = np.array([finger for _, _, finger in shape.stops], np.int8)
    barre = np.array([finger in shape.barres for _, _, finger in shape.stops])
    stopped = [(fret, finger) for _, fret, finger in shape.stops if finger]
    position = max(1, min(fret - finger + 1 for fret, finger in stopped))
    none = np.zeros(len(notes), np.int8)
    fingering = Fingering(
        Tablature(notes), fingers, none, barre, np.full(len(notes), position, np.int8),
        np.full(len(notes), ONSET_S + HELD_S), none, np.zeros(len(notes)),
    )  # fmt: skip
    plan = planner.plan(fingering, scene)
    ready, middle = np.searchsorted(plan.time_s, [ONSET_S - 0.15, ONSET_S + HELD_S / 2])
    return plan.qpos[ready], plan.ctrl[middle : middle + round(PLAN_HZ / 30)].mean(axis=0)


def _spread(name: str) -> float:
    ends = (value for key, value in _SPREAD.items() if key in name)
    return next(ends, _OTHER_SPREAD)


def _try(
    hands: HandBatch, ready: np.ndarray, ctrl: np.ndarray, ticks: int
) -> tuple[np.ndarray, np.ndarray]:
    """Hold targets (N, nu); forces (3, N, 6, F) and sounding frets (3, N, 6) of the last ticks."""
    hands.put(np.arange(hands.n_envs), np.tile(ready, (hands.n_envs, 1)))
    force, sounding = [], []
    for _ in range(ticks):
        hands.step(ctrl)
        force.append(hands.press_force_n())
        sounding.append(hands.sounding_fret())
    return np.array(force[-3:]), np.array(sounding[-3:])


def _scores(shape: Shape, hands: HandBatch, tried: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Mean over the strings (N,): right counts 1, up to half as much again for the force."""
    force, sounding = tried
    total = np.zeros(hands.n_envs)
    for string, fret, _ in shape.stops:
        total += (sounding[:, :, string - 1] == fret).all(axis=0)
        if fret:
            least = force[:, :, string - 1, fret - 1].min(axis=0)
            total += 0.5 * np.minimum(least / FIRM_N, 1.0)
    return total / len(shape.stops)


def _judged(
    shape: Shape, hands: HandBatch, force: np.ndarray, sounding: np.ndarray, ctrl: np.ndarray
) -> Hold:
    """Forces (3, 6, F) and sounding frets (3, 6) of one hand, and what is wrong with them."""
    forces, reasons = [], []
    for stop in shape.stops:
        string, fret, _ = stop
        least = float(force[:, string - 1, fret - 1].min()) if fret else 0.0
        forces.append(round(least, 2))
        if not (sounding[:, string - 1] == fret).all():
            reasons.append(_reason(hands, stop, least > 0.0, int(sounding[-1, string - 1])))
    order = ("finger width", "reach", "force", "muted")
    reason = next((name for name in order if name in reasons), "")
    return Hold(tuple(forces), not reasons, reason, ctrl)


def _reason(hands: HandBatch, stop: tuple[int, int, int], touched: bool, sounding: int) -> str:
    """Why a string does not sound its fret."""
    _, fret, finger = stop
    if not fret or (sounding == DEAD and not touched):
        return "muted"
    tips, guitar = hands.tip_m[0], hands.guitar
    tip, others = tips[finger - 1], np.delete(tips, finger - 1, axis=0)
    if np.linalg.norm(others - tip, axis=1).min() < 2 * TIP_RADIUS_M + 0.001:
        return "finger width"
    inside = guitar.fret_x(fret - 1) < tip[0] < guitar.fret_x(fret)
    return "force" if inside and touched else "reach"
