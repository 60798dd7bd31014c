"""What a finger on a note does when the next form comes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roboguitarist.fingering.costs import FRET_M, STRING_GAP_M, Terms
from roboguitarist.fingering.result import SIMULTANEOUS_S
from roboguitarist.fingering.settings import Setting
from roboguitarist.fingering.trellis import Forms


@dataclass(frozen=True)
class Meeting:
    """What happens to fingers on stops when forms come: arrays (n,), bool if not said otherwise.

    Attributes:
        used: The form uses the finger.
        sounds, planted, rings: The note still sounds; it will come again; it could ring on.
        taken: The form plays its string.
        moved, along, across: The finger goes elsewhere; on its string; to another string.
        near: The new fret is one or two from the stop's.
        same_fret: The finger is used on the stop's fret.
        stays: It is used where it is.
        flat: It is laid flat over the stop and the form's strings.
        way_m: Distance to the new place, in metres.
    """

    used: np.ndarray
    sounds: np.ndarray
    planted: np.ndarray
    rings: np.ndarray
    taken: np.ndarray
    moved: np.ndarray
    along: np.ndarray
    near: np.ndarray
    same_fret: np.ndarray
    stays: np.ndarray
    flat: np.ndarray
    way_m: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """The finger should stay."""
        return self.sounds | self.planted

    @property
    def across(self) -> np.ndarray:
        """It goes to another string."""
        return self.moved & ~self.along


def meet(
    s: Setting, moment: np.ndarray, finger: np.ndarray, stop: np.ndarray, form: np.ndarray
) -> Meeting:
    """What happens to fingers (n,), from 1, on stops (n,) when forms (n,) come."""
    forms, stops = s.forms, s.stops
    string, fret = stops.string[stop], stops.fret[stop]
    after_s = forms.onset_s[moment] + SIMULTANEOUS_S
    sounds = stops.end_s[stop] > after_s
    planted = ~sounds & (stops.again_s[stop] > after_s)
    rings = ~sounds & ~planted & (stops.ring_s[stop] > after_s)
    to = down(forms, form, finger)
    used = to.fret > 0
    same_fret = used & (to.fret == fret)
    stays = to.covers(string, fret)
    under = (1 << np.maximum(np.maximum(string, to.bass) - 1, 0)) - 1
    ringing = 0 if s.free else s.open_strings[moment]
    flat = same_fret & ~stays & (sounds | planted) & (finger == 1)
    flat &= (ringing | forms.opened[form]) & under == 0
    moved = used & ~stays & ~flat
    return Meeting(
        used=used,
        sounds=sounds,
        planted=planted,
        rings=rings,
        taken=(forms.touched[form] >> (string - 1)) & 1 == 1,
        moved=moved,
        along=moved & (to.treble == string) & (to.bass == string),
        near=np.abs(to.fret - fret) <= 2,
        same_fret=same_fret,
        stays=stays,
        flat=flat,
        way_m=np.hypot(FRET_M * (to.fret - fret), STRING_GAP_M * (to.treble - string)),
    )


@dataclass(frozen=True)
class Down:
    """Fingers that are down: numbers, frets, first and last string, in arrays of one shape."""

    finger: np.ndarray
    fret: np.ndarray
    treble: np.ndarray
    bass: np.ndarray

    def covers(self, string: np.ndarray, fret: np.ndarray) -> np.ndarray:
        """Whether the finger is on that place."""
        return (self.fret == fret) & (self.treble <= string) & (string <= self.bass)

    def lower(self, other: Down, own: np.ndarray) -> Down:
        """This where `own`, else the other."""
        return Down(
            np.where(own, self.finger, other.finger),
            np.where(own, self.fret, other.fret),
            np.where(own, self.treble, other.treble),
            np.where(own, self.bass, other.bass),
        )


def down(forms: Forms, form: np.ndarray, finger: np.ndarray | int) -> Down:
    """What fingers, from 1, do in forms (n,); fret 0 if nothing."""
    finger = np.broadcast_to(finger, form.shape)
    at = form, finger - 1
    return Down(finger, forms.at[at], forms.treble[at], forms.bass[at])


def pair_terms(low: Down, high: Down) -> Terms:
    """Terms of two fingers that are down together, the lower-numbered first."""
    apart = high.fret - low.fret
    excess = apart - (high.finger - low.finger)
    level = apart == 0
    near = (high.treble - low.bass == 1) | (low.treble - high.bass == 1)
    return {
        "stretch": np.maximum(excess, 0) * (low.finger == 1),
        "spread": np.maximum(excess, 0) * (low.finger > 1),
        "squeeze": np.maximum(-excess, 0),
        "crossed": level & (low.bass < high.treble),
        "tight": level & near,
    }
