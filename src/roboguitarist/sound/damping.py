"""How fast each partial of each string dies away, and how far stiffness shifts it.

The strings' figures and the form of the law are those of J. Woodhouse, "Plucked guitar transients:
comparison of measurements and synthesis", Acta Acustica united with Acustica 90 (2004), for a set
of nylon strings: friction in the string and with the air, and loss in its bending. Tension and mass
agree with the strings' pitches within 0.5 %. What the bridge takes is the tension over the length
times its mobility (C. Gough, "The theory of string resonances on musical instruments", Acustica 49,
1981), here with one chosen mobility for each polarisation instead of a measured spectrum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LN_60_DB = float(np.log(1000.0))


@dataclass(frozen=True)
class Gauge:
    """A string.

    Attributes:
        mass_kg_m: Mass per length.
        bending_n_m2: Bending stiffness.
        friction: Loss factor that does not depend on frequency.
        air_1_s: Loss that is a rate, whatever the frequency.
        bending: Loss factor of the bending.
    """

    mass_kg_m: float
    bending_n_m2: float
    friction: float
    air_1_s: float
    bending: float


NYLON = (
    Gauge(0.38e-3, 130e-6, 40e-5, 1.5, 2.4e-2),
    Gauge(0.52e-3, 160e-6, 40e-5, 1.2, 2.0e-2),
    Gauge(0.90e-3, 310e-6, 14e-5, 1.7, 2.0e-2),
    Gauge(1.95e-3, 51e-6, 5e-5, 1.2, 2.0e-2),
    Gauge(3.61e-3, 40e-6, 7e-5, 0.9, 2.5e-2),
    Gauge(6.24e-3, 57e-6, 2e-5, 1.2, 2.0e-2),
)
"""Strings 1 to 6."""
MOBILITY_S_KG = (8e-3, 2e-3)
"""What the bridge yields to a force across the top, and along it; chosen, not measured."""


@dataclass(frozen=True)
class Tone:
    """A string as it is stopped.

    Attributes:
        string: 1 to 6.
        frequency_hz: Its fundamental.
        length_m: What of it speaks.
    """

    string: int
    frequency_hz: float
    length_m: float

    @property
    def gauge(self) -> Gauge:
        """The string's material."""
        return NYLON[self.string - 1]

    @property
    def tension_n(self) -> float:
        """Tension that gives the fundamental."""
        return self.gauge.mass_kg_m * (2 * self.length_m * self.frequency_hz) ** 2

    @property
    def stiffness(self) -> float:
        """Inharmonicity B: partial n is at n f sqrt((1 + B n^2) / (1 + B))."""
        return float((np.pi / self.length_m) ** 2 * self.gauge.bending_n_m2 / self.tension_n)

    def partial_hz(self, n: np.ndarray | float) -> np.ndarray:
        """Frequency of partial n."""
        b = self.stiffness
        return np.asarray(n * self.frequency_hz * np.sqrt((1 + b * np.square(n)) / (1 + b)))

    def partial_at(self, frequency_hz: np.ndarray | float) -> np.ndarray:
        """Number of the partial, not whole, that is at a frequency."""
        b = self.stiffness
        square = np.square(frequency_hz / self.frequency_hz) * (1 + b)
        return np.sqrt((np.sqrt(1 + 4 * b * square) - 1) / (2 * b))

    def decay_rate(self, frequency_hz: np.ndarray | float, across: bool = True) -> np.ndarray:
        """Rate in 1/s at which the amplitude of a partial dies away.

        Args:
            frequency_hz: Of the partial.
            across: Whether the string moves across the top, or along it.
        """
        gauge, omega = self.gauge, 2 * np.pi * np.asarray(frequency_hz, float)
        bent = self.stiffness * np.square(self.partial_at(frequency_hz)) * gauge.bending
        own = 0.5 * (gauge.air_1_s + (gauge.friction + bent) * omega)
        return own + self.bridge_rate(across)

    def bridge_rate(self, across: bool = True) -> float:
        """The part of the rate, in 1/s, that the bridge takes."""
        return self.tension_n / self.length_m * MOBILITY_S_KG[0 if across else 1]

    def decay_s(self, across: bool = True) -> float:
        """Time for 60 dB of decay of the fundamental."""
        return LN_60_DB / float(self.decay_rate(self.frequency_hz, across))
