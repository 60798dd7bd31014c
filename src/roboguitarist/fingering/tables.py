"""Tables of what each step of the search costs and where it leads, for many moments at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from roboguitarist.fingering.costs import Terms
from roboguitarist.fingering.result import SIMULTANEOUS_S
from roboguitarist.fingering.settings import Setting
from roboguitarist.fingering.terms import finger_terms, form_terms, move_terms, ring_terms
from roboguitarist.fingering.trellis import NOWHERE

LOWEST_POSITION = -4
N_POSITIONS = 36
N_HANDS = 2 * N_POSITIONS
"""Rows for the hand: its position, the first for none, and whether the onset before was open."""
N_RINGS = 64
"""Rows for the strings that ring open, a bit each; used only where strings are free."""
BLOCK = 256
Price = Callable[[Terms], np.ndarray]
"""What terms (n,) cost: (n,), or (n, ...) for several costs at once."""


@dataclass(frozen=True)
class Live:
    """Stops that fingers may hold or know of when each of K moments comes.

    Attributes:
        first: (K + 2,) where the rows of each moment begin; the last is for after the piece.
        stop: (L,) index of the stop; -1 in the first row of every moment, for no stop.
        following: (L,) the stop's row at the next moment, 0 if it is forgotten by then.
        new: (F, 4) row of each form's stops at the next moment, 0 for unused fingers.
    """

    first: np.ndarray
    stop: np.ndarray
    following: np.ndarray
    new: np.ndarray

    @property
    def width(self) -> int:
        """Largest number of rows."""
        return int(np.diff(self.first).max(initial=1))


def live_stops(setting: Setting, memory: int) -> Live:
    """Find the stops that still sound, or belong to one of the last `memory` moments."""
    forms, stops = setting.forms, setting.stops
    n_moments = len(forms.onset_s)
    begun = np.searchsorted(stops.moment, np.arange(n_moments + 1)).tolist()
    until_s = np.maximum(np.maximum(stops.end_s, stops.again_s), stops.ring_s)
    until = (until_s - SIMULTANEOUS_S).tolist()
    origin, now = stops.moment.tolist(), [*forms.onset_s.tolist(), np.inf]
    row = np.zeros(len(stops.moment) + 1, int)
    alive, rows, following, first = [-1], [-1], [], [0]
    for k in range(n_moments):
        candidates = alive + list(range(begun[k], begun[k + 1]))
        known = k + 1 - memory
        alive = [e for e in candidates if e < 0 or until[e] > now[k + 1] or origin[e] >= known]
        where = {stop: index for index, stop in enumerate(alive)}
        following += [where.get(stop, 0) for stop in rows[first[-1] :]]
        first.append(len(rows))
        for stop in range(begun[k], begun[k + 1]):
            row[stop] = where.get(stop, 0)
        rows += alive
    first.append(len(rows))
    following += [0] * (len(rows) - len(following))
    return Live(np.array(first), np.array(rows), np.array(following), row[forms.stop])


@dataclass(frozen=True)
class Table:
    """Step of one moment with C forms: the sum of one row for each finger and one for the hand.

    Attributes:
        n_live: Rows for each finger.
        cost: (4 n_live + N_HANDS + N_RINGS, C), or more if several costs were asked for.
        key: (4 n_live + N_HANDS + N_RINGS, C) int64; sums to the number of the next state.
    """

    n_live: int
    cost: np.ndarray
    key: np.ndarray

    @property
    def offsets(self) -> np.ndarray:
        """First rows (6,) of the fingers, the hand and the open strings."""
        return np.array([*(k * self.n_live for k in range(5)), 4 * self.n_live + N_HANDS])


def hand_row(position: np.ndarray, after_open: np.ndarray) -> np.ndarray:
    """Row for a hand in a table's last `N_HANDS`."""
    place = np.where(position == NOWHERE, 0, position - LOWEST_POSITION)
    return 2 * place + after_open


