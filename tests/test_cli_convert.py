import pytest

from builders import perfect
from complaints import complaint
from roboguitarist import cli_report, formats, pieces
from roboguitarist.cli import main
from roboguitarist.tablature import Note, Tablature, Technique


@pytest.mark.parametrize("suffix", ["musicxml", "mid", "txt", "json"])
def test_a_piece_is_written_in_another_format(tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    assert main(["convert", "twinkle", str(path)]) == 0
    places = [note.place for note in formats.load(pieces.path("twinkle")).notes]
    found = [note.place for note in formats.load(path).notes]
    assert [place[1:] for place in found] == [place[1:] for place in places]
    assert [place[0] for place in found] == pytest.approx([p[0] for p in places], abs=1e-3)


def test_what_was_heard_of_a_recording_is_written(tmp_path):
    tablature = Tablature((Note(0.0, 1, 3, 0.5), Note(0.5, 2, 0, 0.5)))
    perfect(tablature).save(tmp_path / "a.npz")
    assert main(["convert", str(tmp_path / "a.npz"), str(tmp_path / "a.mid")]) == 0
    heard = formats.load(tmp_path / "a.mid")
    assert [note.place for note in heard.notes] == [note.place for note in tablature.notes]


def test_a_tab_is_read_at_the_tempo_and_grid_that_are_asked_for(tmp_path):
    tab = tmp_path / "a.txt"
    tab.write_text("\n".join(f"{name}|-1-2-|" for name in "eBGDAE"))
    options = ["--tempo", "60", "--grid", "8"]
    assert main(["convert", str(tab), str(tmp_path / "a.json"), *options]) == 0
    assert formats.load(tmp_path / "a.json").notes[-1].onset_s == 1.0


def test_a_suffix_that_cannot_be_written_is_one_line(tmp_path, capsys):
    assert main(["convert", "twinkle", str(tmp_path / "a.pdf")]) == 2
    assert "cannot write .pdf" in complaint(capsys)


def test_techniques_that_are_played_plainly_are_counted():
    kinds = [(Technique.BEND,), (Technique.BEND, Technique.LET_RING), (Technique.TRILL,)]
    notes = (Note(0.5 * k, 1, 0, 0.5, techniques=kind) for k, kind in enumerate(kinds))
    tablature = Tablature(tuple(notes))
    assert cli_report.simplified(tablature) == ["played as plain notes: 2 bend, 1 trill"]
    assert cli_report.simplified(Tablature((Note(0.0, 1, 0, 0.5),))) == []
