from io import BytesIO

import numpy as np
import pytest

from builders import unpacked_glb
from roboguitarist.export.gltf import VERTICES, Document, png


def test_arrays_come_back_and_equal_ones_are_stored_once():
    document = Document()
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    first = document.array(points, target=VERTICES, bounds=True)
    odd = document.array(np.array([1, 2, 3], np.uint16))
    assert document.array(points.copy(), target=VERTICES, bounds=True) == first != odd
    content, binary = unpacked_glb(document.glb([], generator="ü"))
    accessor = content["accessors"][first]
    assert (accessor["type"], accessor["count"]) == ("VEC3", 4)
    assert (accessor["min"], accessor["max"]) == ([0, 1, 2], [9, 10, 11])
    for index, values in ((first, points), (odd, np.array([1, 2, 3], np.uint16))):
        view = content["bufferViews"][content["accessors"][index]["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        raw = binary[view["byteOffset"] :][: view["byteLength"]]
        np.testing.assert_array_equal(np.frombuffer(raw, values.dtype), values.ravel())
    assert content["asset"] == {"version": "2.0", "generator": "ü"}
    assert content["buffers"][0]["byteLength"] == len(binary)


def test_short_integers_stand_for_minus_one_to_one():
    document = Document()
    document.array(np.zeros((2, 4), np.int16))
    assert document.items["accessors"][0]["normalized"]


def test_images_come_back():
    image = pytest.importorskip("PIL.Image")
    picture = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
    np.testing.assert_array_equal(np.asarray(image.open(BytesIO(png(picture)))), picture)
