import io
import os
import zipfile
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from roboguitarist import storage
from roboguitarist.errors import RoboGuitaristError
from roboguitarist.tablature import Tablature
from strategies import tablatures


@dataclass(frozen=True)
class Item:
    tablature: Tablature
    path: np.ndarray
    names: tuple[str, ...] = ()
    hand: str = "linkage"
    rate_hz: float = 30.0
    seed: int = 0


def save(path, item):
    storage.save(path, item, {"tablature": Tablature.to_json})


def load(path) -> Item:
    return storage.load(path, Item, {"tablature": Tablature.from_json})


def npy(array) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def header(shape: str) -> bytes:
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


FIELDS = {
    "tablature": npy(np.asarray(Tablature(()).to_json())),
    "path": npy(np.arange(3.0)),
    "names": npy(np.asarray(("a", "b"))),
    "hand": npy(np.asarray("tendon")),
    "rate_hz": npy(np.asarray(30.0)),
    "seed": npy(np.asarray(1)),
}


def archive(file_path, **changes: bytes):
    with zipfile.ZipFile(file_path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in {**FIELDS, **changes}.items():
            file.writestr(f"{name}.npy", data)


@given(
    tablatures(max_notes=4),
    hnp.arrays(st.sampled_from([np.float32, np.int8, np.bool_]), hnp.array_shapes(min_side=0)),
    st.lists(st.sampled_from(["bar 1", "Für Elise, beat 2"])).map(tuple),
    st.integers(0, 2**31),
)
def test_saving_and_loading_gives_the_same(tmp_path_factory, tablature, path, names, seed):
    file = tmp_path_factory.getbasetemp() / "item.npz"
    item = Item(tablature, path, names, "tendon", 100.0, seed)
    save(file, item)
    read = load(file)
    np.testing.assert_array_equal(read.path, path)
    assert read.path.dtype == path.dtype
    assert (read.tablature, read.names, read.hand) == (tablature, names, "tendon")
    assert (read.rate_hz, read.seed) == (100.0, seed)


def test_the_bytes_depend_on_the_content_only(tmp_path):
    for name in ("a.npz", "b.npz"):
        save(tmp_path / name, Item(Tablature(()), np.arange(5)))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_objects_are_not_stored(tmp_path):
    with pytest.raises(TypeError, match="path"):
        save(tmp_path / "a.npz", Item(Tablature(()), np.asarray([object()])))
    assert not list(tmp_path.iterdir())


def test_nothing_half_written_is_left(tmp_path):
    target = tmp_path / "deep" / "a.txt"

    def write_half():
        with storage.replacing(target) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_half()
    assert not list(target.parent.iterdir())


def test_an_older_file_stays_until_the_new_one_is_whole(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with storage.replacing(target) as temporary:
        temporary.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(RoboGuitaristError, match="cannot write"):
        save(tmp_path / "file" / "a.npz", Item(Tablature(()), np.arange(5)))


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_a_full_disk_is_said(tmp_path):
    with (
        pytest.raises(RoboGuitaristError, match=r"cannot write .*a\.npz"),
        storage.replacing(tmp_path / "a.npz"),
        open("/dev/full", "wb", buffering=0) as full,
    ):
        full.write(b"x")
    assert not list(tmp_path.iterdir())


def test_the_fixture_archive_is_readable(tmp_path):
    archive(tmp_path / "a.npz")
    assert load(tmp_path / "a.npz").names == ("a", "b")


@pytest.mark.parametrize(
    "changes",
    [
        {"path": npy(np.asarray([{}], dtype=object))},
        {"path": header("(1000000000000,)")},
        {"path": header("(3,)")},
        {"path": header("(-3,)")},
        {"path": header("'x'")},
        {"path": b"not an array"},
        {"hand": npy(np.arange(3))},
        {"rate_hz": npy(np.asarray("fast"))},
        {"seed": npy(np.asarray([1, 2]))},
        {"tablature": npy(np.asarray("{}"))},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_a_hostile_member_is_refused(tmp_path, changes):
    archive(tmp_path / "a.npz", **changes)
    with pytest.raises(RoboGuitaristError):
        load(tmp_path / "a.npz")


def test_an_archive_that_unpacks_to_gigabytes_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(storage, "MAX_BYTES", 10_000)
    archive(tmp_path / "a.npz", path=npy(np.zeros(10_000)))
    with pytest.raises(RoboGuitaristError, match="unpacks"):
        load(tmp_path / "a.npz")


@pytest.mark.parametrize("cut", [0, 1, 10, 100, -1, -20])
def test_a_file_cut_short_is_refused(tmp_path, cut):
    archive(tmp_path / "a.npz")
    data = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(data[:cut])
    with pytest.raises(RoboGuitaristError):
        load(tmp_path / "a.npz")


@given(st.binary(max_size=200))
def test_any_bytes_are_refused(tmp_path_factory, data):
    file = tmp_path_factory.getbasetemp() / "junk.npz"
    file.write_bytes(data)
    with pytest.raises(RoboGuitaristError):
        load(file)


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(RoboGuitaristError, match=r"b\.npz: No such file"):
        load(tmp_path / "b.npz")
    with pytest.raises(RoboGuitaristError, match="cannot read"):
        load(tmp_path)
    np.savez(tmp_path / "a.npz", path=np.arange(3))
    with pytest.raises(RoboGuitaristError, match="tablature"):
        load(tmp_path / "a.npz")


def test_a_file_from_before_a_field_was_there_is_read(tmp_path):
    path = tmp_path / "item.npz"
    with zipfile.ZipFile(path, "w") as file:
        for name in ("tablature", "path", "hand"):
            file.writestr(f"{name}.npy", FIELDS[name])
    item = load(path)
    assert (item.hand, item.rate_hz, item.names) == ("tendon", 30.0, ())