def hand_of(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and whether the onset before was open, for rows of `hand_row`."""
    place, after_open = np.divmod(row, 2)
    return np.where(place, place + LOWEST_POSITION, NOWHERE), after_open.astype(bool)


def weights(width: int) -> np.ndarray:
    """Place values (6,) of the rows of fingers, hand and open strings in a state's number."""
    hands = N_HANDS * N_RINGS
    return np.array([hands * width**k for k in range(4)] + [N_RINGS, 1], np.int64)


def tables(setting: Setting, price: Price, live: Live) -> Iterator[Table]:
    """The table of every moment, in order."""
    n_moments = len(setting.forms.onset_s)
    for start in range(0, n_moments, BLOCK):
        yield from _block(setting, price, live, start, min(start + BLOCK, n_moments))


def _block(setting: Setting, price: Price, live: Live, start: int, stop: int) -> Iterator[Table]:
    forms = setting.forms
    n_forms = np.diff(forms.first)[start:stop]
    n_live = np.diff(live.first)[start:stop]
    n_rings = N_RINGS if setting.free else 1
    sizes = (4 * n_live + N_HANDS + n_rings) * n_forms
    owner, within = _ragged(sizes)
    row, column = np.divmod(within, n_forms[owner])
    form = forms.first[start + owner] + column
    cost = np.zeros((len(owner), *price({}).shape))
    key = np.zeros(len(owner), np.int64)
    hands = 4 * n_live[owner]
    kinds = (row < hands, (row >= hands) & (row < hands + N_HANDS), row >= hands + N_HANDS)
    for select, fill in zip(kinds, (_fingers, _hands, _rings), strict=True):
        at = np.flatnonzero(select)
        entries = _Entries(start + owner[at], row[at], form[at])
        cost[at], key[at] = fill(setting, price, live, entries)
    offset = np.concatenate([[0], np.cumsum(sizes)])
    for k in range(stop - start):
        part, shape = slice(offset[k], offset[k + 1]), (-1, int(n_forms[k]))
        costs = cost[part].reshape(*shape, *cost.shape[1:])
        yield Table(int(n_live[k]), costs, key[part].reshape(shape))


@dataclass(frozen=True)
class _Entries:
    """Entries (n,) of tables: their moments, rows and forms."""

    moment: np.ndarray
    row: np.ndarray
    form: np.ndarray


def _ragged(sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Owner and place within it of every item of groups of these sizes."""
    owner = np.repeat(np.arange(len(sizes)), sizes)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(sizes) - sizes, sizes)


def _fingers(
    setting: Setting, price: Price, live: Live, entries: _Entries
) -> tuple[np.ndarray, np.ndarray]:
    moment, row, form = entries.moment, entries.row, entries.form
    stops = setting.stops
    finger, line = np.divmod(row, np.diff(live.first)[moment])
    line += live.first[moment]
    new, following = live.new[form, finger], np.zeros(len(row), int)
    cost = np.zeros((len(row), *price({}).shape))
    at = np.flatnonzero(live.stop[line] >= 0)
    stop = live.stop[line[at]]
    terms, known, stays = finger_terms(setting, moment[at], finger[at] + 1, stop, form[at])
    cost[at] = price(terms)
    # A finger that lies on several notes holds what ends last.
    longer = stays & (stops.end_s[stop] > stops.end_s[setting.forms.stop[form[at], finger[at]]])
    following[at] = np.where(known | longer, live.following[line[at]], 0)
    digit = np.where(following > 0, following, new)
    return cost, digit * weights(live.width)[finger]


def _hands(
    setting: Setting, price: Price, live: Live, entries: _Entries
) -> tuple[np.ndarray, np.ndarray]:
    moment, row, form = entries.moment, entries.row, entries.form
    hand = row - 4 * np.diff(live.first)[moment]
    before, after_open = hand_of(hand)
    first, last = int(form.min()), int(form.max()) + 1
    alone = price(form_terms(setting, np.arange(first, last)))
    cost = alone[form - first]
    cost += price(move_terms(setting, moment, before, after_open, form))
    position = setting.forms.position[form]
    is_open = position == NOWHERE
    return cost, weights(live.width)[4] * hand_row(np.where(is_open, before, position), is_open)


def _rings(
    setting: Setting, price: Price, live: Live, entries: _Entries
) -> tuple[np.ndarray, np.ndarray]:
    moment, row, form = entries.moment, entries.row, entries.form
    if not setting.free:
        return np.zeros((len(row), *price({}).shape)), np.zeros(len(row), np.int64)
    ringing = row - 4 * np.diff(live.first)[moment] - N_HANDS
    touched, opened = setting.forms.touched[form], setting.forms.opened[form]
    still = np.append(setting.open_strings[1:], 0)[moment]
    return price(ring_terms(setting, ringing, form)), (ringing & ~touched | opened) & still
