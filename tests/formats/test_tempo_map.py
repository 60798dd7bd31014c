from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.formats.tempo_map import TempoMap, bar_starts, tempo_map
from roboguitarist.formats.written import WrittenBar

QUARTERS = st.fractions(0, 100, max_denominator=48)
TEMPI = st.integers(20, 400).map(Fraction)


@given(TEMPI, QUARTERS)
def test_a_constant_tempo(tempo, quarter):
    seconds = TempoMap([(Fraction(0), tempo)])
    assert seconds(quarter) == pytest.approx(float(quarter * 60 / tempo), abs=5e-7)


@given(st.lists(st.tuples(QUARTERS, TEMPI), max_size=5), QUARTERS, QUARTERS)
def test_time_goes_on(marks, a, b):
    seconds = TempoMap([(Fraction(0), Fraction(120)), *sorted(marks)])
    low, high = sorted((a, b))
    assert seconds(low) <= seconds(high)
    assert seconds(Fraction(0)) == 0


@given(st.lists(st.tuples(QUARTERS, TEMPI), min_size=1, max_size=5))
def test_doubling_every_tempo_halves_the_time(marks):
    marks = [(Fraction(0), Fraction(120)), *sorted(marks)]
    slow, fast = TempoMap(marks), TempoMap([(q, 2 * tempo) for q, tempo in marks])
    assert slow(Fraction(200)) == pytest.approx(2 * fast(Fraction(200)), abs=2e-6)


def test_times_are_whole_microseconds():
    seconds = TempoMap([(Fraction(0), Fraction(100))])
    assert seconds(Fraction(1, 7)) == 0.085714


def test_the_last_of_several_marks_at_one_place_counts():
    marks = [(Fraction(0), Fraction(60)), (Fraction(0), Fraction(120))]
    assert TempoMap(marks)(Fraction(2)) == 1


def test_a_repeated_bar_has_its_written_tempo():
    bars = [
        WrittenBar(1),
        WrittenBar(2, tempi=((Fraction(2), Fraction(60)),)),
    ]
    order = [0, 1, 0, 1]
    starts = bar_starts(bars, order, Fraction(0))
    assert starts == [0, 4, 8, 12]
    seconds = tempo_map(bars, order, starts)
    assert [seconds(start) for start in starts] == [0, 2, 5, 7]
    assert [(float(q), float(t)) for q, t in seconds.marks] == [
        (0, 120), (6, 60), (8, 120), (14, 60),
    ]  # fmt: skip


def test_the_first_tempo_holds_from_the_start_of_the_lead_in():
    bars = [WrittenBar(1, tempi=((Fraction(0), Fraction(60)),))]
    starts = bar_starts(bars, [0], Fraction(1, 8))
    assert tempo_map(bars, [0], starts).marks == [(0, 60)]


def test_no_bars_have_the_default_tempo():
    assert tempo_map([], [], []).marks == [(0, 120)]
