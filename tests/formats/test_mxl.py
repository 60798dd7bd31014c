import pytest
from musicxml_texts import CONTAINER, archive

from roboguitarist.errors import TabError
from roboguitarist.formats import mxl

SCORE = b"<score-partwise/>"


def test_the_named_file_is_taken():
    assert mxl.score_bytes(archive({"other.xml": b"<x/>", "score.xml": SCORE})) == SCORE


def test_the_first_file_that_exists_is_taken():
    two = CONTAINER.replace("<rootfile ", '<rootfile full-path="gone.xml"/><rootfile ')
    assert mxl.score_bytes(archive({"score.xml": SCORE}, two)) == SCORE


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (archive({"score.xml": SCORE}, None), "container"),
        (archive({"score.xml": SCORE}, "<container/>"), "rootfile"),
        (archive({"elsewhere.xml": SCORE}), "rootfile"),
        (archive({"score.xml": SCORE}, "<container>"), "broken XML"),
        (archive({f"{k}": b"" for k in range(1001)}), "1000 files"),
        (archive({"score.xml": SCORE})[:-30], "broken archive"),
        (archive({"score.xml": SCORE})[:60], "broken archive"),
        (b"PK\x03\x04", "broken archive"),
    ],
)
def test_a_useless_archive_is_refused(data, message):
    with pytest.raises(TabError, match=message):
        mxl.score_bytes(data)


@pytest.mark.parametrize("place", range(4, 60, 5))
def test_a_damaged_archive_is_refused_or_read(place):
    data = bytearray(archive({"score.xml": SCORE * 50}))
    data[place] ^= 0xFF
    try:
        read = mxl.score_bytes(bytes(data))
    except TabError:
        return
    assert read == SCORE * 50


def test_a_bomb_is_refused_whatever_size_it_states(monkeypatch):
    monkeypatch.setattr(mxl, "MAX_MEMBER_BYTES", 10_000)
    data = archive({"score.xml": b" " * 10_001})
    assert len(data) < 1000
    with pytest.raises(TabError, match="unpacks to more"):
        mxl.score_bytes(data)


def test_an_encrypted_archive_is_refused():
    data = bytearray(archive({"score.xml": SCORE}))
    for magic, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        start = data.find(magic)
        while start >= 0:
            data[start + offset] |= 1
            start = data.find(magic, start + 1)
    with pytest.raises(TabError, match=r"encrypted|password"):
        mxl.score_bytes(bytes(data))


def test_a_large_archive_is_refused(monkeypatch):
    monkeypatch.setattr(mxl, "MAX_ARCHIVE_BYTES", 100)
    with pytest.raises(TabError, match="too large"):
        mxl.score_bytes(archive({"score.xml": SCORE}))


def test_the_score_of_a_guitar_pro_file_is_found():
    data = archive({"Content/meta.json": b"{}", "Content/score.gpif": b"<GPIF/>"}, None)
    assert mxl.score_bytes(data) == b"<GPIF/>"
