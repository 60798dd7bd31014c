from functools import partial

import numpy as np

from roboguitarist.fingering import Reach
from roboguitarist.fingering import assign as assign_by
from roboguitarist.fingering.reach import NEEDED_N
from roboguitarist.tablature import Note, Tablature

assign = partial(assign_by, method="search")


def strong() -> np.ndarray:
    return np.full((4, 6, 20), 2 * NEEDED_N)


def row(*numbers: int) -> np.ndarray:
    return np.array([[*numbers, *[0] * (6 - len(numbers))]])


def test_what_is_missing_is_a_share_of_the_force_needed():
    held_n = strong()
    held_n[2, 0, 4] = NEEDED_N / 4  # ring finger, string 1, fret 5
    reach = Reach(held_n)
    assert reach.missing(row(3), row(1), row(5)).tolist() == [0.75]
    assert reach.missing(row(2), row(1), row(5)).tolist() == [0.0]
    assert reach.missing(row(0), row(1), row(0)).tolist() == [0.0]
    assert reach.missing(row(3, 1), row(1, 2), row(5, 21)).tolist() == [1.75]


def test_a_shape_that_was_tried_in_vain_costs_more():
    shape = frozenset({(1, 2, 5), (2, 3, 5)})
    reach = Reach(strong(), frozenset({shape}))
    assert reach.missing(row(2, 1), row(3, 2), row(5, 5)).tolist() == [1.0]
    assert reach.missing(row(3, 1), row(3, 2), row(5, 5)).tolist() == [0.0]


def test_a_finger_without_force_is_spared():
    tablature = Tablature((Note(0.0, 1, 5, 1.0), Note(1.0, 1, 7, 1.0)))
    finger = int(assign(tablature).left[0])
    held_n = strong()
    held_n[finger - 1, 0, 4] = 0.0
    assert assign(tablature, reach=Reach(held_n)).left[0] != finger
    assert assign(tablature, reach=Reach(strong())).left[0] == finger
