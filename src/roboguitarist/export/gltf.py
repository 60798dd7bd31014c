"""A glTF 2.0 document under construction, and its binary form, GLB.

After the Khronos Group's specification "glTF 2.0", 2021. Only what this package writes is here.
"""

from __future__ import annotations

import json
import struct
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

FLOAT, SHORT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5122, 5123, 5125
VERTICES, INDICES = 34962, 34963
_COMPONENT = {"f4": FLOAT, "i2": SHORT, "u2": UNSIGNED_SHORT, "u4": UNSIGNED_INT}
_TYPE = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4"}
_GLB, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942


@dataclass
class Document:
    """Lists as glTF names them; what is added gets the next index of its list.

    Attributes:
        items: The lists by name, such as `nodes` or `meshes`.
    """

    items: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    _binary: bytearray = field(default_factory=bytearray)
    _known: dict[tuple[Any, ...], int] = field(default_factory=dict)

    def add(self, kind: str, **properties: Any) -> int:
        """Append an item to the list `kind` and return its index."""
        entries = self.items.setdefault(kind, [])
        entries.append(properties)
        return len(entries) - 1

    def array(self, values: np.ndarray, *, target: int | None = None, bounds: bool = False) -> int:
        """Store an array (n,) or (n, 2 to 4) and return its accessor; equal arrays share one.

        Args:
            values: float32, uint16, uint32, or int16 that stand for -1 to 1.
            target: `VERTICES`, `INDICES`, or None for an animation's numbers.
            bounds: Write the least and the greatest values, which some uses must have.
        """
        code = values.dtype.str[1:]
        raw = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
        key = (raw, code, values.shape, target)
        if key not in self._known:
            accessor: dict[str, Any] = {
                "bufferView": self.blob(raw, target),
                "componentType": _COMPONENT[code],
                "count": len(values),
                "type": _TYPE[values.shape[1:]],
            }
            if code == "i2":
                accessor["normalized"] = True
            if bounds:
                least, greatest = values.min(axis=0), values.max(axis=0)
                accessor["min"], accessor["max"] = (
                    np.atleast_1d(v).tolist() for v in (least, greatest)
                )
            self._known[key] = self.add("accessors", **accessor)
        return self._known[key]

    def blob(self, raw: bytes, target: int | None = None) -> int:
        """Store bytes and return their buffer view."""
        self._binary.extend(bytes(-len(self._binary) % 4))
        view: dict[str, Any] = {
            "buffer": 0,
            "byteOffset": len(self._binary),
            "byteLength": len(raw),
        }
        if target:
            view["target"] = target
        self._binary.extend(raw)
        return self.add("bufferViews", **view)

    def glb(self, roots: list[int], **asset: Any) -> bytes:
        """The whole document in one piece, with one scene.

        Args:
            roots: Nodes of the scene.
            asset: Entries about the document, such as `generator`.
        """
        binary = bytes(self._binary) + bytes(-len(self._binary) % 4)
        whole = {
            "asset": {"version": "2.0", **asset},
            "scene": 0,
            "scenes": [{"nodes": roots}],
            **self.items,
            "buffers": [{"byteLength": len(binary)}],
        }
        text = json.dumps(whole, separators=(",", ":"), ensure_ascii=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = [
            struct.pack("<II", len(text), _JSON) + text,
            struct.pack("<II", len(binary), _BIN) + binary,
        ]
        length = 12 + sum(map(len, chunks))
        return struct.pack("<III", _GLB, 2, length) + b"".join(chunks)


def png(image: np.ndarray) -> bytes:
    """An image (height, width, 3) of uint8 as PNG."""
    height, width, _ = image.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
