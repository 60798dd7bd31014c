"""A performance as an animated 3D scene in one GLB file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from roboguitarist import __version__, replay, storage
from roboguitarist.export.gltf import INDICES, VERTICES, Document, png
from roboguitarist.export.surfaces import joined, surface
from roboguitarist.looks import HELD_RAD, VISUAL_GROUP
from roboguitarist.performance import Performance

FPS = 30
STILL_M, STILL_RAD = 1e-6, 1e-4
"""What moves by less than this is not animated."""
SHORT_MAX = 32767
ASPECT = 16 / 9
_CLAMP, _REPEAT, _LINEAR, _MIPMAPS = 33071, 10497, 9729, 9987


def write_glb(performance: Performance, path: str | Path) -> None:
    """Write a performance as an animated glTF scene.

    Args:
        performance: What to show.
        path: File to write; it appears when it is complete.

    Raises:
        RoboGuitaristError: If the performance does not fit its scene, or the file cannot be
            written.
    """
    content = animated_scene(performance)
    with storage.replacing(path) as temporary:
        temporary.write_bytes(content)


def animated_scene(performance: Performance, times_s: np.ndarray | None = None) -> bytes:
    """The GLB file of a performance.

    One node per body of the model, under `roboguitarist`, which turns the guitar's frame to
    glTF's: y up, the strings towards +z, the guitar's head held up. Its `extras.start_s` is the
    time in the piece of the animation's beginning. The cameras are those of `looks.CAMERAS`.

    Args:
        performance: What to show.
        times_s: (F,) times of the pictures, in seconds from the start of the piece; by default
            `FPS` a second from `replay.LEAD_S` before the piece to the last tick.

    Raises:
        RoboGuitaristError: If the performance does not fit its scene.
    """
    model = replay.scene(performance)
    times_s = replay.frame_times(performance, FPS) if times_s is None else times_s
    poses = replay.body_poses(model, replay.postures(performance, times_s))
    document = Document()
    parts = _Parts(document, model)
    nodes = [parts.node(body) for body in range(model.nbody)]
    for body in range(1, model.nbody):
        parent = document.items["nodes"][nodes[model.body_parentid[body]]]
        parent.setdefault("children", []).append(nodes[body])
    root = document.items["nodes"][nodes[0]]
    root["rotation"] = _upright().as_quat().tolist()
    root["extras"] = {"start_s": float(times_s[0])}
    _animate(document, model, poses, nodes, times_s - times_s[0])
    return document.glb(
        [nodes[0]], generator=f"RoboGuitarist {__version__}",
        extras={"title": performance.tablature.title, "composer": performance.tablature.composer},
    )  # fmt: skip


def _upright() -> Rotation:
    """From the guitar's frame, whose y axis points down, to glTF's."""
    return Rotation.from_euler("z", np.pi + HELD_RAD)


class _Parts:
    """Nodes, meshes, materials and cameras of a model's bodies."""

    def __init__(self, document: Document, model: mujoco.MjModel) -> None:
        self._document, self._model = document, model
        self._meshes: dict[str, int] = {}
        self._materials = [self._material(index) for index in range(model.nmat)]

    def node(self, body: int) -> int:
        """A body with what is seen of it; `_animate` puts it in its place."""
        model, document = self._model, self._document
        name = model.body(body).name if body else "roboguitarist"
        properties: dict[str, Any] = {"name": name}
        own = (model.geom_bodyid == body) & (model.geom_group == VISUAL_GROUP)
        geoms: list[int] = np.flatnonzero(own).tolist()
        apart = [geom for geom in geoms if model.geom(geom).name.endswith("_seen") and not body]
        together = [geom for geom in geoms if geom not in apart]
        if together:
            properties["mesh"] = self._mesh(name, together)
        children = [
            document.add("nodes", name=model.geom(geom).name, mesh=self._mesh("string", [geom]))
            for geom in apart
        ]
        cameras = np.flatnonzero(model.cam_bodyid == body)
        children += [self._camera(int(camera)) for camera in cameras]
        if children:
            properties["children"] = children
        return document.add("nodes", **properties)

    def _mesh(self, name: str, geoms: list[int]) -> int:
        """One mesh of geoms of one body, a primitive for each material."""
        model, document = self._model, self._document
        primitives = []
        for material in sorted({int(model.geom_matid[geom]) for geom in geoms}):
            chosen = [geom for geom in geoms if model.geom_matid[geom] == material]
            shape = joined([surface(model, geom) for geom in chosen])
            attributes = {
                "POSITION": document.array(
                    shape.points.astype(np.float32), target=VERTICES, bounds=True
                ),
                "NORMAL": document.array(shape.normals.astype(np.float32), target=VERTICES),
            }
            if "baseColorTexture" in self._pbr(material):
                places = shape.texture.astype(np.float32)
                attributes["TEXCOORD_0"] = document.array(places, target=VERTICES)
            kind = np.uint16 if len(shape.points) < 65535 else np.uint32
            indices = document.array(shape.faces.ravel().astype(kind), target=INDICES)
            primitives.append(
                {
                    "attributes": attributes,
                    "indices": indices,
                    "material": self._materials[material],
                }
            )
        key = repr(primitives)
        if key not in self._meshes:
            self._meshes[key] = document.add("meshes", name=name, primitives=primitives)
        return self._meshes[key]

    def _pbr(self, material: int) -> dict[str, Any]:
        return self._document.items["materials"][self._materials[material]]["pbrMetallicRoughness"]

    def _material(self, index: int) -> int:
        model = self._model
        metal = float(model.mat_metallic[index])
        pbr: dict[str, Any] = {
            "metallicFactor": max(0.0, metal),
            "roughnessFactor": max(0.0, float(model.mat_roughness[index])),
        }
        texture = int(model.mat_texid[index, mujoco.mjtTextureRole.mjTEXROLE_RGB])
        if texture >= 0:
            pbr["baseColorTexture"] = {"index": self._texture(texture)}
        else:
            rgba = model.mat_rgba[index].astype(float)
            pbr["baseColorFactor"] = [*_linear(rgba[:3]).tolist(), float(rgba[3])]
        return self._document.add("materials", name=model.mat(index).name, pbrMetallicRoughness=pbr)

    def _texture(self, index: int) -> int:
        model, document = self._model, self._document
        height, width = int(model.tex_height[index]), int(model.tex_width[index])
        start = model.tex_adr[index]
        pixels = model.tex_data[start : start + 3 * height * width].reshape(height, width, 3)
        image = document.add(
            "images", name=model.tex(index).name, mimeType="image/png",
            bufferView=document.blob(png(pixels)),
        )  # fmt: skip
        if "samplers" not in document.items:
            document.add(
                "samplers", magFilter=_LINEAR, minFilter=_MIPMAPS, wrapS=_REPEAT, wrapT=_REPEAT
            )
        return document.add("textures", source=image, sampler=0)

    def _camera(self, index: int) -> int:
        model, document = self._model, self._document
        lens = {"yfov": float(np.radians(model.cam_fovy[index])), "znear": 0.01, "zfar": 20.0,
                "aspectRatio": ASPECT}  # fmt: skip
        name = model.cam(index).name
        camera = document.add("cameras", name=name, type="perspective", perspective=lens)
        return document.add(
            "nodes", name=f"camera_{name}", camera=camera,
            translation=model.cam_pos[index].tolist(),
            rotation=np.roll(model.cam_quat[index], -1).tolist(),
        )  # fmt: skip


