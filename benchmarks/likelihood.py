"""Learning the costs' weights: how likely a search makes the fingers that an editor wrote.

The probability of a way through a piece is taken as exp(-cost) / Z, so that of the marked fingers
is the sum over all ways that have them. Sums over all ways, and the expected terms that are their
gradient, come from a forward and a backward pass over the search's own tables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.optimize import minimize

from roboguitarist.fingering.costs import NAMES, Costs, Terms
from roboguitarist.fingering.settings import Setting
from roboguitarist.fingering.tables import N_HANDS, N_RINGS, live_stops, tables, weights

FIXED = {
    *("rushed", "hurried", "speed", "cut", "lost"),
    *("left_out", "unheld"),
    *("stopped", "height", "silenced"),
    *("index", "middle", "ring", "little"),
    "nudge",
}
"""Weights that stay as they were set by hand. They depend on the tempo, which the data do not give;
editors never choose such a thing; strings are not free where fingers are learned; editors mark what
is out of the ordinary, so that the little finger looks usual; or there are too few runs to tell."""
LEARNED = tuple(name for name in NAMES if name not in FIXED)
LARGEST = 12.0
Weights = dict[str, float]


@dataclass(frozen=True)
class _Step:
    """One moment: its table's shape and entries, the rows of its states, where they lead."""

    shape: tuple[int, int]
    entries: slice
    rows: np.ndarray
    to: np.ndarray
    n_after: int


class Graph:
    """All ways through a piece, with the terms of every step."""

    def __init__(self, setting: Setting, memory: int) -> None:
        live = live_stops(setting, memory)
        place = weights(live.width)
        base = np.array([live.width] * 4 + [N_HANDS, N_RINGS])
        states, first, terms = np.zeros((1, 6), int), 0, []
        self._steps: list[_Step] = []
        for table in tables(setting, _all_terms, live):
            rows = states + table.offsets
            number, to = np.unique(table.key.take(rows, axis=0).sum(axis=1), return_inverse=True)
            shape = table.key.shape[0], table.key.shape[1]
            to = to.reshape(len(rows), shape[1])
            entries = slice(first, first + table.key.size)
            self._steps.append(_Step(shape, entries, rows, to, len(number)))
            states, first = number[:, None] // place % base, entries.stop
            terms.append(sparse.csr_matrix(table.cost.reshape(-1, len(NAMES))))
        self._terms = sparse.csr_matrix(sparse.vstack(terms))
        self._by_term = sparse.csr_matrix(self._terms.T)

    def likelihood(self, given: np.ndarray) -> tuple[float, np.ndarray]:
        """Logarithm of the sum over all ways, and the expected sum of each term (T,)."""
        factor = np.exp(-(self._terms @ given))
        ahead, edges, log_sum = [np.ones(1)], [], 0.0
        for step in self._steps:
            table = factor[step.entries].reshape(step.shape)
            edges.append(table.take(step.rows, axis=0).prod(axis=1))
            flow = (ahead[-1][:, None] * edges[-1]).ravel()
            after = np.bincount(step.to.ravel(), flow, minlength=step.n_after)
            log_sum += float(np.log(after.sum()))
            ahead.append(after / after.sum())
        count, behind = np.zeros(len(factor)), np.ones(len(ahead[-1]))
        for step, edge, before in zip(self._steps[::-1], edges[::-1], ahead[-2::-1], strict=True):
            flow = edge * behind[step.to]
            share = before[:, None] * flow
            columns = step.shape[1]
            at = (step.rows[:, :, None] * columns + np.arange(columns)).ravel()
            spread = np.broadcast_to((share / share.sum())[:, None, :], (len(flow), 6, columns))
            size = step.entries.stop - step.entries.start
            count[step.entries] = np.bincount(at, spread.ravel(), minlength=size)
            behind = flow.sum(axis=1)
            behind /= behind.max()
        return log_sum, self._by_term @ count


def _all_terms(terms: Terms) -> np.ndarray:
    """Terms (n, T) in the order of `NAMES`."""
    if not terms:
        return np.zeros(len(NAMES), np.float32)
    size = len(next(iter(terms.values())))
    empty = np.zeros(size, np.float32)
    return np.stack([terms.get(name, empty) for name in NAMES], axis=1, dtype=np.float32)


@dataclass(frozen=True)
class Example:
    """A passage: all ways that keep its marks, all ways, and how much it counts."""

    marked: Graph
    every: Graph
    share: float = 1.0


def learn(examples: Sequence[Example], start: Costs, pull: float, steps: int) -> Costs:
    """Weights that make the marked fingers likely.

    Args:
        examples: Passages with marks.
        start: Weights to begin with, and to stay near.
        pull: Weight of the squared distance from there.
        steps: Iterations of L-BFGS-B.
    """
    origin = np.array([getattr(start, name) for name in NAMES], float)
    free = np.array([name in LEARNED for name in NAMES])

    def loss(values: np.ndarray) -> tuple[float, np.ndarray]:
        given = origin.copy()
        given[free] = values
        total, slope = pull * float(((given - origin) ** 2).sum()), 2 * pull * (given - origin)
        for example in examples:
            kept, kept_terms = example.marked.likelihood(given)
            whole, whole_terms = example.every.likelihood(given)
            total += example.share * (whole - kept)
            slope = slope + example.share * (kept_terms - whole_terms)
        return total, slope[free]

    found = minimize(
        loss,
        origin[free],
        jac=True,
        method="L-BFGS-B",
        bounds=[(0.0, LARGEST)] * int(free.sum()),
        options={"maxiter": steps},
    )
    return Costs(**as_weights(origin, free, found.x))


def as_weights(origin: np.ndarray, free: np.ndarray, values: np.ndarray) -> Mapping[str, float]:
    """Weights by name, those that are free replaced."""
    result = origin.copy()
    result[free] = values
    return {name: round(float(value), 3) for name, value in zip(NAMES, result, strict=True)}
