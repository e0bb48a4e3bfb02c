"""Keys back into the scene: the script's arithmetic, and what it says to Maya and MotionBuilder."""

import math
import sys
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import names_in_one_line, numbers
from tests.twistcore.reviews import CHAINS, CLIP, LIMBS, flip, fresh
from tests.twistcore.scene_rigs import ORDERS, Cmds, Rig, Sdk
from tests.twistcore.test_cli import run
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.errors import TwistError
from twistcore.export.scene_keys import scene_keys
from twistcore.export.scene_script import PROGRAMS, SceneOptions, scene_script
from twistcore.review import Decide, Decision, Track, Tracking, write_session
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, quaternion_from_euler

MOTION = CLIP.motion.sliced(110, 150)


@cache
def corrected():
    return refine(MOTION, CHAINS, [new_constant_offset_interval("LeftForeArm", 12, 28, -0.36)])


def script(program, motion=MOTION, after=None, **options):
    after = corrected() if after is None else after
    return scene_script(CLIP.name, motion, after, [], SceneOptions(program, **options))


def played(monkeypatch, text, program):
    for name, module in program.modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    exec(compile(text, "script.py", "exec"), {})


def turns(rig, first=0, step=1.0):
    """Rotations of all joints in their parents', at the clip's frames."""
    frames = [first + step * k for k in range(MOTION.frames)]
    return np.array([[rig.local(j, f) for f in frames] for j in range(len(rig.names))])


def check(rig, before, after):
    """The arm moves in its frames as it shall, in the world; everything else stays."""
    touched = (MOTION.rotations != corrected().rotations).any(axis=2).T
    assert np.array_equal(before[~touched], after[~touched])
    old, new = (forward_kinematics(m)[0] for m in (MOTION, corrected()))
    joint = MOTION.skeleton.index("LeftForeArm")
    for frame, beside in ((12, 7), (27, 32)):
        # S = A·G·B: what the scene turns between two frames is what the clip turns, seen from B
        now, here = (rig.world(joint, rig.frames[f])[0] for f in (frame, beside))
        clip = geodesic_angle(old[beside, joint], new[frame, joint])
        assert geodesic_angle(here, now) == pytest.approx(clip, abs=1e-6)


@pytest.mark.parametrize("angle", ["deg", "rad"])
def test_maya_gets_the_keys_and_nothing_else(monkeypatch, capsys, angle):
    rig = Rig(MOTION)
    cmds, before = Cmds(rig, angle=angle), turns(rig)
    places = [rig.world(j, 20)[1] for j in range(len(rig.names))]
    hand = rig.world(rig.index("LeftHand"), 20)[0]
    played(monkeypatch, script("maya"), cmds)
    check(rig, before, turns(rig))
    assert "32 keys were set" in capsys.readouterr().out
    for joint, place in enumerate(places):
        assert rig.world(joint, 20)[1] == pytest.approx(place, abs=1e-6)
    assert geodesic_angle(hand, rig.world(rig.index("LeftHand"), 20)[0]) < 1e-6
    keyed = {call[1:] for call in cmds.called if call[0] == "key"}
    assert keyed == {(n, float(f)) for n in ("LeftForeArm", "LeftHand") for f in range(12, 28)}
    pinned = {call[2] for call in cmds.called if call[0] == "insert"}
    assert pinned == {11.0, 28.0}
    assert cmds.called[0] == ("undo", "openChunk", "chunkName")
    assert cmds.called[-1] == ("undo", "closeChunk")
    assert [c[0] for c in cmds.called].count("undo") == 2


def test_motionbuilder_gets_the_keys_and_nothing_else(monkeypatch, capsys):
    rig = Rig(MOTION, seed=7)
    sdk, before = Sdk(rig), turns(rig)
    played(monkeypatch, script("motionbuilder", take="walk"), sdk)
    check(rig, before, turns(rig))
    assert sdk.system.CurrentTake.Name == "walk"
    assert sdk.frame == pytest.approx(3.0)  # where the person was
    assert (sdk.called[0], sdk.called[-1]) == ("begin", "end")
    assert sdk.called.count("model") == 2
    assert "32 keys were set" in capsys.readouterr().out
    with pytest.raises(RuntimeError, match="Take 001, walk"):
        played(monkeypatch, script("motionbuilder", take="run"), sdk)


