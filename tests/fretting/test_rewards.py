import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from roboguitarist.errors import RoboGuitaristError
from roboguitarist.fretting.rewards import (
    KINDS,
    calm_reward,
    energy,
    euclidean_finger_reward,
    finger_reward,
    key_reward,
    mapping,
    playing_reward,
    total,
)

N, F = 3, 8
THRESHOLD_N = 1.0
kinds = st.sampled_from(KINDS)
distances = st.floats(0, 10)
points = arrays(float, (N, 4, 3), elements=st.floats(-1, 1))
lengths = arrays(float, (N, 4), elements=st.floats(0.01, 0.04))
actives = arrays(bool, (N, 4))
forces = arrays(float, (N, 6, F), elements=st.floats(0, 3) | st.just(0.0), fill=st.just(0.0))
wants = arrays(np.int8, (N, 6), elements=st.integers(0, F))


def within(values):
    return ((values >= 0) & (values <= 1)).all()


def pressing(**newtons) -> np.ndarray:
    """Forces (1, 6, F) from names such as s3f2, string 3 in fret space 2."""
    force_n = np.zeros((1, 6, F))
    for key, force in newtons.items():
        force_n[0, int(key[1]) - 1, int(key[3]) - 1] = force
    return force_n


def wanting(**frets) -> np.ndarray:
    """Wanted frets (1, 6) from names such as s3."""
    fret = np.zeros((1, 6), np.int8)
    for string, wanted in frets.items():
        fret[0, int(string[1]) - 1] = wanted
    return fret


@pytest.mark.parametrize("kind", KINDS)
def test_mapping_is_whole_up_to_the_bound_and_a_tenth_at_the_margin(kind):
    assert mapping([0.0, 0.2, 0.5], 0.5, 0.1, kind).tolist() == [1.0, 1.0, 1.0]
    assert mapping(0.6, 0.5, 0.1, kind) == pytest.approx(0.1)
    assert mapping(0.1, 0.0, 0.1, kind) == pytest.approx(0.1)


def test_mapping_between_and_beyond():
    # Half-way 1 / (1 + 4.5) and 0.1^(1/4); at twice the margin 1 / 19 and 0.1^4.
    assert mapping([0.5, 2.0], 0.0, 1.0, "reciprocal") == pytest.approx([2 / 11, 1 / 19])
    assert mapping([0.5, 2.0], 0.0, 1.0, "gaussian") == pytest.approx([0.1**0.25, 1e-4])


@pytest.mark.parametrize("kind", KINDS)
def test_mapping_without_margin_is_a_step(kind):
    assert mapping([0.0, 0.5, 0.500001], 0.5, 0.0, kind).tolist() == [1.0, 1.0, 0.0]


@given(st.lists(distances, min_size=2), distances, st.floats(0.01, 5), kinds)
def test_mapping_never_rises_with_distance(x, bound, margin, kind):
    values = mapping(np.sort(x), bound, margin, kind)
    assert within(values)
    assert (np.diff(values) <= 0).all()


@given(distances, distances, st.floats(0.01, 5), st.floats(0.1, 10), kinds)
def test_mapping_does_not_depend_on_the_unit(x, bound, margin, scale, kind):
    scaled = mapping(x * scale, bound * scale, margin * scale, kind)
    assert mapping(x, bound, margin, kind) == pytest.approx(scaled, abs=1e-6)


@pytest.mark.parametrize("arguments", [(-0.1, 0.0, 1.0), (0.1, -1.0, 1.0), (0.1, 0.0, -1.0)])
def test_mapping_refuses_what_is_negative(arguments):
    with pytest.raises(RoboGuitaristError, match="negative"):
        mapping(*arguments)


def test_mapping_lists_the_kinds_there_are():
    with pytest.raises(RoboGuitaristError, match=r"'linear' .*reciprocal, gaussian"):
        mapping(0.1, 0.0, 1.0, "linear")  # pyright: ignore[reportArgumentType]


def one_finger(offset_m, kind="reciprocal", reward=finger_reward):
    """Reward of one active finger whose key is 30 mm long."""
    key_m = np.full((1, 4, 3), 0.2)
    tip_m = key_m.copy()
    tip_m[0, 1] += offset_m
    tip_m[0, 0] += 1.0  # idle, wherever it is
    active = np.array([[False, True, False, False]])
    length = (np.full((1, 4), 0.030),) if reward is finger_reward else ()
    return reward(tip_m, key_m, *length, active, kind)[0]


def test_equation_1_anywhere_in_the_key_is_whole():
    assert one_finger([0.0149, 0.0009, -0.0009]) == 1.0
    assert one_finger([-0.0149, -0.0009, 0.0009]) == 1.0


