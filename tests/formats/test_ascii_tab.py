import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roboguitarist.errors import TabError
from roboguitarist.formats import ascii_tab, ascii_writer
from roboguitarist.formats.unrolling import unroll
from roboguitarist.tablature import Bar, Note, Tablature, Technique
from strategies import tablatures


def tab(first, *, labels="eBGDAE", **options):
    """A tab with this on the first line, dashes on the others."""
    rows = [first, *["-" * len(first)] * 5]
    lines = [f"{label}|{row}|" for label, row in zip(labels, rows, strict=True)]
    return unrolled(ascii_tab.read("\n".join(lines), **options))


def unrolled(score):
    return unroll(score, score.parts[0])


@pytest.mark.parametrize(
    ("first", "places"),
    [
        ("-3---5-", [(0, 3), (4, 5)]),
        ("-12--9-", [(0, 12), (4, 9)]),
        ("-1012--", [(0, 10), (2, 12)]),
        ("3-5-7-8", [(0, 3), (2, 5), (4, 7), (6, 8)]),
        ("-(5)---", [(1, 5)]),
    ],
)
def test_columns_are_times(first, places):
    found = [(round(n.onset_s / 0.125), n.fret) for n in tab(first).notes]
    assert found == places


def test_tempo_and_grid_are_asked_for_stated_or_usual():
    assert tab("-1-2-").notes[1].onset_s == 0.25
    assert tab("-1-2-", tempo=60, grid=8).notes[1].onset_s == 1.0
    text = "Tempo: 60\nGrid: 8\n" + "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    assert unrolled(ascii_tab.read(text)).notes[-1].onset_s == 1.0


@pytest.mark.parametrize(
    ("first", "kinds"),
    [
        ("-5h7-", [(), (Technique.HAMMER_ON,)]),
        ("-7p5-", [(), (Technique.PULL_OFF,)]),
        ("-5/7-", [(), (Technique.SLIDE,)]),
        ("-/7---", [(Technique.SLIDE_IN,)]),
        ("-7\\---", [(Technique.SLIDE_OUT,)]),
        ("-7b9--", [(Technique.BEND,)]),
        ("-7~--", [(Technique.VIBRATO,)]),
        ("-x---", [(Technique.DEAD,)]),
        ("-<12>-", [(Technique.HARMONIC,)]),
    ],
)
def test_signs(first, kinds):
    assert [note.techniques for note in tab(first).notes] == kinds


def test_a_bend_goes_up_and_is_released():
    (note,) = tab("-7b8r7--").notes
    assert note.bend == ((0.0, 0.0), (0.5, 1.0), (1.0, 0.0))


def test_tuning_comes_from_labels_and_lines_may_stand_upside_down():
    assert tab("-0---", labels="eBGDAD").tuning == (64, 59, 55, 50, 45, 38)
    turned = tab("-3---", labels="EADGBe")
    assert [(note.string, note.fret) for note in turned.notes] == [(6, 3)]
    bare = "\n".join(["|-3---|", *["|-----|"] * 5])
    assert [note.string for note in unrolled(ascii_tab.read(bare)).notes] == [1]


def test_numbers_and_words_say_how_strings_are_tuned():
    numbered = tab("-3---", labels="123456")
    assert [(n.string, n.fret) for n in numbered.notes] == [(1, 3)]
    assert tab("-3---", labels="654321").notes[0].string == 6
    system = "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    for words, tuning in (
        ("Tuning: Drop D", (64, 59, 55, 50, 45, 38)),
        ("Drop-D tuning", (64, 59, 55, 50, 45, 38)),
        ("Tuning: DADGAD", (62, 57, 55, 50, 45, 38)),
        ("Standard (E A D G B e)", (64, 59, 55, 50, 45, 40)),
        ("tuned down a half step", (63, 58, 54, 49, 44, 39)),
        ("Half step down (Eb Ab Db Gb Bb eb)", (63, 58, 54, 49, 44, 39)),
    ):
        assert unrolled(ascii_tab.read(f"{words}\n\n{system}")).tuning == tuning


