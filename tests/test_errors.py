import pytest

from roboguitarist.errors import RoboGuitaristError, TabError


def test_a_message_says_where_what_and_what_would_work():
    error = TabError("fret 37", file="a.xml", part="Guitar", bar=3, beat=2.5, hint="0 to 24")
    assert str(error) == "a.xml, part Guitar, bar 3, beat 2.5: fret 37 (0 to 24)"


def test_what_is_not_known_is_not_said():
    assert str(TabError("no notes")) == "no notes"
    assert str(TabError("no notes", bar=0)) == "bar 0: no notes"


def test_naming_the_file_keeps_the_rest():
    error = TabError("fret 37", part="Guitar", bar=3, beat=1.0, hint="0 to 24")
    assert str(error.in_file("a.xml")) == f"a.xml, {error}"


@pytest.mark.parametrize("kind", [RoboGuitaristError, TabError])
def test_a_message_is_one_line(kind):
    assert str(kind("part 'a\r\nb\tc'")) == "part 'a b c'"
