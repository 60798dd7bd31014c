"""The cheapest way through a piece, by dynamic programming after Viterbi.

A state is what matters for the future: for each finger the stop that it holds or has just left,
the hand's position, and whether the onset before had open strings only. Everything that a step
can cost is looked up in tables, which are made for many moments at once; the sums are exact, so
the way found is one of the cheapest of all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.fingering.costs import Costs, Terms
from roboguitarist.fingering.settings import Setting
from roboguitarist.fingering.tables import (
    N_HANDS,
    N_RINGS,
    Live,
    hand_of,
    live_stops,
    tables,
    weights,
)
from roboguitarist.fingering.terms import finger_terms, form_terms, move_terms, ring_terms


@dataclass(frozen=True)
class Way:
    """The way found through K moments.

    Attributes:
        form: (K,) form at each moment.
        cost: (K,) what its step costs.
        stop: (K, 4) stop that each finger holds or knows when the moment comes, or -1.
        hand: (K,) the hand then, a row of `tables.hand_row`.
        ringing: (K,) bits of the strings that ring open then; 0 where strings are given.
    """

    form: np.ndarray
    cost: np.ndarray
    stop: np.ndarray
    hand: np.ndarray
    ringing: np.ndarray


@dataclass(frozen=True)
class _Layer:
    """States of one moment: rows (S, 6), cost so far (S,), and how each was reached (S,)."""

    rows: np.ndarray
    value: np.ndarray
    reached: np.ndarray


def search(setting: Setting, costs: Costs, memory: int, hardest: bool = False) -> Way:
    """Find the way of least cost.

    Args:
        setting: The piece.
        costs: Weights.
        memory: For how many onsets a finger knows where it last was.
        hardest: Make the dearest step as cheap as can be first, and only then the sum.
    """
    live = live_stops(setting, memory)
    limit = np.inf
    if hardest:
        limit = float(_layers(setting, costs, live, np.inf, np.maximum)[-1].value.min())
    layers = _layers(setting, costs, live, limit, np.add)
    return _retrace(setting, live, layers)


def _layers(
    setting: Setting, costs: Costs, live: Live, limit: float, combine: np.ufunc
) -> list[_Layer]:
    place = weights(live.width)
    base = np.array([live.width] * 4 + [N_HANDS, N_RINGS])
    layers = [_Layer(np.zeros((1, 6), np.int16), np.zeros(1), np.zeros(1, np.int32))]
    for table in tables(setting, costs.total, live):
        last = layers[-1]
        rows = last.rows + table.offsets
        step = table.cost.take(rows, axis=0).sum(axis=1)
        if np.isfinite(limit):
            step[step > limit] = np.inf
        value = combine(last.value[:, None], step).ravel()
        key = table.key.take(rows, axis=0).sum(axis=1).ravel()
        order = np.lexsort((value, key))
        key = key[order]
        new = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
        best = order[new]
        best, new = best[np.isfinite(value[best])], new[np.isfinite(value[best])]
        digits = key[new][:, None] // place % base
        layers.append(_Layer(digits.astype(np.int16), value[best], best.astype(np.int32)))
    return layers


def _retrace(setting: Setting, live: Live, layers: list[_Layer]) -> Way:
    first = setting.forms.first
    n_moments = len(layers) - 1
    form, cost = np.zeros(n_moments, int), np.zeros(n_moments)
    stop, rest = np.full((n_moments, 4), -1), np.zeros((n_moments, 2), int)
    state = int(layers[-1].value.argmin())
    for k in range(n_moments - 1, -1, -1):
        here, before = layers[k + 1], layers[k]
        parent, column = divmod(int(here.reached[state]), int(first[k + 1] - first[k]))
        form[k] = first[k] + column
        cost[k] = here.value[state] - before.value[parent]
        rows = before.rows[parent]
        stop[k] = live.stop[live.first[k] + rows[:4]]
        rest[k] = rows[4:]
        state = parent
    return Way(form, cost, stop, rest[:, 0], rest[:, 1])


def way_terms(setting: Setting, way: Way) -> Terms:
    """Terms (K,) of every step of a way."""
    moment = np.arange(len(way.form))
    before, after_open = hand_of(way.hand)
    terms = form_terms(setting, way.form)
    terms |= move_terms(setting, moment, before, after_open, way.form)
    terms |= ring_terms(setting, way.ringing, way.form)
    for finger in range(4):
        at = np.flatnonzero(way.stop[:, finger] >= 0)
        numbers = np.full(len(at), finger + 1)
        more, _, _ = finger_terms(setting, at, numbers, way.stop[at, finger], way.form[at])
        for name, values in more.items():
            terms[name] = terms.get(name, np.zeros(len(moment))).astype(float)
            terms[name][at] += values
    return terms