def test_a_dry_run_changes_nothing_and_a_second_run_finds_nothing_to_do(monkeypatch, capsys):
    rig = Rig(MOTION)
    cmds, before = Cmds(rig), turns(rig)
    played(monkeypatch, script("maya", dry_run=True), cmds)
    assert np.array_equal(before, turns(rig))
    assert not cmds.called
    assert "32 keys" in capsys.readouterr().out
    played(monkeypatch, script("maya"), cmds)
    after = turns(rig)
    played(monkeypatch, script("maya"), cmds)
    assert np.array_equal(after, turns(rig))
    assert "32 keys" in capsys.readouterr().out


def test_frames_of_the_scene_may_lie_elsewhere_and_closer(monkeypatch, capsys):
    """A scene at 30 frames a second, from frame 100 on; the clip has 120."""
    rig = Rig(MOTION, start=100, step=0.25, prefix="Hero:")
    cmds = Cmds(rig, time="ntsc")
    before = turns(rig, 100, 0.25)
    text = script("maya", namespace="Hero", fps=30.0 * MOTION.fps / 120, start=100)
    played(monkeypatch, text, cmds)
    assert {c[2] for c in cmds.called if c[0] == "key"} == {100 + k / 4 for k in range(12, 28)}
    check(rig, before, turns(rig, 100, 0.25))
    assert "note" not in capsys.readouterr().out
    played(monkeypatch, text, Cmds(rig, time="film"))
    note = next(line for line in capsys.readouterr().out.splitlines() if "note" in line)
    assert numbers(note) == pytest.approx([24, 30], abs=0.001)


def refusal(monkeypatch, text, program):
    before = turns(program.rig)
    with pytest.raises(RuntimeError) as found:
        played(monkeypatch, text, program)
    assert np.array_equal(before, turns(program.rig))
    assert not [c for c in program.called if c[0] in ("key", "insert")]
    return str(found.value)


def test_another_scene_is_refusal(monkeypatch):
    rig = Rig(MOTION)
    words = refusal(monkeypatch, script("maya", namespace="Hero"), Cmds(rig))
    assert "Hero:LeftForeArm, Hero:LeftHand" in words
    words = refusal(monkeypatch, script("maya", start=1), Cmds(rig))
    assert "START = 0" in words
    words = refusal(monkeypatch, script("maya", start=-20), Cmds(rig))
    assert "height" in words
    cmds = Cmds(rig)
    cmds.locked = ("|group|LeftHand.rotateY",)
    assert "locked: |group|LeftHand.rotateY" in refusal(monkeypatch, script("maya"), cmds)


def test_somebody_has_changed_a_frame_since(monkeypatch):
    rig = Rig(MOTION)
    joint = rig.index("LeftForeArm")
    rig.put(joint, 0, 20.0, rig.value(joint, 0, 20.0) + 5.0)
    words = refusal(monkeypatch, script("maya"), Cmds(rig))
    assert names_in_one_line(words, "LeftForeArm", "5.00°", " 20")


def test_channels_that_do_not_make_the_rotation_are_refusal(monkeypatch):
    """A rotation order that the script takes for another, a constraint, a layer."""
    rig = Rig(MOTION)
    cmds = Cmds(rig)
    seen = cmds.getAttr
    wrong = "|group|LeftForeArm.rotateOrder"
    cmds.getAttr = lambda plug, **more: 2 if plug == wrong else seen(plug, **more)
    words = refusal(monkeypatch, script("maya"), cmds)
    assert "LeftForeArm" in words


