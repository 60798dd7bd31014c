from xml.etree.ElementTree import fromstring

import pytest
from musicxml_texts import notations, note, technical

from roboguitarist.formats.musicxml_marks import fingers, techniques
from roboguitarist.tablature import Technique


@pytest.mark.parametrize(
    ("inside", "technique"),
    [
        (technical('<hammer-on type="stop"/>'), Technique.HAMMER_ON),
        (technical('<pull-off type="stop"/>'), Technique.PULL_OFF),
        (technical("<bend><bend-alter>2</bend-alter></bend>"), Technique.BEND),
        (technical("<harmonic><natural/></harmonic>"), Technique.HARMONIC),
        (notations('<slide type="stop"/>'), Technique.SLIDE),
        (notations('<glissando type="stop"/>'), Technique.SLIDE),
        (notations('<tied type="let-ring"/>'), Technique.LET_RING),
        (notations("<articulations><staccato/></articulations>"), Technique.STACCATO),
        (notations("<ornaments><tremolo>3</tremolo></ornaments>"), Technique.TREMOLO),
        (notations("<ornaments><wavy-line type='start'/></ornaments>"), Technique.VIBRATO),
        (notations("<ornaments><trill-mark/><wavy-line/></ornaments>"), Technique.TRILL),
        (notations("<arpeggiate/>"), Technique.STRUM_DOWN),
        (notations('<arpeggiate direction="up"/>'), Technique.STRUM_DOWN),
        (notations('<arpeggiate direction="down"/>'), Technique.STRUM_UP),
        ("<notehead>x</notehead>", Technique.DEAD),
        ("<play><mute>palm</mute></play>", Technique.PALM_MUTE),
        ("<grace/>", Technique.GRACE),
    ],
)
def test_a_technique(inside, technique):
    assert techniques(fromstring(note("C4", inside=inside))) == (technique,)


@pytest.mark.parametrize(
    "inside",
    [
        technical('<hammer-on type="start">H</hammer-on>'),
        notations('<slide type="start"/>'),
        notations('<tied type="start"/>'),
        "<notehead>diamond</notehead>",
        "",
    ],
)
def test_no_technique(inside):
    assert techniques(fromstring(note("C4", inside=inside))) == ()


def test_techniques_are_in_alphabetical_order():
    inside = technical("<harmonic/><bend/>") + notations('<tied type="let-ring"/>') + "<grace/>"
    found = techniques(fromstring(note("C4", inside=inside)))
    assert found == tuple(sorted(found))
    assert len(found) == 4


@pytest.mark.parametrize(
    ("inside", "found"),
    [
        ("<fingering>0</fingering><pluck>p</pluck>", (0, "p")),
        ("<fingering> 4 </fingering>", (4, None)),
        ("<fingering>5</fingering><fingering>3</fingering>", (3, None)),
        ("<fingering>T</fingering><pluck>x</pluck>", (None, None)),
        ("<pluck>A</pluck>", (None, "a")),
        ("", (None, None)),
    ],
)
def test_fingers(inside, found):
    assert fingers(fromstring(note("C4", inside=technical(inside)))) == found
