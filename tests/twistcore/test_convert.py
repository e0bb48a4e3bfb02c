"""Scenes as BVH: what Blender hands over becomes the motion, and a Blender that fails is told."""

import json
import os
import stat
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.blender import BLENDER, blender, needs_blender
from tests.twistcore.scene_rigs import random_rotations
from tests.twistcore.test_cli import run
from twistcore.errors import TwistError
from twistcore.formats.blender import Handover, find_blender
from twistcore.formats.blender.scene_motion import motion_from_scene
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import conjugate, geodesic_angle, matrix_from_quaternion, multiply

CLIP = read_bvh(ASSETS / "walk.bvh")
MOTION = CLIP.motion
NAMES, PARENTS = MOTION.skeleton.names, MOTION.skeleton.parents
UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # Y up to Z up


def handover(motion, unit=0.01, **more):
    """As Blender would show a motion: Z up, metres, bones with rest axes of their own."""
    joints = len(motion.skeleton)
    rotations, positions = forward_kinematics(motion)
    still = np.zeros((1, joints, 4))
    still[..., 0] = 1.0
    heads = forward_kinematics(motion.at(np.zeros(1, dtype=int)).with_rotations(still))[1][0]
    rest, poses = np.zeros((joints, 4, 4)), np.zeros((motion.frames, joints, 4, 4))
    rest[:, 3, 3] = poses[..., 3, 3] = 1.0
    axes = matrix_from_quaternion(random_rotations(joints, 3))
    rest[:, :3, :3] = axes
    rest[:, :3, 3] = heads @ UP.T * unit
    poses[..., :3, :3] = UP @ matrix_from_quaternion(rotations) @ UP.T @ axes
    poses[..., :3, 3] = positions @ UP.T * unit
    words = {
        "names": NAMES, "parents": PARENTS, "rest": rest, "poses": poses, "fps": motion.fps,
        "tails": rest[:, :3, 3] + 0.1, "figure": "walk", "take": "walk", "blender": "5",
    }  # fmt: skip
    return Handover(**{**words, **more})


def same(found, at_most, degrees):
    """The same joints at the same places at the same time, turned alike from the first frame on."""
    assert (found.frames, found.skeleton.names) == (MOTION.frames, NAMES)
    assert found.fps == pytest.approx(MOTION.fps, rel=1e-5)
    (ours, places), (theirs, other) = forward_kinematics(MOTION), forward_kinematics(found)
    assert np.abs(places - other).max() < at_most * MOTION.skeleton.height
    a, b = (multiply(q, conjugate(q[:1])) for q in (ours, theirs))
    assert np.degrees(geodesic_angle(a, b)).max() < degrees


def test_what_is_handed_over_becomes_the_motion():
    found = motion_from_scene(handover(MOTION), 0.01)
    same(found.motion, 1e-12, 1e-5)
    assert found.notes == ()
    assert found.motion.positioned == (0,)
    assert np.abs(geodesic_angle(found.motion.rotations, MOTION.rotations)).max() < 1e-7
    offsets = found.motion.skeleton.offsets
    assert offsets[1:] == pytest.approx(MOTION.skeleton.offsets[1:], abs=1e-9)
    assert motion_from_scene(handover(MOTION), 1.0).motion.skeleton.offsets == pytest.approx(
        offsets / 100
    )
    assert dict(found.motion.skeleton.ends).keys() == dict(MOTION.skeleton.ends).keys()


def test_what_a_bvh_cannot_hold_is_told():
    scene = handover(MOTION)
    hand, arm = NAMES.index("LeftHand"), NAMES.index("LeftArm")
    scene.poses[5, hand, :3, :3] *= 1.5
    scene.poses[7, hand, :3, 3] += 0.02
    found = motion_from_scene(scene, 0.01)
    assert all("LeftHand" in note for note in found.notes[:2])
    assert hand in found.motion.positioned
    places = forward_kinematics(found.motion)[1]
    assert places[7, hand] == pytest.approx(scene.poses[7, hand, :3, 3] @ UP / 0.01, abs=1e-6)
    scene.poses[9, arm, :3, 0] *= -1.0
    with pytest.raises(TwistError, match="mirrored"):
        motion_from_scene(scene, 0.01)
    scene.poses[9, arm, :3, 0] = 0.0
    with pytest.raises(TwistError, match=r"size|scale"):
        motion_from_scene(scene, 0.01)


@pytest.fixture
def fake(tmp_path):
    """A program that answers as Blender's script does, or behaves as it is told to."""

    def make(body):
        program = tmp_path / "blender"
        program.write_text(
            f"#!{sys.executable}\nimport json, os, sys, time\nfrom pathlib import Path\n"
            "words = json.loads(Path(sys.argv[-1]).read_text())\nout = Path(words['out'])\n" + body
        )
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        return program

    return make