def test_a_correction_of_all_frames_is_keyed_and_said_to_be_blind(monkeypatch, capsys):
    after = refine(
        MOTION, CHAINS, [new_constant_offset_interval("LeftForeArm", 0, MOTION.frames, 0.5)]
    )
    keys = scene_keys(MOTION, after)
    assert {MOTION.skeleton.names[j] for j in keys.unseen} == {"LeftForeArm", "LeftHand"}
    rig = Rig(MOTION)
    played(monkeypatch, script("maya", after=after), Cmds(rig))
    out = capsys.readouterr().out
    assert f"{2 * MOTION.frames} keys were set" in out


@pytest.fixture(scope="module")
def arithmetic():
    """The functions of a script, without a program to run it in."""
    text = script("maya").replace("from maya import cmds\n", "").removesuffix("main()\n")
    functions: dict = {}
    exec(compile(text, "script.py", "exec"), functions)
    return functions


@given(
    st.sampled_from(ORDERS),
    st.lists(st.floats(-900.0, 900.0), min_size=3, max_size=3),
    st.lists(st.floats(-170.0, 170.0), min_size=3, max_size=3),
    st.booleans(),
)
def test_angles_mean_the_rotation_and_stay_on_the_turn(arithmetic, order, near, by, locked):
    """Any order, any number of turns, the middle angle at its end too; nearest of all that do."""
    if locked:
        near["XYZ".index(order[1])] = 90.0
    angles = [math.remainder(n, 720.0) + 0.02 * b for n, b in zip(near, by, strict=True)]
    q = arithmetic["from_angles"](order, angles)
    ours = quaternion_from_euler(
        order[::-1], np.radians([angles["XYZ".index(c)] for c in order[::-1]])
    )
    assert geodesic_angle(np.array(q), ours) < 1e-9
    found = arithmetic["to_angles"](order, q, near)
    assert arithmetic["degrees_between"](arithmetic["from_angles"](order, found), q) < 1e-4
    away = [sum(abs(a - b) for a, b in zip(x, near, strict=True)) for x in (found, angles)]
    turns = [360.0 * round((n - a) / 360.0) for n, a in zip(near, angles, strict=True)]
    away[1] = sum(abs(a + b - n) for a, b, n in zip(angles, turns, near, strict=True))
    assert locked or away[0] <= away[1] + 1e-6


def test_keyed_angles_go_on_from_those_before(monkeypatch):
    """A curve two turns further on, as after wild motion, is not thrown back."""
    rig = Rig(MOTION)
    joint = rig.index("LeftForeArm")
    for frame in rig.frames.tolist():
        rig.put(joint, 1, frame, rig.value(joint, 1, frame) + 720.0)
    played(monkeypatch, script("maya"), Cmds(rig))
    steps = np.diff([[rig.value(joint, axis, f) for axis in range(3)] for f in range(40)], axis=0)
    assert np.abs(steps[:27]).max() < 180.0


def test_a_scene_that_does_not_follow_its_keys_is_told(monkeypatch):
    """As where a layer above holds the joint: what was meant is compared with what is seen."""
    rig = Rig(MOTION)
    cmds = Cmds(rig)
    monkeypatch.setattr(cmds, "setKeyframe", lambda *_, **__: None)
    with pytest.raises(RuntimeError, match=r"20[.]63°"):
        played(monkeypatch, script("maya"), cmds)
    assert cmds.called[-1] == ("undo", "closeChunk")


def test_a_scene_turned_otherwise_where_nothing_is_corrected_is_refusal(monkeypatch):
    """Frames of reference must agree, or none of them tells the axes."""
    rig = Rig(MOTION)
    joint, frame = (
        rig.index("LeftForeArm"),
        float(scene_keys(MOTION, corrected()).references[2].frame),
    )
    kept = [rig.world(j, frame) for j in range(len(rig.names))]
    rig.put(joint, 2, frame, rig.value(joint, 2, frame) + 4.0)
    monkeypatch.setattr(
        Rig, "world", lambda self, j, f, seen=Rig.world: (
            (seen(self, j, f)[0], kept[j][1]) if f == frame and j >= 0 else seen(self, j, f)
        )
    )  # fmt: skip
    words = refusal(monkeypatch, script("maya"), Cmds(rig))
    assert names_in_one_line(words, f" {frame:g},", "LeftForeArm", "4.00°")


