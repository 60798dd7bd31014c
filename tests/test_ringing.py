from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings

from builders import perfect, tablatures
from roboguitarist.performance import DEAD
from roboguitarist.ringing import DEAD_DECAY_S, WIDEST_M, rings
from roboguitarist.tablature import Note, Tablature

TWICE = Tablature((Note(0.0, 2, 1, 0.5), Note(0.5, 2, 3, 0.5), Note(0.5, 6, 0, 0.5)))


def test_a_string_rings_until_it_is_plucked_again_or_let_go():
    first, second, bass = rings(perfect(TWICE))
    assert (first.string, first.fret, first.start_s) == (2, 1, 0.0)
    assert first.end_s == pytest.approx(0.5)
    assert (second.string, second.fret) == (2, 3)
    assert second.end_s == pytest.approx(1.0, abs=1 / 30)
    assert bass.end_s > 1.5


@given(tablatures())
@settings(deadline=None)
def test_every_pluck_rings_and_no_string_rings_twice_at_once(tablature):
    found = rings(perfect(tablature))
    assert len(found) == len(tablature.notes)
    assert all(0 < ring.width_m < WIDEST_M for ring in found)
    for string in range(1, 7):
        own = [ring for ring in found if ring.string == string]
        assert all(a.end_s <= b.start_s for a, b in pairwise(own))


def test_the_swing_only_shrinks():
    ring = rings(perfect(TWICE))[0]
    widths = [ring.width_at(t) for t in np.arange(0, 0.5, 0.05)]
    assert widths[0] == ring.width_m
    assert np.all(np.diff(widths) < 0)
    assert ring.width_at(-0.01) == ring.width_at(0.5) == 0.0


def test_a_faster_pluck_swings_wider_and_a_dead_string_hardly_rings():
    performance = perfect(TWICE)
    fast = replace(performance, pluck_speed_m_s=2 * performance.pluck_speed_m_s)
    assert rings(fast)[0].width_m > rings(performance)[0].width_m
    dead = replace(performance, pluck_fret=np.full(3, DEAD, np.int8))
    assert all(ring.end_s - ring.start_s <= DEAD_DECAY_S for ring in rings(dead))