def test_equation_1_by_hand():
    # Each direction by itself is a tenth at its bound + 0.1 m.
    assert one_finger([0.115, 0.0, 0.0]) == pytest.approx((0.1 + 2) / 3)
    assert one_finger([0.0, -0.101, 0.0]) == pytest.approx((0.1 + 2) / 3)
    # 15 mm aside is 14 mm beyond: 1 / (1 + 9 x 0.14); 51 mm up is half the margin: 1 / 5.5.
    by_hand = (1 + 1 / 2.26 + 1 / 5.5) / 3
    assert one_finger([0.01, 0.015, 0.051]) == pytest.approx(by_hand)
    assert one_finger([0.0, 0.0, 0.051], "gaussian") == pytest.approx((2 + 0.1**0.25) / 3)


def test_equation_1_is_the_mean_over_active_fingers():
    tip_m, key_m, length_m = np.zeros((3, 4, 3)), np.zeros((3, 4, 3)), np.full((3, 4), 0.03)
    tip_m[:, 0, 2] = 0.101
    tip_m[:, 3] = 5.0
    active = np.array([[1, 1, 1, 0], [1, 0, 0, 0], [0, 0, 0, 0]], bool)
    by_hand = [(0.7 + 1 + 1) / 3, 0.7, 1.0]
    assert finger_reward(tip_m, key_m, length_m, active) == pytest.approx(by_hand)


@given(points, points, lengths, actives, kinds)
def test_equation_1_only_grows_on_the_way_to_the_key(tip_m, key_m, length_m, active, kind):
    way = np.linspace(0.0, 1.0, 5)
    rewards = [
        finger_reward(tip_m + s * (key_m - tip_m), key_m, length_m, active, kind) for s in way
    ]
    assert within(np.array(rewards))
    assert (np.diff(rewards, axis=0) >= -1e-12).all()
    np.testing.assert_allclose(rewards[-1], 1.0)


def test_euclidean_finger_reward_by_hand():
    # 60 and 80 mm are 100 mm; 1 mm of it is free: 1 / (1 + 9 x 0.99).
    value = one_finger([0.06, 0.08, 0.0], reward=euclidean_finger_reward)
    assert value == pytest.approx(1 / 9.91)
    assert one_finger([0.0, 0.0, 0.101], reward=euclidean_finger_reward) == pytest.approx(0.1)
    assert one_finger([0.0005, 0.0005, 0.0005], reward=euclidean_finger_reward) == 1.0


@given(points, points, lengths, actives, kinds)
def test_euclidean_reward_asks_for_no_less(tip_m, key_m, length_m, active, kind):
    relaxed = finger_reward(tip_m, key_m, length_m, active, kind)
    strict = euclidean_finger_reward(tip_m, key_m, active, kind)
    assert within(strict)
    assert (strict <= relaxed + 1e-12).all()


def test_equation_2_by_hand():
    wanted = wanting(s2=1, s5=3)
    both = pressing(s2f1=2.0, s5f3=1.0)
    assert key_reward(both, wanted, False, THRESHOLD_N) == [1.0]
    # One held, one not touched: 0.5 (1 + 0.1) / 2 + 0.5.
    assert key_reward(pressing(s2f1=2.0), wanted, False, 1.0) == pytest.approx([0.775])
    # Half the threshold on both: g(0.5, 0, 1) = 2 / 11.
    light = pressing(s2f1=0.5, s5f3=0.5)
    assert key_reward(light, wanted, False, 1.0) == pytest.approx([1 / 11 + 0.5])
    assert key_reward(light, wanted, False, 1.0, "gaussian") == pytest.approx(
        [0.5 * 0.1**0.25 + 0.5]
    )
    # A wrong fret and a string that is to stay open, once is as bad as twice.
    wrong = both + pressing(s2f4=1.0, s1f1=1.0)
    assert key_reward(wrong, wanted, False, THRESHOLD_N) == [0.5]
    assert key_reward(pressing(s1f1=1.0), wanted, False, 1.0) == pytest.approx([0.05])


def test_equation_2_with_nothing_wanted():
    assert key_reward(pressing(), wanting(), False, THRESHOLD_N) == [1.0]
    assert key_reward(pressing(s1f1=0.99), wanting(), False, THRESHOLD_N) == [1.0]
    assert key_reward(pressing(s1f1=1.0), wanting(), False, THRESHOLD_N) == [0.5]
    assert key_reward(pressing(s1f1=1.0), wanting(), True, THRESHOLD_N) == [0.5]


def test_freedom_allows_lower_frets_of_a_wanted_string_alone():
    wanted, held = wanting(s3=4), pressing(s3f4=2.0)
    for extra, strict, free in (("s3f2", 0.5, 1.0), ("s3f5", 0.5, 0.5), ("s4f2", 0.5, 0.5)):
        force_n = held + pressing(**{extra: 2.0})
        assert key_reward(force_n, wanted, False, THRESHOLD_N) == [strict]
        assert key_reward(force_n, wanted, True, THRESHOLD_N) == [free]


