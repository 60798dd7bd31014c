from fractions import Fraction
from xml.etree.ElementTree import fromstring

import pytest

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_bars import (
    RawBar,
    bar_number,
    ending_numbers,
    merge,
    read_barline,
    read_metronome,
    read_sound,
    signature,
)

START = Fraction(0)


@pytest.mark.parametrize(
    ("printed", "before", "number"),
    [("1", 0, 1), ("0", 0, 0), ("12a", 11, 12), ("X1", 2, 2), (None, 5, 5), ("", 5, 5)],
)
def test_bar_numbers(printed, before, number):
    assert bar_number(printed, before) == number


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("<beats>3</beats><beat-type>4</beat-type>", (3, 4)),
        ("<beats>3+2</beats><beat-type>8</beat-type>", (5, 8)),
        (
            "<beats>2</beats><beat-type>4</beat-type><beats>3</beats><beat-type>8</beat-type>",
            (7, 8),
        ),
        ("<senza-misura/>", None),
    ],
)
def test_time_signatures(text, found):
    assert signature(fromstring(f"<time>{text}</time>")) == found


@pytest.mark.parametrize(("beats", "unit"), [("0", "4"), ("9999", "4"), ("4", "9999"), ("x", "4")])
def test_absurd_time_signatures_are_refused(beats, unit):
    text = f"<time><beats>{beats}</beats><beat-type>{unit}</beat-type></time>"
    with pytest.raises(TabError, match="time signature"):
        signature(fromstring(text))


@pytest.mark.parametrize(
    ("numbers", "found"),
    [("1", {1}), ("1, 2", {1, 2}), ("1,2,3", {1, 2, 3}), ("1-3", {1, 2, 3}), ("", set())],
)
def test_ending_numbers(numbers, found):
    assert ending_numbers(fromstring(f'<ending number="{numbers}"/>')) == found


@pytest.mark.parametrize(
    ("text", "start", "times"),
    [
        ('<repeat direction="forward"/>', True, 0),
        ('<repeat direction="backward"/>', False, 2),
        ('<repeat direction="backward" times="3"/>', False, 3),
        ('<repeat direction="backward" times="999999"/>', False, 100),
        ('<repeat direction="backward" times="x"/>', False, 2),
        ("<bar-style>light-heavy</bar-style>", False, 0),
    ],
)
def test_repeat_signs(text, start, times):
    bar = RawBar(1)
    read_barline(fromstring(f"<barline>{text}</barline>"), bar)
    assert (bar.repeat_start, bar.repeat_times) == (start, times)


def metronome(inside, bar):
    return read_metronome(fromstring(f"<metronome>{inside}</metronome>"), bar, START)


@pytest.mark.parametrize(
    ("inside", "tempo"),
    [
        ("<beat-unit>quarter</beat-unit><per-minute>100</per-minute>", 100),
        ("<beat-unit>quarter</beat-unit><beat-unit-dot/><per-minute>100</per-minute>", 150),
        ("<beat-unit>half</beat-unit><per-minute>60</per-minute>", 120),
        ("<beat-unit>eighth</beat-unit><per-minute>c. 90.5</per-minute>", 45.25),
    ],
)
def test_metronome_marks_count_quarter_notes(inside, tempo):
    bar = RawBar(1)
    assert metronome(inside, bar) == ""
    assert bar.tempi == {START: tempo}


def test_a_sound_tempo_counts_more_than_a_printed_one():
    bar = RawBar(1)
    read_sound(fromstring('<sound tempo="72.5"/>'), bar, START)
    metronome("<beat-unit>quarter</beat-unit><per-minute>100</per-minute>", bar)
    assert bar.tempi == {START: Fraction(145, 2)}


def test_a_metric_modulation_is_complained_about():
    bar = RawBar(1)
    assert metronome("<beat-unit>quarter</beat-unit><beat-unit>half</beat-unit>", bar)
    assert not bar.tempi


@pytest.mark.parametrize("tempo", ["0", "-60", "1e9", "nan", "99999", ""])
def test_absurd_tempi_are_refused(tempo):
    with pytest.raises(TabError, match="tempo"):
        read_sound(fromstring(f'<sound tempo="{tempo}"/>'), RawBar(1), START)


def test_signs_of_playback():
    bar = RawBar(1)
    read_sound(fromstring('<sound dacapo="yes" fine="no" segno="s1"/>'), bar, START)
    assert bar.signs == {"dacapo", "segno"}
    (merged,) = merge([[bar]])
    assert (merged.jump, merged.segno, merged.fine) == ("dacapo", True, False)


def lengths(*bars):
    return [bar.length for bar in merge([bars])]


def raw(held, **values):
    return RawBar(1, held=Fraction(held), **values)


@pytest.mark.parametrize(
    ("bars", "found"),
    [
        ([raw(4), raw(4)], [4, 4]),
        ([raw(2), raw(4)], [4, 4]),  # filled up with silence
        ([raw(5), raw(4)], [5, 4]),  # overfull
        ([raw(0), raw(4)], [4, 4]),
        ([raw(1, implicit=True), raw(4)], [1, 4]),  # pick-up
        ([raw(3), raw(1, implicit=True)], [3, 1]),  # a bar in two halves
        ([raw(3, repeat_times=2), raw(4)], [3, 4]),  # its pick-up is before the repeat
        ([raw(3, signature=(6, 8))], [3]),
        ([raw(7, signature=None)], [7]),
    ],
)
def test_how_long_a_bar_lasts(bars, found):
    assert lengths(*bars) == found


def test_parts_share_their_bars():
    first = [raw(2), raw(4)]
    second = [raw(6, repeat_start=True, endings=frozenset({1})), raw(4, repeat_times=3), raw(1)]
    bars = merge([first, second])
    assert [bar.length for bar in bars] == [6, 4, 4]
    assert bars[0].repeat_start
    assert bars[0].endings == {1}
    assert bars[1].repeat_times == 3
    assert merge([]) == ()