def test_references_lie_where_nothing_is_corrected():
    keys = scene_keys(MOTION, corrected())
    assert len(keys.references) == 5
    assert not {r.frame for r in keys.references} & set(range(12, 28))


def test_each_joint_has_references_where_no_frame_is_free_of_corrections():
    half = MOTION.frames // 2
    arm = new_constant_offset_interval("LeftForeArm", 0, half, 0.5)
    leg = new_constant_offset_interval("RightUpLeg", half, MOTION.frames, 0.5)
    keys = scene_keys(MOTION, refine(MOTION, CHAINS, [arm, leg]))
    assert keys.unseen == ()
    seen = {j for reference in keys.references for j in reference.joints}
    assert seen == set(keys.frames)


def test_a_joint_that_hangs_on_a_flipped_limb_is_no_reference():
    """Its own rotation is as it was, but a scene that has its keys shows it elsewhere."""
    half = MOTION.frames // 2
    flipped = flip("RightUpLeg-RightFoot", 0, half)
    knee = new_constant_offset_interval("RightLeg", half, MOTION.frames, 0.5)
    keys = scene_keys(MOTION, refine(MOTION, (*CHAINS, *LIMBS), [flipped, knee]))
    unseen = {MOTION.skeleton.names[j] for j in keys.unseen}
    assert unseen == {"RightLeg", "RightFoot"}


def test_names_with_and_without_namespaces():
    text = script("maya", namespace="A:")
    assert "'A:LeftForeArm': [" in text
    assert "'LeftForeArm': [" in script("maya", namespace="")
    with pytest.raises(TwistError, match="interval"):
        script("maya", after=MOTION)
    with pytest.raises(TwistError, match="Maya"):
        script("maya", take="x")


@pytest.mark.parametrize("program", PROGRAMS)
def test_the_command(capsys, tmp_path, program):
    """Only what was accepted; a name that would end the docstring does not."""
    review = fresh()
    first = review.state.intervals[0]
    review.do(Decide((first.id,), Decision.ACCEPTED, "Ada"))
    session, out = tmp_path / 'a"""b.session.json', tmp_path / "keys.py"
    write_session(CLIP, review.state, session)
    code, told, err = run(capsys, "export", session, CLIP.path, "--script", program, "-o", out)
    assert (code, err) == (0, "")
    assert names_in_one_line(told, f"{out}: ", "1 interval", "2 joints", program)
    text = out.read_text("utf-8")
    compile(text, str(out), "exec")
    assert f"frames {first.interval.start}-{first.interval.stop}" in text
    assert "accepted by Ada" in text
    code, _, err = run(capsys, "export", session, CLIP.path, "--script", program, "-o", session)
    assert (code, err.count("\n")) == (2, 1)


def test_the_command_names_what_is_tracked_but_no_position(capsys, tmp_path):
    """The script sets rotations only, so the tracked position is named as left out."""
    review = fresh()
    review.do(Decide((review.state.intervals[0].id,), Decision.ACCEPTED, "Ada"))
    review.do(Track(Tracking(("LeftHand", "RightHand"), place=True, spline=True, cutoff=5.0)))
    session, out = tmp_path / "a.twist.json", tmp_path / "keys.py"
    write_session(CLIP, review.state, session)
    words = ("export", session, CLIP.path, "--script", "blender", "-o", out)
    code, printed, err = run(capsys, *words)
    assert code == 1
    assert "tracking of 2 joints;" in printed
    assert "position" not in printed
    assert "position" in err


def test_nothing_accepted_is_one_sentence(capsys, tmp_path):
    session = tmp_path / "s.json"
    write_session(CLIP, fresh().state, session)
    words = ("export", session, CLIP.path, "--script", "blender", "-o", tmp_path / "x.py")
    code, told, err = run(capsys, *words)
    assert (code, told) == (2, "")
    assert names_in_one_line(err, f"{session}: ")
    assert not (tmp_path / "x.py").exists()