def convert(capsys, tmp_path, program, *words, name="walk.fbx"):
    scene = tmp_path / name
    scene.write_bytes(b"")
    out = tmp_path / "out.bvh"
    return (*run(capsys, "convert", scene, "-o", out, "--blender", program, *words), scene, out)


def test_the_command_writes_what_was_handed_over(capsys, fake, tmp_path):
    scene = handover(MOTION)
    arrays = tmp_path / "arrays.npz"
    np.savez(arrays, rest=scene.rest, tails=scene.tails, poses=scene.poses)
    answer = {
        "names": NAMES, "parents": PARENTS.tolist(), "fps": MOTION.fps, "figure": "walk",
        "take": "run", "blender": "5.0.1",
    }  # fmt: skip
    program = fake(
        f"(out / 'arrays.npz').write_bytes(Path({str(arrays)!r}).read_bytes())\n"
        f"(out / 'answer.json').write_text({json.dumps(answer)!r})\n"
        "import tempfile\nwords['temporary'] = tempfile.gettempdir()\n"
        f"Path({str(tmp_path / 'words.json')!r}).write_text(json.dumps([words, sys.argv[1:]]))\n"
    )
    code, told, err, source, out = convert(capsys, tmp_path, program, "--take", "run")
    assert (code, err) == (0, "")
    facts = (f"{out}: 344 frames", "120 fps", "31 joints", "walk", "run", "Y ", "0.01 m", "5.0.1")
    assert names_in_one_line(told, *facts)
    same(read_bvh(out).motion, 1e-6, 1e-4)
    words, arguments = json.loads((tmp_path / "words.json").read_text())
    assert (words["source"], words["take"], words["figure"]) == (str(source), "run", None)
    assert arguments[:2] == ["--background", "--factory-startup"]
    assert words["temporary"] == words["out"]  # what Blender leaves there is gone with it


@pytest.mark.parametrize(
    ("body", "facts"),
    [
        ("print('oh dear')\nsys.exit(11)", ("Blender", " 11", "oh dear")),
        ("os.kill(os.getpid(), 11)", ("Blender", "-11")),
        (
            "(out / 'answer.json').write_text(json.dumps({'error': 'expected one\\narmature'}))",
            ("expected one armature",),
        ),
    ],
)
def test_a_blender_that_fails_is_one_sentence(capsys, fake, tmp_path, body, facts):
    code, told, err, source, out = convert(capsys, tmp_path, fake(body))
    assert (code, told) == (2, "")
    assert names_in_one_line(err, f"{source}: ", *facts)
    assert not out.exists()


@pytest.mark.skipif(os.name != "posix", reason="process groups")
def test_a_blender_that_hangs_is_ended_with_its_children(capsys, fake, tmp_path):
    program = fake(
        "import subprocess\nchild = subprocess.Popen(['sleep', '600'])\n"
        f"Path({str(tmp_path / 'pid')!r}).write_text(str(child.pid))\ntime.sleep(600)\n"
    )
    code, _, err, source, _ = convert(capsys, tmp_path, program, "--time-limit", "2")
    assert code == 2
    assert names_in_one_line(err, f"{source}: ", "Blender", "2 s", "--time-limit")
    child = Path("/proc") / (tmp_path / "pid").read_text() / "stat"
    for _ in range(100):
        if not child.exists() or child.read_text().rpartition(")")[2].split()[0] == "Z":
            break
        time.sleep(0.05)
    else:
        pytest.fail("the child goes on")


