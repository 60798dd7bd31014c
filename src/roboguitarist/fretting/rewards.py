"""Rewards of the left hand over N environments: the paper's equations 1 to 4, and two of ours.

The equations are those of "Learning to Play Guitar with Robotic Hands", section 5. Every term is
in [0, 1] except the energy, which is not above 0.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.sensing import PRESS_THRESHOLD_N

Kind = Literal["reciprocal", "gaussian"]
KINDS: tuple[Kind, ...] = get_args(Kind)
AT_MARGIN = 0.1
"""What a mapping gives at bound + margin."""
CLOSE_M = 0.001
"""Distance from the key's centre, across the strings and in height, with full reward."""
REACH_M = 0.1
"""Margin of the fingers' rewards."""
FIRM_N = 1.5
"""Force with which a string is held firmly: half as much again as the least that frets it."""
HARD_N = 4.0
"""Force above which a press is too hard; at twice that nothing of the force's reward is left."""
ASKED = 4.0
"""Weight of a string that is asked, against one that is not."""
ENERGY_COEFFICIENT = 0.0025
"""Reward per watt while something is to be fretted."""


def mapping(x: ArrayLike, bound: ArrayLike, margin: float, kind: Kind = "reciprocal") -> np.ndarray:
    """The paper's g (figure 4): 1 for x in [0, bound], 0.1 at bound + margin, falling on.

    With d = (x - bound) / margin, `reciprocal` is 1 / (1 + 9 d) and `gaussian` is
    exp(-0.5 (s d)^2) with s = sqrt(-2 ln 0.1). Margin 0 makes it 0 beyond the bound.

    Args:
        x: (...) distances.
        bound: (...) distances up to which there is full reward.
        margin: How far beyond the bound there is 0.1 left, in the unit of x.
        kind: One of `KINDS`.

    Returns:
        (...) values in [0, 1].

    Raises:
        RoboGuitaristError: If there is no such kind, or an argument is negative.
    """
    if kind not in KINDS:
        raise RoboGuitaristError(f"no mapping {kind!r} (there are {', '.join(KINDS)})")
    if margin < 0 or np.less(x, 0).any() or np.less(bound, 0).any():
        raise RoboGuitaristError("a distance, bound or margin is negative (0 or more)")
    beyond = np.subtract(x, bound)
    if margin == 0:
        return np.where(beyond > 0, 0.0, 1.0)
    return _fall(beyond / margin, kind)


def _fall(d: np.ndarray, kind: Kind) -> np.ndarray:
    """The mapping (...) of distances beyond the bound in margins, (...); 1 where negative."""
    d = np.maximum(d, 0.0)
    if kind == "gaussian":
        return np.exp(np.log(AT_MARGIN) * d**2)
    return 1.0 / (1.0 + (1.0 / AT_MARGIN - 1.0) * d)


def finger_reward(
    tip_m: np.ndarray,
    key_m: np.ndarray,
    key_length_m: np.ndarray,
    active: np.ndarray,
    kind: Kind = "reciprocal",
    *,
    margin_m: float = REACH_M,
) -> np.ndarray:
    """How near the fingers are to their keys (equation 1): (r_x + r_y + r_z) / 3.

    The paper gives the reward of one finger; here it is the mean over the active ones.

    Args:
        tip_m: (N, 4, 3) centres of the fingertips.
        key_m: (N, 4, 3) where they are in the middle of their keys.
        key_length_m: (N, 4) lengths of the keys along the strings.
        active: (N, 4) bool, fingers that have a key.
        kind: Mapping function.
        margin_m: How far beyond full reward there is a tenth of it.

    Returns:
        (N,) in [0, 1], 1 where no finger is active.
    """
    near = nearness(tip_m, key_m, key_length_m, kind, margin_m=margin_m)
    return _mean(near, active)


def nearness(
    tip_m: np.ndarray,
    key_m: np.ndarray,
    key_length_m: np.ndarray,
    kind: Kind = "reciprocal",
    *,
    margin_m: float = REACH_M,
) -> np.ndarray:
    """Equation 1 of each finger, (N, 4) in [0, 1]; arguments as of `finger_reward`."""
    beyond = np.abs(tip_m - key_m)
    beyond[..., 0] -= 0.5 * key_length_m
    beyond[..., 1:] -= CLOSE_M
    return _fall(beyond / margin_m, kind).sum(axis=-1) / 3.0


def euclidean_finger_reward(
    tip_m: np.ndarray, key_m: np.ndarray, active: np.ndarray, kind: Kind = "reciprocal"
) -> np.ndarray:
    """How near the fingers are to the centres of their keys, for the ablation of figure 14.

    The paper does not state bound and margin; here they are those of r_y and r_z.

    Args:
        tip_m: (N, 4, 3) centres of the fingertips.
        key_m: (N, 4, 3) where they are in the middle of their keys.
        active: (N, 4) bool, fingers that have a key.
        kind: Mapping function.

    Returns:
        (N,) in [0, 1], 1 where no finger is active.
    """
    distance_m = np.linalg.norm(tip_m - key_m, axis=-1)
    return _mean(mapping(distance_m, CLOSE_M, REACH_M, kind), active)


