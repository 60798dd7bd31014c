"""The search's costs written down a second time, note by note, and every way through a piece."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations, product
from math import hypot, inf

from roboguitarist.fingering.costs import (
    FRESH_S,
    FRET_M,
    GRID,
    JUMP_S,
    JUMP_S_M,
    KEEP,
    RING_MOMENTS,
    RING_S,
    SHIFT_S,
    SHIFT_S_M,
    Costs,
)
from roboguitarist.fingering.grips import LEFT_OUT, MOST_FRETS_APART
from roboguitarist.fingering.trellis import Moment

TICK_S = 5e-6


@dataclass(frozen=True)
class Stop:
    """A note that a finger holds or has held."""

    string: int
    fret: int
    moment: int
    onset_s: float
    end_s: float
    again_s: float


@dataclass(frozen=True)
class Hand:
    """The state between two moments."""

    fingers: dict[int, Stop] = field(default_factory=dict)
    position: int | None = None
    after_open: bool = False


@dataclass(frozen=True)
class Grip:
    """One form: for each finger its fret, strings and what it holds longest."""

    fret: dict[int, int]
    strings: dict[int, list[int]]
    stop: dict[int, Stop]
    opened: set[int]
    left_out: int

    @property
    def position(self) -> int | None:
        homes = [fret - finger + 1 for finger, fret in self.fret.items()]
        return (2 * sum(homes) + len(homes)) // (2 * len(homes)) if homes else None


def grip_of(moment: Moment, number: int, places, fingers) -> Grip:
    fret, strings, stop, opened = {}, {}, {}, set()
    for (string, f), finger, end_s, again_s in zip(
        places, fingers, moment.end_s, moment.again_s, strict=True
    ):
        if finger > 0:
            fret[finger] = f
            strings.setdefault(finger, []).append(string)
            new = Stop(string, f, number, moment.onset_s, end_s, again_s)
            if finger not in stop or end_s > stop[finger].end_s:
                stop[finger] = new
        elif finger == 0:
            opened.add(string)
    return Grip(fret, strings, stop, opened, fingers.count(LEFT_OUT))


Down = tuple[int, int, list[int]]
"""A finger, its fret and its strings."""


def pair(costs: Costs, lower: Down, higher: Down) -> float:
    """Two fingers down together."""
    (a, fret_a, on_a), (b, fret_b, on_b) = lower, higher
    excess = fret_b - fret_a - (b - a)
    wide = costs.stretch if a == 1 else costs.spread
    cost = wide * max(excess, 0) + costs.squeeze * max(-excess, 0)
    if fret_a == fret_b:
        cost += costs.crossed * (max(on_a) < min(on_b))
        near = min(on_b) - max(on_a) == 1 or min(on_a) - max(on_b) == 1
        cost += costs.tight * near
    return cost


class Piece:
    """All that a step's cost depends on beside the state and the form."""

    def __init__(self, moments: list[Moment], nut_fret: int | None, costs: Costs, memory: int):
        self.moments, self.nut_fret, self.costs, self.memory = moments, nut_fret, costs, memory

    def alone(self, grip: Grip) -> float:
        c = self.costs
        cost = sum((c.index, c.middle, c.ring, c.little)[finger - 1] for finger in grip.fret)
        cost += c.left_out * grip.left_out
        flat = [s for s in grip.strings.values() if len(s) > 1]
        cost += c.barre * bool(flat)
        cost += sum(c.barre_strings * (max(s) - min(s) + 1) for s in flat)
        if self.nut_fret is not None and grip.position is not None:
            cost += c.nut * max(0, self.nut_fret + 1 - grip.position)
            cost += c.away * max(0, grip.position - self.nut_fret - 1)
        for a, b in combinations(sorted(grip.fret), 2):
            on_a, on_b = grip.strings[a], grip.strings[b]
            cost += pair(c, (a, grip.fret[a], on_a), (b, grip.fret[b], on_b))
        return cost

    def _margin(self, k: int) -> float:
        """Time before moment k in which the fingers of the moment before may have left."""
        if k < 1:
            return inf
        before, now_s = self.moments[k - 1], self.moments[k].onset_s
        sounding_s = min(max(before.end_s), now_s) - before.onset_s
        return now_s - before.onset_s - KEEP * sounding_s

    def move(self, hand: Hand, k: int, grip: Grip) -> float:
        if hand.position is None or grip.position is None or hand.position == grip.position:
            return 0.0
        c, frets = self.costs, abs(grip.position - hand.position)
        now_s = self.moments[k].onset_s
        step_s = now_s - self.moments[k - 1].onset_s
        if hand.after_open:
            cost = c.free * frets
            margin_s = step_s + self._margin(k - 1)
        else:
            cost = c.speed * frets * FRET_M / step_s
            cost += c.nudge if frets == 1 else c.shift + c.distance * frets
            margin_s = self._margin(k)
        if frets > 1:
            needed_s = SHIFT_S + SHIFT_S_M * FRET_M * frets
            cost += c.hurried * min(max(1 - margin_s / needed_s, 0.0), 1.0)
        return cost

    def _rings_until(self, stop: Stop) -> float:
        later = stop.moment + RING_MOMENTS
        onset_s = self.moments[later].onset_s if later < len(self.moments) else inf
        return min(stop.onset_s + RING_S, onset_s)

    def _open(self, k: int) -> set[int]:
        """Strings that ring open at moment k or begin to."""
        until = {}
        for moment in self.moments[: k + 1]:
            places, _ = moment.forms[0]
            for (string, fret), end_s in zip(places, moment.end_s, strict=True):
                until[string] = 0.0 if fret else end_s
        return {s for s, end_s in until.items() if end_s > self.moments[k].onset_s + TICK_S}

    def meet(self, finger: int, stop: Stop, k: int, grip: Grip) -> tuple[float, Stop | None]:
        """What it costs that a finger comes from a stop, and what it knows afterwards."""
        c, now_s = self.costs, self.moments[k].onset_s
        sounds = stop.end_s > now_s + TICK_S
        planted = not sounds and stop.again_s > now_s + TICK_S
        rings = not (sounds or planted) and self._rings_until(stop) > now_s + TICK_S
        touched = grip.opened | {s for strings in grip.strings.values() for s in strings}
        cost, leaves, after = 0.0, False, stop
        if finger in grip.fret:
            cost, leaves, after = self._goes(finger, stop, k, grip, sounds or planted)
        else:
            apart = [self._apart(finger, stop, other, grip) for other in grip.fret]
            conflict = not all(apart)
            leaves = (sounds or planted) and stop.string in touched
            leaves |= (sounds or planted or rings) and conflict
            if leaves:
                after = None
            elif sounds or planted:
                cost += sum(self._beside(finger, stop, other, grip) for other in grip.fret)
        for other, fret in grip.fret.items():
            on = grip.strings[other]
            if other != finger and fret == stop.fret and min(on) <= stop.string <= max(on):
                cost += c.changed
        if leaves:
            missing = (stop.end_s - now_s) / (stop.end_s - stop.onset_s)
            cost += sounds * (c.cut * missing + c.lost * (missing > 1 - 2 / 3))
            cost += planted * c.replanted + (rings and stop.string not in touched) * c.lifted
        return cost, after

    def _goes(self, finger: int, stop: Stop, k: int, grip: Grip, held: bool):
        c, fret, on = self.costs, grip.fret[finger], grip.strings[finger]
        new = grip.stop[finger]
        if fret == stop.fret and min(on) <= stop.string <= max(on):
            return 0.0, False, stop if stop.end_s > new.end_s else new
        under = set(range(1, max(stop.string, *on)))
        free = not under & (grip.opened | self._open(k))
        if fret == stop.fret and held and finger == 1 and free:
            return c.flattened, False, stop if stop.end_s > new.end_s else new
        now_s = self.moments[k].onset_s
        fresh = min(max(1 - (now_s - stop.end_s) / FRESH_S, 0.0), 1.0)
        if set(on) == {stop.string}:
            return fresh * (c.slide if abs(fret - stop.fret) <= 2 else c.guide), True, new
        cost = fresh * (c.hop if fret == stop.fret else c.jump)
        margin_s = now_s - stop.onset_s - KEEP * (min(stop.end_s, now_s) - stop.onset_s)
        way_m = hypot(FRET_M * (fret - stop.fret), 0.009 * (min(on) - stop.string))
        cost += c.rushed * min(max(1 - margin_s / (JUMP_S + JUMP_S_M * way_m), 0.0), 1.0)
        return cost, True, new

    @staticmethod
    def _apart(finger: int, stop: Stop, other: int, grip: Grip) -> bool:
        """Whether a finger on its stop and another finger of the grip can be down together."""
        if finger < other:
            return 0 <= grip.fret[other] - stop.fret <= MOST_FRETS_APART[finger, other]
        return 0 <= stop.fret - grip.fret[other] <= MOST_FRETS_APART[other, finger]

    def _beside(self, finger: int, stop: Stop, other: int, grip: Grip) -> float:
        mine = finger, stop.fret, [stop.string]
        yours = other, grip.fret[other], grip.strings[other]
        return pair(self.costs, min(mine, yours), max(mine, yours))

    def step(self, hand: Hand, k: int, grip: Grip) -> tuple[float, Hand]:
        """Cost of a form, and the state after it."""
        cost = rounded(self.alone(grip)) + rounded(self.move(hand, k, grip))
        after = dict(grip.stop)
        for finger, stop in hand.fingers.items():
            more, known = self.meet(finger, stop, k, grip)
            cost += rounded(more)
            if known is not None:
                after[finger] = known
        kept = {f: stop for f, stop in after.items() if self._known(stop, k + 1)}
        position = hand.position if grip.position is None else grip.position
        return cost, Hand(kept, position, grip.position is None)

    def _known(self, stop: Stop, k: int) -> bool:
        if k >= len(self.moments):
            return False
        until_s = max(stop.end_s, stop.again_s, self._rings_until(stop))
        return until_s - TICK_S > self.moments[k].onset_s or stop.moment >= k - self.memory

    def all_ways(self):
        """Costs of the steps of every way through the piece."""
        grips = [[grip_of(m, k, *f) for f in m.forms] for k, m in enumerate(self.moments)]
        for way in product(*grips):
            hand, costs = Hand(), []
            for k, grip in enumerate(way):
                cost, hand = self.step(hand, k, grip)
                costs.append(cost)
            yield costs


def rounded(cost: float) -> float:
    return round(cost * GRID) / GRID
