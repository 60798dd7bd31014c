"""The strings as they are seen: by gauge, from the rollers to the bridge."""

from __future__ import annotations

import mujoco

from roboguitarist.guitar import STRINGS, Guitar
from roboguitarist.looks.head import roller
from roboguitarist.looks.shapes import add_rod

RADII_M = (0.00045, 0.0005, 0.0006, 0.0006, 0.0007, 0.0008)
"""Strings 1 to 6, a little stouter than real ones so that they are seen from afar."""
FIRST_WOUND = 4


def add_strings(spec: mujoco.MjSpec, guitar: Guitar) -> None:
    """Add the strings to the world."""
    for string in STRINGS.tolist():
        radius = RADII_M[string - 1]
        material = "wound" if string >= FIRST_WOUND else "nylon"
        nut, saddle, tie = (
            (x, float(guitar.string_y(string, x)), z)
            for x, z in (
                (0.0, 0.0),
                (guitar.scale_length_m, 0.0),
                (guitar.scale_length_m + 0.012, -0.0025),
            )
        )
        world = spec.worldbody
        add_rod(world, f"string_{string}_seen", material, start=nut, end=saddle, radius=radius)
        add_rod(world, f"string_{string}_tied", material, start=saddle, end=tie, radius=radius)
        add_rod(
            world,
            f"string_{string}_head",
            material,
            start=roller(guitar, string),
            end=nut,
            radius=radius,
        )
