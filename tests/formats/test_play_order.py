from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import TabError
from roboguitarist.formats.play_order import expand
from roboguitarist.formats.written import WrittenBar


def bars(text: str) -> list[WrittenBar]:
    """Bars from signs: |: starts, :| ends (:|3 three times), [12 ending, words as they are."""
    found = []
    for number, signs in enumerate(text.split(","), 1):
        bar = WrittenBar(number)
        for sign in signs.split():
            match sign[:2]:
                case "|:":
                    bar = replace(bar, repeat_start=True)
                case ":|":
                    bar = replace(bar, repeat_times=int(sign[2:] or 2))
                case "DC":
                    bar = replace(bar, jump="dacapo")
                case "DS":
                    bar = replace(bar, jump="dalsegno")
                case _ if sign[0] == "[":
                    bar = replace(bar, endings=frozenset(map(int, sign[1:])))
                case _ if sign in ("segno", "coda", "to_coda", "fine"):
                    bar = replace(bar, **{sign: True})
        found.append(bar)
    return found


@pytest.mark.parametrize(
    ("text", "order"),
    [
        ("a, b, c", "123"),
        ("a :|, b", "112"),
        ("a, |: b, c :|, d", "123234"),
        ("a :|3, b", "1112"),
        ("a :|, b :|, c", "11223"),
        ("|: a :|, |: b :|", "1122"),
        ("|: a, [1 b :|, [2 c, d", "12134"),
        ("|: a, [1 b :|, [2 c :|, d", "12134"),
        ("|: a, [12 b :|, [3 c, d", "1212134"),
        ("|: a, [1 b :|, [2 c :|, [3 d, e", "1213145"),
        ("|: a, [1 b, [1 c :|, [2 d, [2 e, f", "1231456"),
        ("|: a, [1 b :|, c", "1213"),
        ("|: a, [13 b :|, [2 c :|, d", "1213124"),
        ("|: a, [1 b :|, [2 c, |: d :|", "121344"),
        # Signs that make no sense: one bracket too many, no start, no end, two starts.
        ("a, [123 b, [2 c, [2 d :|, e", "1212345"),
        ("|: a, b", "12"),
        ("a, |: b, c", "123"),
        ("[1 a, b", "12"),
        ("|: a, |: b :|, c :|", "122 3122 3"),
        # After a jump the last endings are played and repeats are not.
        ("a, b fine, c DC", "12312"),
        ("a, segno b, c fine, d DS", "123423"),
        ("a, b to_coda, c DC, coda d", "123124"),
        ("|: a, [1 b :|, [2 c, d DC, e fine", "1213413 45"),
        ("|: a :|, b DC, c fine", "112123"),
        ("a, b DS, c fine", "12123"),
        ("a, b fine, c to_coda, coda d", "1234"),
    ],
)
def test_order(text, order):
    assert expand(bars(text)) == [int(digit) - 1 for digit in order.replace(" ", "")]


@pytest.mark.parametrize("text", ["a, b DC", "a, segno b, c DS, d", "|: a :|, b DC"])
def test_a_jump_back_without_fine_or_coda_has_no_end(text):
    with pytest.raises(TabError, match="for ever"):
        expand(bars(text))


BARS = st.builds(
    WrittenBar,
    number=st.just(1),
    repeat_start=st.booleans(),
    repeat_times=st.sampled_from([0, 0, 0, 2, 3]),
    endings=st.frozensets(st.integers(1, 3), max_size=2),
    segno=st.booleans(),
    coda=st.booleans(),
    to_coda=st.booleans(),
    fine=st.booleans(),
    jump=st.sampled_from(["", "", "", "dacapo", "dalsegno"]),
)


@given(st.lists(BARS, max_size=12))
def test_any_signs_lead_to_an_end(written):
    try:
        order = expand(written)
    except TabError:
        return
    assert all(0 <= index < len(written) for index in order)


@given(st.lists(BARS, max_size=8))
def test_without_endings_and_jumps_every_bar_is_played_in_its_turn(written):
    plain = [
        WrittenBar(1, repeat_start=bar.repeat_start, repeat_times=bar.repeat_times)
        for bar in written
    ]
    order = expand(plain)
    assert list(dict.fromkeys(order)) == list(range(len(plain)))


@given(st.integers(1, 6), st.integers(2, 5))
def test_times_is_how_often(n_bars, times):
    written = [WrittenBar(k) for k in range(n_bars)]
    written[-1] = replace(written[-1], repeat_times=times)
    assert expand(written) == list(range(n_bars)) * times


def test_absurdly_many_bars_are_refused():
    with pytest.raises(TabError, match="10000"):
        expand([WrittenBar(k, repeat_times=100) for k in range(101)])