def test_what_cannot_be_converted_is_one_sentence(capsys, tmp_path, monkeypatch):
    scene = tmp_path / "a.fbx"
    for source, out, facts in (
        (tmp_path / "a.obj", tmp_path / "o.bvh", ("a.obj: ", " .fbx, .glb, ")),
        (scene, tmp_path / "o.npz", ("o.npz: ", " .bvh")),
        (scene, tmp_path / "o.bvh", ("a.fbx: ",)),
    ):
        words = ("convert", source, "-o", out, "--blender", sys.executable)
        code, told, err = run(capsys, *words)
        assert (code, told) == (2, "")
        assert names_in_one_line(err, *facts)
    words = ("convert", scene, "-o", tmp_path / "o.bvh")
    monkeypatch.delenv("TWIST_BLENDER", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("twistcore.formats.blender.process.find_spec", lambda _: None)
    code, _, err = run(capsys, *words)
    assert code == 2
    assert names_in_one_line(err, "`blender`")
    code, _, err = run(capsys, *words, "--blender", "nowhere")
    assert code == 2
    assert names_in_one_line(err, "--blender: ", "'nowhere'")


def test_blender_is_looked_for_in_this_order(monkeypatch, tmp_path):
    for folder in ("named", "variable", "path"):
        (tmp_path / folder).mkdir()
        program = tmp_path / folder / "blender"
        program.write_text("")
        program.chmod(0o755)
    named, variable = (str(tmp_path / f / "blender") for f in ("named", "variable"))
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    monkeypatch.setenv("TWIST_BLENDER", variable)
    assert find_blender(named) == named
    assert find_blender() == variable
    monkeypatch.delenv("TWIST_BLENDER")
    assert find_blender() == str(tmp_path / "path" / "blender")
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("twistcore.formats.blender.process.find_spec", lambda _: True)
    assert find_blender() == sys.executable


# -- with Blender itself ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """The walk as FBX, its curves whole and simplified, as glTF and as Blender's own file."""
    folder = tmp_path_factory.mktemp("scenes")
    blender(
        folder,
        ["empty"],
        ["bvh", CLIP.path],
        ["to_fbx", folder / "walk.fbx"],
        ["to_fbx", folder / "few.fbx", 1.0],
        ["to_glb", folder / "walk.glb"],
        ["save", folder / "walk.blend"],
        ["second_take", "held"],
        ["to_fbx", folder / "takes.fbx"],
        ["to_glb", folder / "takes.glb"],
        ["bvh", ASSETS / "kick.bvh"],
        ["save", folder / "two.blend"],
        ["empty"],
        ["save", folder / "none.blend"],
    )
    return folder


@needs_blender
@pytest.mark.parametrize(
    ("name", "at_most", "degrees"),
    [
        ("walk.fbx", 1e-4, 0.2),  # keys a thousandth of a frame beside the frames
        ("few.fbx", 5e-3, 3.0),  # what the simplification left
        ("walk.glb", 2e-6, 0.01),
        ("walk.blend", 1e-6, 0.01),
    ],
)
def test_scenes_come_out_as_the_clip_that_they_were_made_of(
    capsys, scenes, tmp_path, name, at_most, degrees
):
    out = tmp_path / "out.bvh"
    words = ("convert", scenes / name, "-o", out, "--blender", BLENDER, "--unit", "1")
    code, told, err = run(capsys, *words)
    assert (code, err) == (0, "")
    assert names_in_one_line(told, "344 frames", "120 fps", "31 joints", "take walk")
    same(read_bvh(out).motion, at_most, degrees)


@needs_blender
@pytest.mark.parametrize("name", ["takes.fbx", "takes.glb"])
def test_one_of_several_takes_is_named(capsys, scenes, tmp_path, name):
    words = ("convert", scenes / name, "-o", tmp_path / "o.bvh", "--blender", BLENDER)
    code, _, err = run(capsys, *words)
    assert code == 2
    assert names_in_one_line(err, "--take", "held, walk")
    turns = {}
    for take in ("walk", "held"):
        code, told, _ = run(capsys, *words, "--take", take)
        assert code == 0
        assert names_in_one_line(told, "344 frames", f"take {take}")
        turns[take] = forward_kinematics(read_bvh(tmp_path / "o.bvh").motion)[0]
    assert np.degrees(geodesic_angle(turns["walk"], turns["held"])[:98]).max() < 0.1
    still = np.degrees(geodesic_angle(turns["held"][100:101], turns["held"][100:])).max()
    moved = np.degrees(geodesic_angle(turns["walk"][100:101], turns["walk"][100:])).max()
    assert still < 0.1
    assert moved > 10.0


@needs_blender
def test_one_of_several_is_named(capsys, scenes, tmp_path):
    out = tmp_path / "out.bvh"
    words = ("convert", scenes / "two.blend", "-o", out, "--blender", BLENDER)
    code, _, err = run(capsys, *words)
    assert code == 2
    assert names_in_one_line(err, "--armature", "kick, walk")
    code, told, _ = run(capsys, *words, "--armature", "walk", "--fps", "30")
    assert code == 0
    assert "86 frames at 30 fps" in told
    every = read_bvh(out).motion
    away = forward_kinematics(every)[1] - forward_kinematics(MOTION)[1][::4]
    assert np.abs(away).max() < 1e-3 * MOTION.skeleton.height
    code, _, err = run(capsys, *words, "--armature", "dance")
    assert names_in_one_line(err, "dance", "kick, walk")
    code, _, err = run(capsys, *words, "--armature", "walk", "--take", "run")
    assert names_in_one_line(err, "run", "held, kick, walk")
    code, _, err = run(capsys, "convert", scenes / "none.blend", "-o", out, "--blender", BLENDER)
    assert names_in_one_line(err, "armature")
    bad = tmp_path / "bad.fbx"
    bad.write_bytes(b"no FBX at all")
    code, _, err = run(capsys, "convert", bad, "-o", tmp_path / "b.bvh", "--blender", BLENDER)
    assert (code, err.count("\n")) == (2, 1)
    assert names_in_one_line(err, "Blender")
    assert not (tmp_path / "b.bvh").exists()
