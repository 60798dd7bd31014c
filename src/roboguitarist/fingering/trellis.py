"""The search's material: what can be played at each onset, as flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from roboguitarist.fingering.costs import RING_MOMENTS, RING_S
from roboguitarist.fingering.grips import LEFT_OUT, Grip, Place

MAX_CHORD = 6
Form = tuple[tuple[Place, ...], Grip]
"""Places of the notes of an onset, and the fingers that stop them."""


@dataclass(frozen=True, slots=True)
class Moment:
    """One onset.

    Attributes:
        onset_s: When.
        notes: Numbers of the notes that begin.
        end_s: When each of them ends.
        again_s: When each of them comes again soon, so that its finger had better stay; else 0.
        forms: What can be done; a place (0, 0) and `LEFT_OUT` for a note that is not played.
    """

    onset_s: float
    notes: tuple[int, ...]
    end_s: tuple[float, ...]
    again_s: tuple[float, ...]
    forms: Sequence[Form]


@dataclass(frozen=True)
class Forms:
    """What can be done at K moments: F forms in all, one moment after the other.

    Attributes:
        first: (K + 1,) where the forms of each moment begin.
        finger, string, fret, note: (F, 6) for each note of the form; finger 0 where there is
            none, -1 for a note left out.
        at: (F, 4) fret that each finger stops, 0 if none.
        treble, bass: (F, 4) first and last string under each finger.
        stop: (F, 4) index into the stops of the note that each finger holds longest, or -1.
        position: (F,) fret of the index finger that suits the form, `NOWHERE` if nothing is
            stopped.
        opened, touched: (F,) bit string - 1 is set for open strings, and for all strings played.
        onset_s: (K,).
    """

    first: np.ndarray
    finger: np.ndarray
    string: np.ndarray
    fret: np.ndarray
    note: np.ndarray
    at: np.ndarray
    treble: np.ndarray
    bass: np.ndarray
    stop: np.ndarray
    position: np.ndarray
    opened: np.ndarray
    touched: np.ndarray
    onset_s: np.ndarray


@dataclass(frozen=True)
class Stops:
    """Every place at which some form stops some note.

    Attributes:
        string, fret, moment, note: (S,) int.
        onset_s, end_s, again_s, ring_s: (S,) when the note begins, ends, comes again (or 0), and
            how long it could ring.
    """

    string: np.ndarray
    fret: np.ndarray
    moment: np.ndarray
    note: np.ndarray
    onset_s: np.ndarray
    end_s: np.ndarray
    again_s: np.ndarray
    ring_s: np.ndarray


NOWHERE = -100
_STRINGS, _FRETS = 8, 64


def lay_out(moments: Sequence[Moment]) -> tuple[Forms, Stops]:
    """The moments' forms and stops as arrays."""
    counts = [len(moment.forms) for moment in moments]
    rows = [form for moment in moments for form in moment.forms]
    finger = _padded([grip for _, grip in rows]).astype(int)
    string = _padded([[s for s, _ in places] for places, _ in rows]).astype(int)
    fret = _padded([[f for _, f in places] for places, _ in rows]).astype(int)
    owner = np.repeat(np.arange(len(moments)), counts)
    under = finger[:, None, :] == np.arange(1, 5)[None, :, None]  # (F, 4, 6)
    used = under.any(axis=2)
    at = (under * fret[:, None, :]).max(axis=2)
    treble = np.where(used, np.where(under, string[:, None, :], _STRINGS).min(axis=2), 0)
    bits = 1 << np.maximum(string - 1, 0)
    forms = Forms(
        first=np.concatenate([[0], np.cumsum(counts, dtype=int)]),
        finger=finger,
        string=string,
        fret=fret,
        note=_padded([moment.notes for moment in moments]).astype(int)[owner],
        at=at,
        treble=treble,
        bass=(under * string[:, None, :]).max(axis=2),
        stop=np.zeros_like(at),
        position=_position(at, used),
        opened=(bits * ((string > 0) & (finger == 0))).sum(axis=1),
        touched=(bits * ((string > 0) & (finger != LEFT_OUT))).sum(axis=1),
        onset_s=np.array([moment.onset_s for moment in moments], float),
    )
    end_s = _padded([moment.end_s for moment in moments])[owner]
    longest = np.where(under, end_s[:, None, :], -np.inf).argmax(axis=2)
    stop, stops = _stops(forms, moments, longest)
    return replace(forms, stop=stop), stops


def _padded(rows: Sequence[Sequence[float]]) -> np.ndarray:
    """Rows of up to `MAX_CHORD` numbers as one array (n, `MAX_CHORD`), with zeros behind."""
    pad = [(0.0,) * (MAX_CHORD - n) for n in range(MAX_CHORD + 1)]
    return np.array([(*row, *pad[len(row)]) for row in rows], float).reshape(-1, MAX_CHORD)


def _position(at: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Mean of the frets at which the fingers in use want the index finger, rounded."""
    count = used.sum(axis=1)
    homes = (used * (at - np.arange(4))).sum(axis=1)
    return np.where(count, (2 * homes + count) // np.maximum(2 * count, 1), NOWHERE)


def _stops(
    forms: Forms, moments: Sequence[Moment], longest: np.ndarray
) -> tuple[np.ndarray, Stops]:
    """Index (F, 4) of the stop that each finger holds, and the stops.

    Args:
        forms: Without that index.
        moments: The same moments.
        longest: (F, 4) which note of the moment each finger holds longest.
    """
    owner = np.repeat(np.arange(len(moments)), np.diff(forms.first))
    string, fret = (np.take_along_axis(a, longest, axis=1) for a in (forms.string, forms.fret))
    code = ((owner[:, None] * MAX_CHORD + longest) * _STRINGS + string) * _FRETS + fret
    used = forms.at > 0
    distinct, inverse = np.unique(code[used], return_inverse=True)
    index = np.full(code.shape, -1)
    index[used] = inverse
    rest, fret = np.divmod(distinct, _FRETS)
    rest, string = np.divmod(rest, _STRINGS)
    moment, slot = np.divmod(rest, MAX_CHORD)
    later_s = np.append(forms.onset_s, np.full(RING_MOMENTS, np.inf))[RING_MOMENTS:]
    ring_s = np.minimum(forms.onset_s + RING_S, later_s)
    return index, Stops(
        string=string,
        fret=fret,
        moment=moment,
        note=_padded([m.notes for m in moments])[moment, slot].astype(int),
        onset_s=forms.onset_s[moment],
        end_s=_padded([m.end_s for m in moments])[moment, slot],
        again_s=_padded([m.again_s for m in moments])[moment, slot],
        ring_s=ring_s[moment],
    )
