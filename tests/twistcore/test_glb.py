"""A motion as glTF: read back by a few lines of its own, and by Blender where there is one."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.amass_files import write_amass
from tests.twistcore.blender import BLENDER, needs_blender
from tests.twistcore.test_cli import run
from tests.twistcore.test_convert import same
from twistcore.errors import TwistError
from twistcore.formats.glb import write_glb
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import forward_kinematics

UNIT = 0.056444


def chunks(path):
    """The document of a GLB and its binary part."""
    data = path.read_bytes()
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    length, kind = struct.unpack("<I4s", data[12:20])
    size, binary = struct.unpack("<I4s", data[20 + length : 28 + length])
    assert (kind, binary, size) == (b"JSON", b"BIN\0", len(data) - 28 - length)
    assert length % 4 == size % 4 == 0
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def played(path):
    """Times, and the positions of all joints by name, (frames, 3), as glTF defines them."""
    gltf, data = chunks(path)
    assert gltf["buffers"] == [{"byteLength": len(data)}]

    def array(number):
        accessor = gltf["accessors"][number]
        view = gltf["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        assert view["byteLength"] == 4 * width * accessor["count"]
        start = view["byteOffset"]
        return np.frombuffer(data, "<f4", width * accessor["count"], start).reshape(-1, width)

    (animation,) = gltf["animations"]
    (time,) = {sampler["input"] for sampler in animation["samplers"]}
    times, curves = array(time)[:, 0], {}
    limits = gltf["accessors"][time]
    assert (limits["min"], limits["max"]) == ([times[0]], [times[-1]])
    for channel in animation["channels"]:
        target = channel["target"]["node"], channel["target"]["path"]
        curves[target] = array(animation["samplers"][channel["sampler"]]["output"])
        assert len(curves[target]) == len(times)
    places = {}

    def descend(node, above):
        one = gltf["nodes"][node]
        own = np.tile(np.eye(4), (len(times), 1, 1))
        turn = curves.get((node, "rotation"), one.get("rotation", [0, 0, 0, 1]))
        own[:, :3, :3] = Rotation.from_quat(turn).as_matrix()
        own[:, :3, 3] = curves.get((node, "translation"), one.get("translation", [0, 0, 0]))
        whole = above @ own
        places[one["name"]] = whole[:, :3, 3]
        for child in one.get("children", ()):
            descend(child, whole)

    (root,) = gltf["scenes"][gltf["scene"]]["nodes"]
    descend(root, np.eye(4))
    assert sorted(gltf["skins"][0]["joints"]) == sorted({*range(len(gltf["nodes"]))} - {root})
    assert places.pop(gltf["nodes"][root]["name"]).any() == 0
    return times, places


@pytest.mark.parametrize("name", ["walk", "dance"])
def test_all_joints_are_where_the_clip_has_them(name, tmp_path):
    motion = read_clip(ASSETS / f"{name}.bvh").motion
    write_glb(motion, tmp_path / "a.glb", unit=UNIT)
    times, places = played(tmp_path / "a.glb")
    assert times == pytest.approx(motion.times, abs=1e-6)
    assert {*places} == {*motion.skeleton.names}
    found = np.stack([places[joint] for joint in motion.skeleton.names], axis=1) / UNIT
    away = np.abs(found - forward_kinematics(motion)[1]).max()
    assert away < 1e-6 * motion.skeleton.height


def test_z_up_becomes_y_up(walk, tmp_path):
    path = tmp_path / "z.npz"
    write_amass(path, walk.motion)
    motion = read_clip(path).motion
    write_glb(motion, tmp_path / "z.glb")
    _, places = played(tmp_path / "z.glb")
    expected = forward_kinematics(motion)[1][..., [0, 2, 1]] * [1.0, 1.0, -1.0]
    found = np.stack([places[joint] for joint in motion.skeleton.names], axis=1)
    assert np.abs(found - expected).max() < 1e-5 * motion.skeleton.height


def test_a_joint_that_moves_in_its_parent_has_its_own_keys(walk, tmp_path):
    motion, hand = walk.motion, walk.skeleton.index("LeftHand")
    away = walk.skeleton.offsets[hand] + np.sin(motion.times)[:, None]
    places = np.stack([motion.positions[:, 0], away], axis=1)
    motion = replace(motion, positioned=(0, hand), positions=places)
    write_glb(motion, tmp_path / "a.glb")
    found = played(tmp_path / "a.glb")[1]["LeftHand"]
    expected = forward_kinematics(motion)[1][:, hand]
    assert np.abs(found - expected).max() < 1e-5 * motion.skeleton.height


def test_neighbouring_keys_are_never_opposite(walk, tmp_path):
    """Some programs interpolate between q and -q the long way round."""
    flipped = walk.motion.rotations * np.where(np.arange(walk.frames) % 2, 1.0, -1.0)[:, None, None]
    write_glb(walk.motion.with_rotations(flipped), tmp_path / "a.glb")
    gltf, data = chunks(tmp_path / "a.glb")
    for accessor, view in zip(gltf["accessors"], gltf["bufferViews"], strict=True):
        if accessor["type"] == "VEC4":
            q = np.frombuffer(data, "<f4", 4 * walk.frames, view["byteOffset"]).reshape(-1, 4)
            assert (np.einsum("ij,ij->i", q[1:], q[:-1]) > 0.0).all()


def test_a_motion_that_no_program_could_read_is_refused(walk, tmp_path):
    broken = walk.motion.rotations.copy()
    broken[3, 4] = np.nan
    for motion in (walk.motion.with_rotations(broken), walk.motion.sliced(0, 0)):
        with pytest.raises(TwistError, match=r"a\.glb"):
            write_glb(motion, tmp_path / "a.glb")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("unit", [1e38, 1e308])
def test_lengths_that_are_too_large_for_gltf_are_refused(walk, unit, tmp_path):
    with pytest.raises(TwistError, match=r"lengths below 3\.4e"):
        write_glb(walk.motion, tmp_path / "a.glb", unit=unit)
    far = replace(walk.motion, positions=np.full_like(walk.motion.positions, 1e60))
    with pytest.raises(TwistError, match=r"lengths below 3\.4e"):
        write_glb(far, tmp_path / "a.glb", unit=1.0 / unit)
    assert not list(tmp_path.iterdir())


def test_names_that_are_no_text_are_escaped(walk, tmp_path):
    names = ("Hüfte", "bad\udce9", *walk.skeleton.names[2:])
    motion = replace(walk.motion, skeleton=replace(walk.skeleton, names=names))
    write_glb(motion, tmp_path / "a.glb")
    gltf, _ = chunks(tmp_path / "a.glb")
    read = [node["name"] for node in gltf["nodes"][:2]]
    assert read[0] == "Hüfte"
    assert read[1].encode("utf-8").startswith(b"bad")


# -- the command -----------------------------------------------------------------------------------


def test_the_command_says_how_tall_the_figure_is(capsys, tmp_path):
    out = tmp_path / "walk.glb"
    words = ("convert", ASSETS / "walk.bvh", "-o", out, "--unit", UNIT, "--fps", 60)
    code, printed, err = run(capsys, *words)
    assert (code, err) == (0, "")
    assert names_in_one_line(printed, "344 frames at 60 fps", "31 joints", " 1.")
    assert played(out)[0][-1] == pytest.approx(343 / 60)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["walk.fbx", "-o", "a.glb"], "walk.fbx"),
        (["walk.bvh", "-o", "a.glb", "--take", "one"], "--take"),
        (["walk.bvh", "-o", "a.glb", "--time-limit", "9"], "--time-limit"),
        (["none.bvh", "-o", "a.glb"], "none.bvh"),
    ],
)
def test_what_makes_no_sense_is_refused(words, named, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "walk.fbx").write_bytes(b"")
    (tmp_path / "walk.bvh").write_bytes((ASSETS / "walk.bvh").read_bytes())
    code, _, err = run(capsys, "convert", *words)
    assert code == 2
    assert names_in_one_line(err, named)
    assert not (tmp_path / "a.glb").exists()


def test_the_source_is_never_replaced(capsys, tmp_path):
    source = tmp_path / "walk.bvh"
    source.write_bytes((ASSETS / "walk.bvh").read_bytes())
    (tmp_path / "link.glb").symlink_to(source)
    code, _, _ = run(capsys, "convert", source, "-o", tmp_path / "link.glb")
    assert code == 2
    assert source.read_bytes() == (ASSETS / "walk.bvh").read_bytes()


@needs_blender
def test_blender_reads_an_armature_that_moves_as_the_clip(capsys, tmp_path):
    glb, back = tmp_path / "walk.glb", tmp_path / "back.bvh"
    assert run(capsys, "convert", ASSETS / "walk.bvh", "-o", glb, "--unit", UNIT)[0] == 0
    words = ("convert", glb, "-o", back, "--blender", BLENDER, "--unit", UNIT)
    code, printed, err = run(capsys, *words)
    assert (code, err) == (0, "")
    assert names_in_one_line(printed, "344 frames", "120 fps", "31 joints of walk", "take walk")
    same(read_clip(back).motion, 1e-6, 0.01)
