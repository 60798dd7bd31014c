from fractions import Fraction

import pytest

from roboguitarist.errors import TabError
from roboguitarist.formats.parts import choose
from roboguitarist.formats.written import WrittenBar, WrittenNote, WrittenPart, WrittenScore

PITCHED = WrittenNote(0, Fraction(0), Fraction(1), pitch=60)
PLACED = WrittenNote(0, Fraction(0), Fraction(1), string=2, fret=1)


def part(name, *notes, **values):
    return WrittenPart(name, notes or (PITCHED,), **values)


def score(*parts):
    return WrittenScore((WrittenBar(1),), parts)


def test_the_only_part_is_taken_without_a_word():
    only = part("Guitar")
    assert choose(score(only), None) == (only, ())


def test_the_first_playable_part_is_taken_and_said():
    parts = (
        part("Drums", obstacle="it is a drum part"),
        part("Bass", n_strings=4),
        WrittenPart("Rests", ()),
        part("Guitar 1", tuning=(64, 59, 55, 50, 45, 38)),
        part("Guitar 2"),
    )
    chosen, warnings = choose(score(*parts), None)
    assert chosen is parts[3]
    assert warnings == ("part 4 (Guitar 1) of 5 is played",)


def test_a_part_with_strings_and_frets_is_preferred():
    parts = part("Guitar"), part("Guitar [TAB]", PLACED)
    assert choose(score(*parts), None)[0] is parts[1]


@pytest.mark.parametrize("track", [2, "2", " 2 ", "lead guitar", "Lead Guitar"])
def test_a_part_is_asked_for_by_number_or_name(track):
    parts = part("Guitar", PLACED), part("Lead Guitar")
    assert choose(score(*parts), track) == (parts[1], ())


@pytest.mark.parametrize("track", [0, 3, -1, "Gui", ""])
def test_a_part_that_is_not_there_is_refused_with_the_list(track):
    with pytest.raises(TabError, match=r"there are 1 Guitar, 2 Flute"):
        choose(score(part("Guitar"), part("Flute")), track)


@pytest.mark.parametrize(
    ("bad", "why"),
    [
        (part("Bass", n_strings=4), "4 strings, not 6"),
        (part("Lute", tuning=tuple(range(70, 63, -1))), "7 strings"),
        (part("Kit", obstacle="it is a drum part"), "drum part"),
        (WrittenPart("Empty", ()), "no notes"),
    ],
)
def test_a_part_that_cannot_be_played_says_why(bad, why):
    with pytest.raises(TabError, match=why):
        choose(score(bad), None)
    with pytest.raises(TabError, match=why):
        choose(score(part("Guitar"), bad), 2)
    with pytest.raises(TabError, match=f"{bad.name}: .*{why}"):
        choose(score(bad, part("Other", n_strings=5)), None)


def test_a_score_without_parts_is_refused():
    with pytest.raises(TabError, match="there is none"):
        choose(score(), None)
