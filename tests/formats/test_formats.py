"""What holds for every kind of file: the same piece in each, and each of them broken."""

import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from score_files import FILES, PIECE

from roboguitarist import formats
from roboguitarist.errors import TabError
from roboguitarist.tablature import STANDARD_TUNING, Tablature

WRITTEN = ("a.musicxml", "a.mid", "a.txt", "a.json")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scores")
    for name, make in FILES.items():
        (folder / name).write_bytes(make())
    return folder


@pytest.mark.parametrize("name", FILES)
def test_every_kind_of_file_gives_the_same_piece(files, name):
    tablature = formats.load(files / name)
    places = [note.place for note in tablature.notes]
    assert places == sorted(places)
    assert places == sorted(PIECE)
    assert tablature.tuning == STANDARD_TUNING
    assert tablature.tempi[0].quarters_per_minute == 100
    assert [bar.onset_s for bar in tablature.bars] == pytest.approx([0.0, 2.4])
    assert tablature.warnings == ()


@pytest.mark.parametrize("name", FILES)
def test_the_name_of_a_file_does_not_matter(files, tmp_path, name):
    other = tmp_path / "score.musicxml"
    other.write_bytes((files / name).read_bytes())
    assert formats.load(other) == formats.load(files / name)


@pytest.mark.parametrize("written", WRITTEN)
@pytest.mark.parametrize("name", FILES)
def test_what_was_read_can_be_written_and_read_again(files, tmp_path, name, written):
    tablature = formats.load(files / name)
    formats.save(tmp_path / written, tablature)
    again = formats.load(tmp_path / written)
    assert [note.place for note in again.notes] == [note.place for note in tablature.notes]
    if written in ("a.musicxml", "a.json"):
        assert again == tablature
    formats.save(tmp_path / f"again-{written}", again)
    assert formats.load(tmp_path / f"again-{written}") == again


@pytest.mark.parametrize("name", FILES)
def test_a_truncated_file_is_refused_or_read(files, tmp_path, name):
    data = (files / name).read_bytes()
    path = tmp_path / name
    for length in {*range(0, len(data), max(1, len(data) // 60)), len(data) - 1}:
        path.write_bytes(data[:length])
        message = complaint(path)
        assert message is None or message.startswith(name)
        assert "\n" not in (message or "")


@pytest.mark.parametrize("name", FILES)
@settings(deadline=None, max_examples=60)
@given(data=st.data())
def test_flipped_bits_are_refused_or_read(files, name, data):
    content = bytearray((files / name).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path = files / f"flipped-{name}"
    path.write_bytes(content)
    try:
        tablature = formats.load(path)
    except TabError:
        return
    assert Tablature.from_json(tablature.to_json()) == tablature


def complaint(path):
    """Why a file cannot be read, None if it can."""
    try:
        formats.load(path)
    except TabError as error:
        return str(error)
    return None


def test_an_unknown_suffix_cannot_be_written(tmp_path):
    tablature = Tablature(())
    for name in ("a.pdf", "a", "a.gp5"):
        with pytest.raises(TabError, match="cannot write"):
            formats.save(tmp_path / name, tablature)
    assert list(tmp_path.iterdir()) == []


def test_without_its_library_guitar_pro_3_to_5_says_what_to_install(files, monkeypatch):
    monkeypatch.setitem(sys.modules, "guitarpro", None)
    with pytest.raises(TabError, match=r"pip install 'roboguitarist\[guitarpro\]'"):
        formats.load(files / "a.gp5")
    assert len(formats.load(files / "a.gp").notes) == len(PIECE)