@pytest.mark.parametrize(
    ("words", "capo"),
    [
        ("Capo: 2nd fret", 2),
        ("Capo 3", 3),
        ("(capo on the 4th fret)", 4),
        ("Capo: III", 3),
        ("Capo: none", 0),
        ("No capo", 0),
    ],
)
def test_a_capo_in_words(words, capo):
    system = "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    assert unrolled(ascii_tab.read(f"{words}\n{system}")).capo == capo


def test_a_tempo_in_words_is_reported():
    system = "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    tablature = unrolled(ascii_tab.read(f"Tempo: slow\n{system}"))
    assert tablature.warnings == ("tempo 'slow' is no number, 120 is taken",)


def test_frets_of_one_and_two_digits_make_a_chord_flush_left_or_right():
    rows = ["-10--12-", "--8--(9)", "-9---12-", "-(7)----", "--------", "--------"]
    text = "\n".join(f"{name}|{row}|" for name, row in zip("eBGDAE", rows, strict=True))
    notes = [(n.onset_s, n.string, n.fret) for n in unrolled(ascii_tab.read(text)).notes]
    assert [place for at, *place in notes if at == 0.0] == [[1, 10], [2, 8], [3, 9], [4, 7]]
    assert {at for at, *_ in notes} == {0.0, 0.5}


def test_what_word_processors_and_web_sites_make_of_a_tab_is_read():
    system = "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    plain = unrolled(ascii_tab.read(system))
    typed = system.replace("-", "–").replace("|", "│")
    assert unrolled(ascii_tab.read(typed)) == plain
    tagged = f"[ch]Am[/ch]\n[tab]{system}[/tab]"
    assert ascii_tab.is_tab(tagged)
    assert unrolled(ascii_tab.read(tagged)) == plain
    labelled = "\n".join(f"{name}-|-1-2-|  let ring" for name in "EBGDAE")
    assert unrolled(ascii_tab.read(labelled)) == plain


def test_times_behind_a_system_repeat_that_system():
    def system(fret):
        return "\n".join(f"{name}|-{fret}---|" for name in "eBGDAE")

    text = f"{system(1)}\n\n{system(2)} (play 3 times)\n"
    frets = [n.fret for n in unrolled(ascii_tab.read(text)).notes if n.string == 1]
    assert frets == [1, 2, 2, 2]


def test_repeats_are_played():
    rows = ["|:-1-2-:|-3-|", "|:-----:|---|", *["|------|---|".replace("|-", "|--", 1)] * 4]
    notes = unrolled(ascii_tab.read("\n".join(rows))).notes
    assert [note.fret for note in notes] == [1, 2, 1, 2, 3]
    text = "\n".join(f"{name}|-1-2-|  x3" for name in "eBGDAE")
    assert len(unrolled(ascii_tab.read(text)).notes) == 3 * 2 * 6


def test_words_between_systems_are_no_music():
    system = "\n".join(f"{name}|-1-2-|" for name in "eBGDAE")
    text = f"A song\n-----------\n{system}\n\nChorus: slowly\nPM----\n{system}\n"
    assert len(unrolled(ascii_tab.read(text)).bars) == 2


def test_a_line_too_few_is_refused():
    text = "\n".join(f"{name}|-1-2-|" for name in "GDAE")
    with pytest.raises(TabError, match="lines 1 to 4: a tab of 4 strings"):
        ascii_tab.read(text)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(st.integers(1, 6), st.integers(0, 24)), min_size=1, max_size=30))
def test_what_was_written_reads_the_same(places):
    notes = tuple(Note(0.25 * k, s, f, 0.25) for k, (s, f) in enumerate(places))
    bars = tuple(Bar(2.0 * k, k + 1) for k in range(len(notes) // 8 + 1))
    tablature = Tablature(notes, bars)
    again = unrolled(ascii_tab.read(ascii_writer.write(tablature).decode()))
    assert [note.place for note in again.notes] == [note.place for note in notes]
    assert ascii_writer.write(again) == ascii_writer.write(tablature)


@settings(deadline=None, max_examples=25)
@given(tablatures(min_notes=1))
def test_whatever_is_written_can_be_read(tablature):
    ascii_tab.read(ascii_writer.write(tablature).decode())
