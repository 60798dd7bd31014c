"""Which finger plays which note: left hand 1 to 4, right hand p, i, m, a."""

from roboguitarist.fingering.assign import METHODS, OBJECTIVES, assign
from roboguitarist.fingering.costs import HANDS, Costs
from roboguitarist.fingering.paper import REACH_FRETS, STRETCH_FRETS
from roboguitarist.fingering.reach import Reach
from roboguitarist.fingering.result import (
    LEFT_FINGERS,
    OPEN,
    RIGHT_FINGERS,
    SIMULTANEOUS_S,
    UNPLAYABLE,
    Fingering,
    describe,
)

__all__ = [
    "HANDS",
    "LEFT_FINGERS",
    "METHODS",
    "OBJECTIVES",
    "OPEN",
    "REACH_FRETS",
    "RIGHT_FINGERS",
    "SIMULTANEOUS_S",
    "STRETCH_FRETS",
    "UNPLAYABLE",
    "Costs",
    "Fingering",
    "Reach",
    "assign",
    "describe",
]