def test_a_fret_beyond_the_neck_is_no_key():
    assert key_reward(pressing(), wanting(s1=F + 1), False, THRESHOLD_N) == [1.0]


@given(forces, wants, st.booleans(), kinds, st.floats(0, 2))
def test_more_force_on_wanted_keys_is_never_worse(force_n, wanted, freedom, kind, more_n):
    keys = wanted[..., None] == np.arange(1, F + 1)
    before = key_reward(force_n, wanted, freedom, THRESHOLD_N, kind)
    after = key_reward(force_n + more_n * keys, wanted, freedom, THRESHOLD_N, kind)
    assert within(before)
    assert (after >= before).all()


@given(forces, wants, st.booleans(), kinds)
def test_a_false_positive_costs_exactly_half(force_n, wanted, freedom, kind):
    wanted = np.minimum(wanted, F - 1)
    right = force_n * (wanted[..., None] == np.arange(1, F + 1))
    wrong = right.copy()
    wrong[np.arange(N), 2, wanted[:, 2]] = THRESHOLD_N  # string 3, the fret above the wanted one
    clean, spoilt = (key_reward(f, wanted, freedom, THRESHOLD_N, kind) for f in (right, wrong))
    np.testing.assert_allclose(clean - spoilt, 0.5, atol=1e-12)


@given(forces, wants, kinds)
def test_freedom_never_costs(force_n, wanted, kind):
    strict = key_reward(force_n, wanted, False, THRESHOLD_N, kind)
    assert (key_reward(force_n, wanted, True, THRESHOLD_N, kind) >= strict).all()


@given(forces, wants, st.floats(0.1, 10), st.booleans())
def test_only_force_over_threshold_counts(force_n, wanted, threshold_n, freedom):
    # A power of two, so that scaling does not round.
    scaled = key_reward(4.0 * force_n, wanted, freedom, 4.0 * threshold_n)
    np.testing.assert_array_equal(key_reward(force_n, wanted, freedom, threshold_n), scaled)


def test_equation_3_by_hand():
    power_w, wanted = np.array([0.0, 4.0, 4.0]), np.array([True, True, False])
    assert energy(power_w, wanted) == pytest.approx([0.0, -0.01, -0.02])
    assert energy(power_w, wanted, coefficient=0.1) == pytest.approx([0.0, -0.4, -0.8])


def test_equation_4_by_hand():
    key, finger, cost = np.array([1.0, 0.5]), np.array([1.0, 0.2]), np.array([0.0, -0.01])
    assert total(key, finger, cost) == pytest.approx([1.0, 0.34])


ASKED_ONE = np.array([[True] + [False] * 5])


def playing(force_n, sounding, wanted, onset=False):
    strings = playing_reward(force_n, np.array([sounding]), wanted, ASKED_ONE, ASKED_ONE & onset)
    return strings[0].sum()


def test_playing_reward_by_hand():
    wanted, rest = wanting(s1=3), [0] * 5
    # One string is asked, with weight 4; the five others, with 1 each, are not pressed.
    assert playing(pressing(s1f3=1.5), [3, *rest], wanted) == pytest.approx(1.0)
    assert playing(pressing(s1f3=1.2), [3, *rest], wanted) == pytest.approx((4 * 0.94 + 5) / 9)
    assert playing(pressing(s1f3=0.75), [-1, *rest], wanted) == pytest.approx((4 * 0.15 + 5) / 9)
    assert playing(pressing(), [0, *rest], wanted) == pytest.approx(5 / 9)
    assert playing(pressing(), [0, *rest], wanted, onset=True) == pytest.approx(5 / 17)
    assert playing(pressing(s1f3=2, s4f1=2), [3, 0, 0, 1, 0, 0], wanted) == pytest.approx(8 / 9)


def test_open_strings_are_to_sound_open():
    wanted = wanting()
    assert playing(pressing(), [0] * 6, wanted) == pytest.approx(1.0)
    assert playing(pressing(s1f2=0.4), [-1, 0, 0, 0, 0, 0], wanted) == pytest.approx(5 / 9)


@given(forces, wants, arrays(bool, (N, 6)), arrays(bool, (N, 6)))
def test_playing_reward_is_in_range(force_n, wanted, asked, onset):
    sounding = np.where((force_n >= THRESHOLD_N).any(-1), wanted, 0)
    strings = playing_reward(force_n, sounding, wanted, asked, onset)
    assert (strings >= 0).all()
    assert within(strings.sum(axis=1).round(12))


def test_calm_reward_by_hand():
    change = np.array([[0.0, 0.0], [1.0, -1.0], [0.5, 0.5], [2.0, 2.0]])
    assert calm_reward(change) == pytest.approx([1.0, 0.1, 0.1**0.25, 1e-4])


@given(arrays(float, (N, 20), elements=st.floats(-2, 2)))
def test_moving_less_is_calmer(change):
    assert within(calm_reward(change))
    assert (calm_reward(0.5 * change) >= calm_reward(change)).all()
