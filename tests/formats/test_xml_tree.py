import pytest

from roboguitarist.errors import TabError
from roboguitarist.formats import xml_tree

TEXT = '<?xml version="1.0"{}?><a><b>Für  \n Elise</b></a>'
LAUGHS = "<!DOCTYPE a [" + "".join(
    f'<!ENTITY {name} "{f"&{before};" * 10}">'
    for before, name in zip("abcdefghi", "bcdefghij", strict=True)
)


@pytest.mark.parametrize(
    "data",
    [
        TEXT.format("").encode(),
        b"\xef\xbb\xbf" + TEXT.format("").encode(),
        TEXT.format(' encoding="UTF-16"').encode("utf-16"),
        TEXT.format(' encoding="UTF-16"').encode("utf-16-be"),
        TEXT.format(' encoding="ISO-8859-1"').encode("latin-1"),
        TEXT.format(' encoding="windows-1252"').encode("cp1252"),
        TEXT.format(' encoding="UTF-16"').encode(),
        TEXT.format(' encoding="no-such-code"').encode(),
        TEXT.format("").replace("<a>", '<a xmlns="urn:x">').encode(),
    ],
    ids=["utf-8", "mark", "utf-16", "utf-16-be", "latin", "windows", "lie", "unknown", "namespace"],
)
def test_encodings(data):
    assert xml_tree.text(xml_tree.parse(data), "b") == "Für Elise"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"<a><b></a>", "broken XML: mismatched tag"),
        (b"<a><b>", "broken XML: no element found"),
        (b"<a>\xff\xfe</a>", "broken XML"),
        (b"", "broken XML"),
        (b"<a/><b/>", "broken XML: junk"),
        (b"<a b='" + b"x" * 200_000 + b"'/>", "tag"),
        (b"<a>" * 200 + b"</a>" * 200, "nested"),
        (LAUGHS.encode() + b"]><a>&j;</a>", "entities"),
        (b"<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]><a>&b;</a>", "entities"),
        (b"<!DOCTYPE a [<!ENTITY % b SYSTEM 'http://x.invalid/'> %b;]><a/>", "entities"),
    ],
)
def test_broken_or_hostile_xml_is_refused(data, message):
    with pytest.raises(TabError, match=message):
        xml_tree.parse(data)


def test_too_many_elements_are_refused(monkeypatch):
    monkeypatch.setattr(xml_tree, "MAX_ELEMENTS", 10)
    assert len(xml_tree.parse(b"<a>" + b"<b/>" * 9 + b"</a>")) == 9
    with pytest.raises(TabError, match="more than 10"):
        xml_tree.parse(b"<a>" + b"<b/>" * 10 + b"</a>")


def test_a_document_type_alone_does_no_harm():
    data = b'<!DOCTYPE a PUBLIC "-//X//DTD" "http://x.invalid/a.dtd"><a><b>1</b></a>'
    assert xml_tree.integer(xml_tree.parse(data), "b") == 1


@pytest.mark.parametrize(
    ("written", "value"), [("3", 3), (" -2 ", -2), ("0.5", 0.5), (".25", 0.25), ("+7.", 7)]
)
def test_numbers_are_exact(written, value):
    assert xml_tree.number(xml_tree.parse(f"<a>{written}</a>".encode()), ".") == value


@pytest.mark.parametrize("written", ["x", "1e9", "1e999999999", "1/0", "nan", "9" * 30, "1_0", "٣"])
def test_what_is_not_a_number_is_refused(written):
    with pytest.raises(TabError, match="is not a number"):
        xml_tree.number(xml_tree.parse(f"<x><a>{written}</a></x>".encode()), "a")


def test_nothing_is_no_number():
    assert xml_tree.number(xml_tree.parse(b"<x><a/></x>"), "a") is None
    assert xml_tree.integer(xml_tree.parse(b"<x/>"), "a") is None