def _linear(rgb: np.ndarray) -> np.ndarray:
    """Colours in sRGB as the linear ones that glTF wants (IEC 61966-2-1)."""
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def _animate(
    document: Document,
    model: mujoco.MjModel,
    poses: tuple[np.ndarray, np.ndarray],
    nodes: list[int],
    times_s: np.ndarray,
) -> None:
    """Put every body where it is first, and add one animation of those that move.

    Both in the frame of the body's parent. A finger that never moves may be bent all the same.
    """
    channels, samplers = [], []
    input_ = document.array(times_s.astype(np.float32), bounds=True)

    def move(node: int, path: str, values: np.ndarray) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        output = document.array(values)
        samplers.append({"input": input_, "interpolation": "LINEAR", "output": output})

    for body in range(1, model.nbody):
        offset, turn = _in_parent(model, poses, body)
        node = document.items["nodes"][nodes[body]]
        node["translation"], node["rotation"] = offset[0].tolist(), turn[0].tolist()
        if np.ptp(offset, axis=0).max() > STILL_M:
            move(nodes[body], "translation", offset.astype(np.float32))
        if np.ptp(turn, axis=0).max() > STILL_RAD:
            move(nodes[body], "rotation", np.round(SHORT_MAX * turn).astype(np.int16))
    if channels:
        document.add("animations", name="performance", channels=channels, samplers=samplers)


def _in_parent(
    model: mujoco.MjModel, poses: tuple[np.ndarray, np.ndarray], body: int
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (F, 3) and orientations (F, 4), w last and without jumps of sign."""
    positions, orientations = poses
    parent = model.body_parentid[body]
    back = Rotation.from_quat(orientations[:, parent], scalar_first=True).inv()
    offset = back.apply(positions[:, body] - positions[:, parent])
    turn = (back * Rotation.from_quat(orientations[:, body], scalar_first=True)).as_quat()
    flips = np.cumprod(np.where(np.sum(turn[1:] * turn[:-1], axis=1) < 0, -1.0, 1.0))
    turn[1:] *= flips[:, None]
    return offset, turn
