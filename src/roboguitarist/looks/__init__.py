"""What only the eye needs: a wooden guitar, hands with skin on, light and cameras.

Nothing here touches the physics. All shapes are computed; there are no files to load.
"""

from __future__ import annotations

import mujoco

from roboguitarist.guitar import Guitar
from roboguitarist.hands import Side
from roboguitarist.looks.body import add_body
from roboguitarist.looks.hands import dress_hand
from roboguitarist.looks.head import add_head
from roboguitarist.looks.materials import add_materials
from roboguitarist.looks.neck import add_neck
from roboguitarist.looks.shapes import COLLISION_GROUP, VISUAL_GROUP
from roboguitarist.looks.stage import CAMERAS, HELD_RAD, add_stage
from roboguitarist.looks.strings import add_strings

__all__ = ["CAMERAS", "COLLISION_GROUP", "HELD_RAD", "VISUAL_GROUP", "dress"]


def dress(spec: mujoco.MjSpec, guitar: Guitar, sides: tuple[Side, ...]) -> None:
    """Add everything visible to a model that has its collision geoms.

    The geoms that are there already move to `COLLISION_GROUP`, which is not drawn by default.

    Args:
        spec: The model under construction.
        guitar: Dimensions of the guitar.
        sides: Hands that the model has.
    """
    for geom in spec.geoms:
        geom.group = COLLISION_GROUP
    add_materials(spec)
    add_body(spec, guitar)
    add_neck(spec, guitar)
    add_head(spec, guitar)
    add_strings(spec, guitar)
    for side in sides:
        dress_hand(spec, side)
    add_stage(spec, guitar, sides)
