"""The search over a whole tablature, and what it says in the end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fingering.costs import HANDS, LEAST, Costs
from roboguitarist.fingering.given import moments
from roboguitarist.fingering.grips import LEFT_OUT
from roboguitarist.fingering.onsets import chords, excluded, released
from roboguitarist.fingering.paper import paper
from roboguitarist.fingering.reach import Reach
from roboguitarist.fingering.result import SIMULTANEOUS_S, UNPLAYABLE, Fingering, describe
from roboguitarist.fingering.right import right_hand
from roboguitarist.fingering.search import Way, search
from roboguitarist.fingering.settings import Setting, setting
from roboguitarist.fingering.terms import finger_terms
from roboguitarist.fingering.trellis import NOWHERE
from roboguitarist.guitar import PRESETS, Guitar
from roboguitarist.tablature import Tablature

METHODS = ("search", "paper")
OBJECTIVES = ("sum", "hardest")
MEMORY = 3
"""For how many onsets a finger that was lifted counts as being where it was."""


def assign(
    tablature: Tablature,
    guitar: Guitar = PRESETS["classical"],
    method: str = "paper",
    *,
    hand: str = "robot",
    objective: str = "sum",
    reach: Reach | None = None,
) -> Fingering:
    """Choose a finger of each hand for every note.

    The method `search` finds the left fingers that make the whole piece cheapest, as reckoned by
    `costs.Costs`; `paper` is the greedy rule of `paper.paper`. Left fingers marked in the score
    are kept where a hand can do what they say.

    Args:
        tablature: What is asked.
        guitar: Its number of frets is the limit.
        method: `search`, as a guitarist would, or `paper`, which the simulated hands play better
            so far: the default, until they can do what a guitarist does.
        hand: Whose costs count: those of the simulated hand (`robot`) or of a guitarist
            (`human`).
        objective: `sum`, or `hardest` to make the hardest moment as easy as can be first.
        reach: What the simulated hand can hold, if known.

    Raises:
        RoboGuitaristError: If there is no such method, hand or objective.
    """
    for what, name, names in (
        ("fingering method", method, METHODS),
        ("hand", hand, tuple(HANDS)),
        ("objective", objective, OBJECTIVES),
    ):
        if name not in names:
            raise RoboGuitaristError(f"no {what} {name!r} (there is {', '.join(names)})")
    if method == "paper":
        return paper(tablature, guitar)
    return by_search(tablature, guitar, HANDS[hand], objective == "hardest", reach)


def by_search(
    tablature: Tablature,
    guitar: Guitar,
    costs: Costs,
    hardest: bool = False,
    reach: Reach | None = None,
) -> Fingering:
    """The fingers that cost least; arguments as in `assign`."""
    notes, count = tablature.notes, len(tablature.notes)
    onsets = moments(tablature, guitar)
    nut_fret = tablature.capo if any(not note.fret for note in notes) else None
    everything = setting(onsets, nut_fret, reach)
    way = search(everything, costs, MEMORY, hardest)
    left = np.full(count, UNPLAYABLE, np.int8)
    hold_position, difficulty = np.zeros(count, np.int8), np.zeros(count, np.float32)
    positions = _positions(everything.forms.position[way.form], tablature.capo + 1, guitar.n_frets)
    for moment, form, position, cost in zip(onsets, way.form, positions, way.cost, strict=True):
        chord, fingers = list(moment.notes), everything.forms.finger[form, : len(moment.notes)]
        left[chord], hold_position[chord], difficulty[chord] = fingers, position, cost
    holding = _follow(tablature, everything, way)
    _stand_still(tablature, hold_position, left)
    right, strum = right_hand(tablature)
    return Fingering(
        tablature,
        left,
        right,
        holding.barre,
        hold_position,
        release_s=holding.release_s,
        strum=strum,
        difficulty=difficulty,
        problems=_problems(tablature, guitar, left, holding),
        method="search",
    )


def _positions(position: np.ndarray, lowest: int, highest: int) -> np.ndarray:
    """Hold positions (K,): where nothing is stopped the hand stays, or waits at its first place."""
    known = np.flatnonzero(position != NOWHERE)
    if not known.size:
        return np.full(len(position), lowest)
    last = np.maximum(np.searchsorted(known, np.arange(len(position)), side="right") - 1, 0)
    return np.clip(position[known[last]], lowest, highest)


def _stand_still(tablature: Tablature, hold_position: np.ndarray, left: np.ndarray) -> None:
    """Notes that were excluded get the position of the note before."""
    last = tablature.capo + 1
    for index in range(len(left)):
        last = hold_position[index] = hold_position[index] or last


@dataclass(frozen=True)
class _Turn:
    """A finger of the way leaves a note early, or stays on it when another joins it."""

    cut: bool
    stays: bool


def _turns(everything: Setting, way: Way, finger: int) -> dict[int, _Turn]:
    """What happens to the stop of a finger (from 1), for the moments at which something does."""
    at = np.flatnonzero(way.stop[:, finger - 1] >= 0)
    stop, numbers = way.stop[at, finger - 1], np.full(len(at), finger)
    terms, _, stays = finger_terms(everything, at, numbers, stop, way.form[at])
    cut = terms["cut"] > 0
    return {int(at[k]): _Turn(bool(cut[k]), bool(stays[k])) for k in np.flatnonzero(cut | stays)}


@dataclass(frozen=True)
class _Holding:
    """How long notes are held.

    Attributes:
        release_s: (n,) when the finger leaves.
        barre: (n,) the finger lies flat.
        causes: For notes that are let go early, the note that the hand is needed for.
    """

    release_s: np.ndarray
    barre: np.ndarray
    causes: dict[int, int]


def _follow(tablature: Tablature, everything: Setting, way: Way) -> _Holding:
    """Follow each finger through the piece, with all notes that are under it."""
    release_s = np.array(released(tablature), float)
    barre, causes = np.zeros(len(release_s), bool), {}
    forms = everything.forms
    for finger in range(1, 5):
        turns, under = _turns(everything, way, finger), []
        for k, form in enumerate(way.form):
            fingers, now_s = forms.finger[form], forms.onset_s[k]
            turn = turns.get(k, _Turn(False, False))
            new = forms.note[form][fingers == finger].tolist()
            sounding = [note for note in under if release_s[note] > now_s + SIMULTANEOUS_S]
            if turn.cut:
                needed_for = new or forms.note[form][fingers > 0].tolist()
                release_s[sounding] = now_s
                causes |= dict.fromkeys(sounding, needed_for[0])
            if new:
                under = sounding + new if turn.stays else new
                if len({tablature.notes[note].string for note in under}) > 1:
                    barre[under] = True
    return _Holding(release_s, barre, causes)


def _problems(
    tablature: Tablature, guitar: Guitar, left: np.ndarray, holding: _Holding
) -> tuple[str, ...]:
    notes, reasons = tablature.notes, {}
    frets = range(tablature.capo + 1, guitar.n_frets + 1)
    for chord in chords(notes):
        reasons |= excluded(tablature, chord, frets)
    full_s = released(tablature)
    for index, (note, finger) in enumerate(zip(notes, left, strict=True)):
        length_s = full_s[index] - note.onset_s
        missing = (full_s[index] - holding.release_s[index]) / length_s if length_s > 0 else 0.0
        if index in reasons:
            continue
        if finger == LEFT_OUT:
            reasons[index] = _out_of_reach(tablature, left, index)
        elif note.left_finger not in (None, finger):
            reasons[index] = f"marked for finger {note.left_finger}, played by finger {finger}"
        elif missing > 1.0 - LEAST:
            reason = f"let go after {1 - missing:.0%} of its length"
            reasons[index] = f"{reason} for {describe(notes[holding.causes[index]])}"
    return tuple(f"{describe(notes[index])}: {reasons[index]}" for index in sorted(reasons))


def _out_of_reach(tablature: Tablature, left: np.ndarray, index: int) -> str:
    """Why a note is the one that is left out of its chord."""
    onset_s = tablature.notes[index].onset_s
    together = [
        (note, finger)
        for note, finger in zip(tablature.notes, left, strict=True)
        if abs(note.onset_s - onset_s) <= SIMULTANEOUS_S
    ]
    fingers = {finger for _, finger in together if finger > 0}
    if len(fingers) == 4:
        return "all four fingers are in use, leave this note out"
    frets = sorted({tablature.stopped_fret(note) for note, finger in together if finger > 0})
    return f"out of reach of a hand at fret {', '.join(map(str, frets))}, leave this note out"
