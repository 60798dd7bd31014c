import pytest
from musicxml_texts import GUITAR, attributes, measures, note, score, several, technical

from roboguitarist.errors import TabError
from roboguitarist.formats import musicxml

TAB_STAFF = "<staves>2</staves><clef number='2'><sign>TAB</sign></clef>"


def header(name="Guitar", inside="", number=1):
    return f'<score-part id="P{number}"><part-name>{name}</part-name>{inside}</score-part>'


def midi(program=25, channel=1):
    inside = f"<midi-channel>{channel}</midi-channel><midi-program>{program}</midi-program>"
    return f'<midi-instrument id="I">{inside}</midi-instrument>'


def strings(*names):
    """Staff details with strings from the lowest line up, as in "E2"."""
    inside = "".join(
        f'<staff-tuning line="{k}"><tuning-step>{name[0]}</tuning-step>'
        f"<tuning-octave>{name[1]}</tuning-octave></staff-tuning>"
        for k, name in enumerate(names, 1)
    )
    return attributes(f"<staff-details>{inside}</staff-details>")


def test_titles():
    work = (
        "<work><work-title>Für\n Elise</work-title></work><movement-title>x</movement-title>"
        '<identification><creator type="lyricist">Y</creator>'
        '<creator type="composer">Beethoven</creator><source>WoO 59</source></identification>'
    )
    read = musicxml.read(score(note("C4"), work=work))
    assert (read.title, read.composer, read.source) == ("Für Elise", "Beethoven", "WoO 59")
    movement = "<movement-title>Andante</movement-title>"
    assert musicxml.read(score(note("C4"), work=movement)).title == "Andante"


def test_parts_have_names_and_common_bars():
    data = several(
        measures(note("C4", 4), note("D4", 4)),
        measures(note("C4", 6)),
        header=GUITAR + header("", number=2),
    )
    read = musicxml.read(data)
    assert [part.name for part in read.parts] == ["Guitar", "P2"]
    assert [bar.length for bar in read.bars] == [6, 4]


def test_timewise_is_partwise_turned():
    bodies = (note("C4", 4), note("E3", 4)), (note("D4", 4), note("F3", 4))
    partwise = several(
        *(measures(*(row[k] for row in bodies)) for k in (0, 1)),
        header=GUITAR + header("Second", number=2),
    )
    rows = "".join(
        f'<measure number="{k}"><part id="P1">{a}</part><part id="P2">{b}</part></measure>'
        for k, (a, b) in enumerate(bodies, 1)
    )
    list_ = f"<part-list>{GUITAR}{header('Second', number=2)}</part-list>"
    timewise = f"<score-timewise>{list_}{rows}</score-timewise>".encode()
    assert musicxml.read(timewise) == musicxml.read(partwise)


@pytest.mark.parametrize(
    ("head", "body", "why"),
    [
        (header(inside=midi(channel=10)), note("C4"), "drum"),
        (header(), "<note><unpitched/><duration>1</duration></note>", "drum"),
        (header("Bass"), note("E2"), "bass"),
        (header("Electric Bass Guitar"), note("E2"), "bass"),
        (header("Low", midi(program=34)), note("E2"), "bass"),
        (header(), strings("B0", "E1", "A1", "D2", "G2", "C3") + note("E2"), "bass"),
        (header(), note("C4"), ""),
        (header("Basso continuo"), note("C4"), ""),
        (header("Bass line on guitar"), strings("E2", "A2", "D3", "G3", "B3", "E4"), ""),
    ],
)
def test_what_is_no_guitar(head, body, why):
    (part,) = musicxml.read(score(body, header=head)).parts
    assert why in part.obstacle
    assert bool(why) == bool(part.obstacle)


def test_strings_are_counted():
    seven = strings("B1", "E2", "A2", "D3", "G3", "B3", "E4")
    assert musicxml.read(score(seven + note("C4"))).parts[0].n_strings == 7
    assert musicxml.read(score(note("C4", place="7/1"))).parts[0].n_strings == 7
    assert musicxml.read(score(note("C4", place="6/1"))).parts[0].n_strings is None


def test_fingers_of_a_keyboard_are_not_a_guitarists():
    fingered = note("C4", inside=technical("<fingering>1</fingering>"))
    below = note("C3", inside="<staff>2</staff>")
    piano = header("Piano", midi(program=1))
    assert musicxml.read(score(fingered)).parts[0].notes[0].left_finger == 1
    assert musicxml.read(score(fingered + below)).parts[0].notes[0].left_finger is None
    assert musicxml.read(score(fingered, header=piano)).parts[0].notes[0].left_finger is None


def test_a_tab_staff_and_its_standard_staff_are_one():
    body = (
        attributes(TAB_STAFF)
        + note("C4", inside="<staff>1</staff>" + technical("<fingering>1</fingering>"))
        + "<backup><duration>1</duration></backup>"
        + note("C4", inside="<staff>2</staff>", place="2/1")
    )
    (only,) = musicxml.read(score(body)).parts[0].notes
    assert (only.string, only.fret, only.left_finger) == (2, 1, 1)


def test_a_pitch_that_contradicts_its_place_is_said_once():
    wrong = note("D4", place="2/1") + note("C4", place="2/1") + note("B4", place="1/0")
    (warning,) = musicxml.read(score(wrong)).parts[0].warnings
    assert warning.startswith("bar 1, beat 1")
    assert "2 notes" in warning


@pytest.mark.parametrize("right", ["C4", "C5"])
def test_an_octave_is_no_contradiction(right):
    assert musicxml.read(score(note(right, place="2/1"))).parts[0].warnings == ()


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"<html/>", "root element is 'html'"),
        (b"<score-partwise>", "broken XML"),
        (score(note("C4"), note("C4", -1)), "part Guitar, bar 2, beat 1: duration of -1"),
    ],
)
def test_what_is_no_score_is_refused(data, message):
    with pytest.raises(TabError, match=message):
        musicxml.read(data)


def test_an_empty_score_is_empty():
    read = musicxml.read(b"<score-partwise/>")
    assert (read.parts, read.bars) == ((), ())
