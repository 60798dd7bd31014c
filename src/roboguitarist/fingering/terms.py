"""The terms of the costs, computed for many forms, fingers and moments at once."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from roboguitarist.fingering.costs import (
    FRESH_S,
    FRET_M,
    JUMP_S,
    JUMP_S_M,
    KEEP,
    LEAST,
    SHIFT_S,
    SHIFT_S_M,
    Terms,
)
from roboguitarist.fingering.grips import LEFT_OUT, MOST_FRETS_APART
from roboguitarist.fingering.meeting import Down, down, meet, pair_terms
from roboguitarist.fingering.settings import Setting
from roboguitarist.fingering.trellis import NOWHERE

MOST_APART = np.zeros((5, 5), int)
for (_low, _high), _frets in MOST_FRETS_APART.items():
    MOST_APART[_low, _high] = _frets


def form_terms(s: Setting, form: np.ndarray) -> Terms:
    """Terms of forms (n,) alone."""
    forms = s.forms
    treble, bass = forms.treble[form], forms.bass[form]
    finger, fret = forms.finger[form], forms.fret[form]
    used = forms.at[form] > 0
    flat = used & (bass > treble)
    terms: Terms = {
        name: used[:, k].astype(float)
        for k, name in enumerate(("index", "middle", "ring", "little"))
    }
    terms["barre"] = flat.any(axis=1).astype(float)
    terms["barre_strings"] = (flat * (bass - treble + 1)).sum(axis=1).astype(float)
    terms["left_out"] = (finger == LEFT_OUT).sum(axis=1).astype(float)
    if s.nut_fret is not None:
        behind = np.maximum(s.nut_fret + 1 - forms.position[form], 0)
        terms["nut"] = np.where(used.any(axis=1), behind, 0).astype(float)
        terms["away"] = np.maximum(forms.position[form] - s.nut_fret - 1, 0).astype(float)
    if s.free:
        terms["stopped"] = (finger > 0).sum(axis=1).astype(float)
        terms["height"] = (fret * (finger > 0)).sum(axis=1).astype(float)
    if s.reach is not None:
        terms["unheld"] = s.reach.missing(finger, forms.string[form], fret)
    for a, b in combinations(range(4), 2):
        low, high = down(forms, form, a + 1), down(forms, form, b + 1)
        _add(terms, pair_terms(low, high), used[:, a] & used[:, b])
    return terms


def move_terms(
    s: Setting, moment: np.ndarray, before: np.ndarray, after_open: np.ndarray, form: np.ndarray
) -> Terms:
    """Terms of the hand's way to forms (n,).

    Args:
        s: The piece.
        moment: (n,) of the forms.
        before: (n,) position so far, or `NOWHERE`.
        after_open: (n,) bool, the onset before has open strings only.
        form: (n,).
    """
    position = s.forms.position[form]
    moved = (position != NOWHERE) & (before != NOWHERE)
    frets = np.where(moved, np.abs(position - before), 0).astype(float)
    which = after_open.astype(int)
    stay, far = ~after_open, frets >= 2
    needed_s = SHIFT_S + SHIFT_S_M * FRET_M * frets
    late = np.clip(1.0 - s.margin_s[moment, which] / needed_s, 0.0, 1.0)
    return {
        "nudge": (stay & (frets == 1)).astype(float),
        "shift": (stay & far).astype(float),
        "distance": frets * (stay & far),
        "speed": frets * stay * FRET_M / s.step_s[moment, which],
        "free": frets * after_open,
        "hurried": late * far,
    }


def ring_terms(s: Setting, ringing: np.ndarray, form: np.ndarray) -> Terms:
    """Terms of open strings, as bits (n,), that ring when forms (n,) come."""
    taken = ringing & s.forms.touched[form] & ~s.forms.opened[form]
    return {"silenced": np.bitwise_count(taken).astype(float)}


def finger_terms(
    s: Setting, moment: np.ndarray, finger: np.ndarray, stop: np.ndarray, form: np.ndarray
) -> tuple[Terms, np.ndarray, np.ndarray]:
    """Terms of fingers (n,) that are, or were, on stops (n,) when forms (n,) come.

    Returns:
        The terms; bool (n,) the finger still knows the stop afterwards; bool (n,) it stays on it
        when the form gives it a note.
    """
    m = meet(s, moment, finger, stop, form)
    string, fret, now_s = s.stops.string[stop], s.stops.fret[stop], s.forms.onset_s[moment]
    onset_s, end_s = s.stops.onset_s[stop], s.stops.end_s[stop]
    terms: Terms = {}
    changed, conflict = np.zeros(len(form), bool), np.zeros(len(form), bool)
    mine = Down(finger, fret, string, string)
    pairs = []
    for number in range(1, 5):
        other = down(s.forms, form, number)
        present = (other.fret > 0) & (finger != number)
        low, high = mine.lower(other, finger < number), mine.lower(other, finger > number)
        apart = high.fret - low.fret
        conflict |= present & ((apart < 0) | (apart > MOST_APART[low.finger, high.finger]))
        changed |= present & other.covers(string, fret)
        pairs.append((low, high, present))
    dropped = ~m.used & (m.held & m.taken | (m.held | m.rings) & conflict)
    for low, high, present in pairs:
        _add(terms, pair_terms(low, high), m.held & ~m.used & ~dropped & present)
    fresh = np.clip(1.0 - (now_s - end_s) / FRESH_S, 0.0, 1.0)
    left = m.moved | dropped
    missing = (end_s - now_s) / (end_s - onset_s)
    terms |= {
        "guide": fresh * (m.along & ~m.near),
        "slide": fresh * (m.along & m.near),
        "hop": fresh * (m.across & m.same_fret),
        "jump": fresh * (m.across & ~m.same_fret),
        "rushed": m.across * _rush(onset_s, end_s, now_s, m.way_m),
        "flattened": m.flat,
        "changed": changed,
        "cut": (m.sounds & left) * missing,
        "lost": m.sounds & left & (missing > 1.0 - LEAST),
        "replanted": m.planted & left,
        "lifted": m.rings & ~m.taken & left,
    }
    return terms, ~m.used & ~dropped, m.flat | m.stays


def _rush(
    onset_s: np.ndarray, end_s: np.ndarray, now_s: np.ndarray, way_m: np.ndarray
) -> np.ndarray:
    """Share of the time missing that a finger needs to go to another place."""
    margin_s = now_s - onset_s - KEEP * (np.minimum(end_s, now_s) - onset_s)
    return np.clip(1.0 - margin_s / (JUMP_S + JUMP_S_M * way_m), 0.0, 1.0)


def _add(terms: Terms, more: Terms, where: np.ndarray) -> None:
    """Add terms where they count."""
    for name, values in more.items():
        terms[name] = terms.get(name, 0.0) + np.where(where, values, 0.0)
