from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.fingering.grips import LEFT_OUT, MOST_FRETS_APART, grips, together

PLACES = st.lists(
    st.tuples(st.integers(1, 6), st.integers(0, 9)), max_size=6, unique_by=lambda place: place[0]
).map(tuple)


def unmarked(places: tuple[tuple[int, int], ...]):
    return grips(places, (None,) * len(places))


def test_a_single_note_has_four_grips_and_an_open_string_one():
    assert unmarked(((1, 5),)) == ((1,), (2,), (3,), (4,))
    assert unmarked(((1, 0),)) == ((0,),)
    assert unmarked(()) == ((),)


def test_an_f_chord_needs_a_barre_or_a_small_one():
    full = ((1, 1), (2, 1), (3, 2), (4, 3), (5, 3), (6, 1))
    assert (1, 1, 2, 4, 3, 1) in unmarked(full)
    assert all(grip[0] == grip[1] == grip[5] == 1 for grip in unmarked(full))


def test_no_barre_over_an_open_string_from_its_tip_on():
    assert (1, 1) in unmarked(((4, 2), (3, 2)))
    assert (1, 1, 0) not in unmarked(((4, 2), (3, 2), (1, 0)))
    assert (1, 1, 0) in unmarked(((4, 2), (3, 2), (5, 0)))


@given(PLACES)
def test_fingers_reach_and_do_not_cross_frets(places):
    found = unmarked(places)
    assert found
    assert len({grip.count(LEFT_OUT) for grip in found}) == 1
    for grip in found:
        for (f, (_, fret)), (g, (_, other)) in combinations(zip(grip, places, strict=True), 2):
            if 0 < f < g:
                assert 0 <= other - fret <= MOST_FRETS_APART[f, g]
            if 0 < f == g:
                assert f == 1
                assert fret == other
        for finger, (_, fret) in zip(grip, places, strict=True):
            assert finger == LEFT_OUT or (finger == 0) == (fret == 0)


@given(PLACES, st.integers(1, 9))
def test_a_shape_has_the_same_grips_higher_up(places, frets):
    higher = tuple((string, fret and fret + frets) for string, fret in places)
    assert unmarked(higher) == unmarked(places)


@given(PLACES, st.data())
def test_marks_that_a_hand_can_keep_are_kept(places, data):
    grip = data.draw(st.sampled_from(unmarked(places)))
    marks = tuple(finger if finger > 0 else None for finger in grip)
    kept = grips(places, marks)
    for other in kept:
        for finger, mark in zip(other, marks, strict=True):
            assert mark is None or finger in (mark, LEFT_OUT)
    assert grip in kept


def test_a_mark_lays_another_finger_flat():
    places = ((3, 5), (4, 5))
    assert (3, 3) not in unmarked(places)
    assert grips(places, (3, 3)) == ((3, 3),)


def test_together_is_about_order_and_reach():
    assert together(1, 5, 4, 8)
    assert together(2, 5, 3, 5)
    assert not together(1, 6, 2, 5)
    assert not together(3, 5, 4, 8)
