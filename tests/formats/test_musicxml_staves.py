from fractions import Fraction
from xml.etree.ElementTree import fromstring

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roboguitarist.errors import TabError
from roboguitarist.formats.musicxml_staves import StaffDetails, one_staff, pitch
from roboguitarist.formats.written import WrittenNote
from roboguitarist.tablature import STANDARD_TUNING, Technique

STEPS = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")
TAB = "<clef><sign>TAB</sign></clef>"


def named(midi, prefix=""):
    name, octave = STEPS[midi % 12], midi // 12 - 1
    return (
        f"<{prefix}step>{name[0]}</{prefix}step>"
        f"<{prefix}alter>{len(name) - 1}</{prefix}alter>"
        f"<{prefix}octave>{octave}</{prefix}octave>"
    )


def details(*texts):
    found = StaffDetails()
    for text in texts:
        found.read(fromstring(f"<attributes>{text}</attributes>"))
    return found


def tuned(*pitches, lines="", extra=""):
    """Staff details with strings from the lowest line up."""
    strings = "".join(
        f'<staff-tuning line="{line}">{named(midi, "tuning-")}</staff-tuning>'
        for line, midi in enumerate(pitches, 1)
    )
    lines = lines and f"<staff-lines>{lines}</staff-lines>"
    return details(f"{TAB}<staff-details>{lines}{strings}{extra}</staff-details>")


@given(st.integers(12, 127))
def test_pitches(midi):
    assert pitch(fromstring(f"<pitch>{named(midi)}</pitch>")) == midi


@pytest.mark.parametrize(
    ("text", "midi"),
    [
        ("<step>B</step><alter>1</alter><octave>3</octave>", 60),
        ("<step>C</step><alter>-1</alter><octave>4</octave>", 59),
        ("<step>C</step><alter>0.5</alter><octave>4</octave>", 60),
        ("", None),
    ],
)
def test_spellings(text, midi):
    assert pitch(fromstring(f"<pitch>{text}</pitch>")) == midi


@pytest.mark.parametrize(
    "text",
    [
        "<step>H</step><octave>4</octave>",
        "<step>C</step>",
        "<octave>4</octave>",
        "<step>C</step><octave>99</octave>",
        "<step>C</step><octave>-5</octave>",
        "<step>C</step><octave>four</octave>",
    ],
)
def test_what_is_no_pitch_is_refused(text):
    with pytest.raises(TabError):
        pitch(fromstring(f"<pitch>{text}</pitch>"))


STRINGS_UP = STANDARD_TUNING[::-1]


@pytest.mark.parametrize(
    ("written", "tuning"),
    [
        (STRINGS_UP, STANDARD_TUNING),
        ((38, *STRINGS_UP[1:]), (64, 59, 55, 50, 45, 38)),
        (STANDARD_TUNING, STANDARD_TUNING),  # counted from the top
        (tuple(p + 12 for p in STRINGS_UP), STANDARD_TUNING),  # as the treble clef has it
        (tuple(p + 5 for p in STRINGS_UP), tuple(p + 5 for p in STANDARD_TUNING)),
        ((28, 33, 38, 43), (43, 38, 33, 28)),
    ],
)
def test_tunings(written, tuning):
    found = tuned(*written)
    assert found.tuning() == tuning
    assert found.n_strings(0) == len(tuning)


def test_one_string_that_is_tuned_otherwise():
    found = tuned(38, lines="6")
    assert found.tuning() == (64, 59, 55, 50, 45, 38)


def test_nothing_is_known_of_a_plain_staff():
    found = details(
        "<clef><sign>G</sign></clef><staff-details><staff-lines>5</staff-lines></staff-details>"
    )
    assert found.tuning() is None
    assert found.n_strings(6) is None
    assert found.n_strings(7) == 7


def test_the_lines_of_a_tab_staff_are_strings():
    assert (
        details(f"{TAB}<staff-details><staff-lines>4</staff-lines></staff-details>").n_strings(0)
        == 4
    )


def test_capo():
    assert tuned(*STRINGS_UP, extra="<capo>3</capo>").capo == 3
    assert tuned(*STRINGS_UP).capo == 0


def test_an_octave_clef_is_notation_only_but_transposition_sounds():
    clef = "<clef><sign>G</sign><clef-octave-change>-1</clef-octave-change></clef>"
    assert details(clef).transposition(1) == 0
    down = "<chromatic>-2</chromatic><octave-change>-1</octave-change>"
    assert details(f"<transpose>{down}</transpose>").transposition(2) == -14
    second = details(f'<transpose number="2">{down}</transpose>')
    assert (second.transposition(1), second.transposition(2)) == (0, -14)


def written(offset, midi, staff=1, **values):
    return WrittenNote(0, Fraction(offset), Fraction(1), midi, staff=staff, **values)


def test_the_same_music_on_two_staves_is_played_once():
    standard = [
        written(0, 72, left_finger=1),
        written(1, 76, techniques=(Technique.STACCATO,)),
        written(2, 74),
    ]
    tab = [written(0, 60, 2, string=2, fret=1), written(1, 64, 2, string=1, fret=0)]
    assert one_staff([*standard, *tab], {2}) == (
        written(0, 60, 2, string=2, fret=1, left_finger=1),
        written(1, 64, 2, string=1, fret=0, techniques=(Technique.STACCATO,)),
    )


def test_other_music_on_a_second_staff_is_kept():
    notes = [written(0, 72), written(1, 73), written(0, 50, 2, string=4, fret=0)]
    assert one_staff(notes, {2}) == tuple(notes)
    assert one_staff(notes, set()) == tuple(notes)