def key_reward(
    force_n: np.ndarray,
    wanted_fret: np.ndarray,
    freedom: bool,
    threshold_n: float,
    kind: Kind = "reciprocal",
) -> np.ndarray:
    """Whether the wanted keys are held and no others (equation 2).

    Half of it is the mean of g(|k_s - 1|, 0, 1) over the wanted keys, with k_s the force over
    the threshold, at most 1; it is whole if nothing is wanted, which the paper leaves open. The
    other half is lost as soon as one prohibited key is held.

    Args:
        force_n: (N, 6, F) normal force in each fret space of each string.
        wanted_fret: (N, 6) fret to be held on each string, 0 for none. Above F there is no key
            that could be wanted.
        freedom: Frets below the wanted one of a string may be held too.
        threshold_n: Force from which a key is held, above 0.
        kind: Mapping function.

    Returns:
        (N,) in [0, 1].
    """
    frets = np.arange(1, force_n.shape[-1] + 1)
    fret = wanted_fret[..., None]
    wanted = frets == fret
    prohibited = frets > fret if freedom else ~wanted
    strength = (wanted * force_n).sum(axis=-1) / threshold_n
    pressed = _fall(1.0 - strength, kind)
    false_positive = ((force_n >= threshold_n) & prohibited).any(axis=(1, 2))
    return 0.5 * _mean(pressed, wanted.any(axis=-1)) + 0.5 * ~false_positive


def energy(
    power_w: np.ndarray, wanted_any: np.ndarray, coefficient: float = ENERGY_COEFFICIENT
) -> np.ndarray:
    """What moving costs (equation 3): -k |torque|^T |velocity|, k doubled if nothing is wanted.

    Args:
        power_w: (N,) sum over the joints of the absolute mechanical power.
        wanted_any: (N,) bool, something is to be fretted.
        coefficient: The paper's k.

    Returns:
        (N,) at most 0.
    """
    return -coefficient * np.where(wanted_any, 1.0, 2.0) * power_w


def total(key: np.ndarray, finger: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """The paper's reward (N,) of its three terms (N,) (equation 4)."""
    return 0.5 * key + 0.5 * finger + energy


def playing_reward(
    force_n: np.ndarray,
    sounding_fret: np.ndarray,
    wanted_fret: np.ndarray,
    asked: np.ndarray,
    onset: np.ndarray,
) -> np.ndarray:
    """What each string adds to the share of those that do what the tablature asks.

    A string that is asked counts `ASKED`, and three times that around its onset: 1 if it would
    sound the right fret and, where that is stopped, is held with `FIRM_N`; 0.3 of it is for the
    force, which leads a light finger on and a hard one back: more than `HARD_N` makes it late when
    it is to leave. A string that is not asked counts 1: it is not to be
    fretted.

    Args:
        force_n: (N, 6, F) normal force in each fret space of each string.
        sounding_fret: (N, 6) fret from the nut that would sound, negative for a dead string.
        wanted_fret: (N, 6) fret from the nut that is to sound on the strings asked.
        asked: (N, 6) bool, strings that are to sound.
        onset: (N, 6) bool, strings that are being plucked.

    Returns:
        (N, 6) from 0; their sum is in [0, 1].
    """
    stopped = (asked & (wanted_fret > 0))[..., None]
    frets = np.arange(1, force_n.shape[-1] + 1)
    firm = np.clip(np.where(frets == wanted_fret[..., None], force_n, 0.0).sum(-1) / FIRM_N, 0, 1)
    right = sounding_fret == wanted_fret
    strength = np.where(stopped[..., 0], firm, right)
    strength = strength - np.clip(force_n.max(axis=-1) / HARD_N - 1.0, 0.0, 1.0)
    free = (force_n < PRESS_THRESHOLD_N).all(axis=-1)
    value = np.where(asked, 0.7 * right + 0.3 * np.maximum(strength, 0.0), free)
    weight = np.where(asked, ASKED * np.where(onset, 3.0, 1.0), 1.0)
    return weight * value / weight.sum(axis=-1, keepdims=True)


def calm_reward(action_change: np.ndarray) -> np.ndarray:
    """How little the action changes: 1 if not at all, 0.1 for a root mean square of 1.

    Args:
        action_change: (N, A) difference of two consecutive actions, each in [-1, 1].

    Returns:
        (N,) in [0, 1].
    """
    return mapping(np.sqrt(np.mean(action_change**2, axis=-1)), 0.0, 1.0, "gaussian")


def _mean(values: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """Mean (N,) of the counted ones of `values` (N, M), 1 where none is counted."""
    count = counted.sum(axis=-1)
    return np.where(count > 0, (values * counted).sum(axis=-1) / np.maximum(count, 1), 1.0)
