"""The guitar's dimensions: where its strings, frets and edges are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from roboguitarist.errors import RoboGuitaristError

STRINGS = np.arange(1, 7)


@dataclass(frozen=True)
class Guitar:
    """Dimensions of a guitar in metres.

    Frame: x from the nut to the bridge along the strings, y towards string 1 (the treble side),
    z out of the fretboard; the origin is on the nut, midway between strings 3 and 4, at the
    height of the strings' axes.

    Attributes:
        name: Name of the preset.
        scale_length_m: Nut to saddle.
        nut_span_m, saddle_span_m: String 1 to string 6, centre to centre.
        n_frets: Number of frets.
        string_radius_m: Radius of every string.
        action_m: Height of the strings' axes over the fretboard. The strings do not bend in the
            simulation, so this is the height of a string that is pressed down.
        body_x_m: Where the neck meets the body.
        sound_hole_x_m, sound_hole_radius_m: Centre and radius of the sound hole.
    """

    name: str = "classical"
    scale_length_m: float = 0.650
    nut_span_m: float = 0.043
    saddle_span_m: float = 0.058
    n_frets: int = 20
    string_radius_m: float = 0.0008
    action_m: float = 0.0025
    body_x_m: float = 0.325
    sound_hole_x_m: float = 0.490
    sound_hole_radius_m: float = 0.0425

    def fret_x(self, fret: float | np.ndarray) -> np.ndarray:
        """Distance of a fret wire from the nut in metres: L (1 - 2^(-n/12))."""
        return self.scale_length_m * (1.0 - np.exp2(-np.asarray(fret, float) / 12.0))

    def fret_at(self, x: np.ndarray) -> np.ndarray:
        """Number of the fret that sounds when a string is pressed at `x`.

        The first wire towards the bridge stops the string, so a press between wires n - 1 and
        n gives n. Points beyond the nut give 0, beyond the last wire `n_frets` + 1.
        """
        return self._wires_m.searchsorted(x)

    @cached_property
    def _wires_m(self) -> np.ndarray:
        return self.fret_x(np.arange(self.n_frets + 1))

    def string_y(self, string: np.ndarray | int, x: np.ndarray | float = 0.0) -> np.ndarray:
        """Sideways position in metres of a string (1 to 6) at `x`; strings fan out."""
        span = self.nut_span_m + (self.saddle_span_m - self.nut_span_m) * (
            np.asarray(x) / self.scale_length_m
        )
        return span * (3.5 - np.asarray(string)) / 5.0

    def press_point(self, string: int, fret: int, along: float = 0.65) -> np.ndarray:
        """Point (3,) on a string's axis inside a fret space, in metres.

        Args:
            string: 1 to 6.
            fret: 1 to `n_frets`.
            along: Place in the fret space, 0 at the wire behind, 1 at the wire that sounds.
        """
        behind, wire = self.fret_x(fret - 1), self.fret_x(fret)
        x = behind + along * (wire - behind)
        return np.array([x, self.string_y(string, x), 0.0])


PRESETS = {
    "classical": Guitar(),
    "steel": Guitar("steel", 0.648, 0.036, 0.054, 20, 0.0006, 0.002, 0.32, 0.485, 0.05),
    "electric": Guitar("electric", 0.648, 0.035, 0.052, 22, 0.0005, 0.0018, 0.42, 0.49, 0.04),
    "three-quarter": Guitar("three-quarter", 0.580, 0.040, 0.054, 19, 0.0008, 0.0025, 0.29, 0.437),
}


def preset(name: str) -> Guitar:
    """Guitar of that name.

    Raises:
        RoboGuitaristError: If there is none; the message lists the names.
    """
    if name not in PRESETS:
        raise RoboGuitaristError(f"no guitar {name!r} (there are {', '.join(PRESETS)})")
    return PRESETS[name]
