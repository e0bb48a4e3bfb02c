"""The script in Blender, on scenes of BVH and FBX: all bones are compared in all frames."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.hostile_texts import hostile_texts
from tests.twistcore.blender import blender, needs_blender
from tests.twistcore.reviews import CHAINS, CLIP, LIMBS, fresh
from twistcore.analysis.correction.twist_removal import refine
from twistcore.export.scene_script import SceneOptions, scene_script
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import conjugate, geodesic_angle, multiply

pytestmark = needs_blender

MOTION, FRAMES = CLIP.motion, CLIP.motion.frames
HEIGHT = MOTION.skeleton.height


@cache
def corrected():
    review = fresh()
    review.accept(0.0)
    return refine(MOTION, (*CHAINS, *LIMBS), review.state.chosen())


def written(path, **options):
    options = SceneOptions("blender", **options)
    path.write_text(scene_script(CLIP.name, MOTION, corrected(), [], options), "utf-8")
    return path


class Seen:
    """World rotations (frames, joints, 4) and heads (frames, joints, 3) in the clip's order."""

    def __init__(self, path, own=MOTION.skeleton.names):
        with np.load(path) as file:
            names, poses = file["names"].tolist(), file["poses"]
            self.sides = file["sides"]
            self.keys = json.loads(str(file["keys"]))
        at = [names.index(name) for name in own]
        self.poses = poses[:, at]
        m = self.poses[..., :3, :3]
        self.rotations = quaternions(m / np.linalg.norm(m, axis=-2, keepdims=True))
        self.heads = self.poses[..., :3, 3]


def quaternions(m):
    """By the largest of four ways to write one; (…, 3, 3) -> (…, 4)."""
    x, y, z = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    a, b, c = m[..., 2, 1], m[..., 0, 2], m[..., 1, 0]
    d, e, f = m[..., 1, 2], m[..., 2, 0], m[..., 0, 1]
    rows = [
        (1 + x + y + z, a - d, b - e, c - f),
        (a - d, 1 + x - y - z, c + f, b + e),
        (b - e, c + f, 1 - x + y - z, a + d),
        (c - f, b + e, a + d, 1 - x - y + z),
    ]
    every = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    best = np.linalg.norm(every, axis=-1).argmax(axis=-1)
    q = np.take_along_axis(every, best[..., None, None], axis=-2)[..., 0, :]
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def check(before, after, scale, moved, off):
    """Every joint in every frame, against the clip's own kinematics.

    With S = A·G·B, S_before⁻¹·S_after = B⁻¹·(G⁻¹·G')·B: the angle of what was changed is the same
    in the scene and in the clip, and so is S⁻¹ in one frame · S in another.
    """
    old, places = forward_kinematics(MOTION)
    new, places_after = forward_kinematics(corrected())
    assert np.abs(places - places_after).max() < 1e-9 * HEIGHT
    assert np.abs(after.heads - before.heads).max() < moved * HEIGHT * scale
    # what the scene turns from a frame that is as it was to this one, beside the clip
    still = int(np.flatnonzero((MOTION.rotations == corrected().rotations).all(axis=(1, 2)))[0])
    ours = multiply(conjugate(old[still]), new)
    theirs = multiply(conjugate(before.rotations[still]), after.rotations)
    first = multiply(conjugate(old[still]), old)
    theirs_first = multiply(conjugate(before.rotations[still]), before.rotations)
    for clip, scene in ((first, theirs_first), (ours, theirs)):
        away = np.abs(geodesic(clip) - geodesic(scene))
        assert np.degrees(away.max()) < off
    # the axis as well: the turns of all frames differ from the clip's by one rotation, B, a joint
    change = multiply(conjugate(before.rotations), after.rotations)
    apart = np.degrees(geodesic_angle(change, np.broadcast_to([1.0, 0, 0, 0], change.shape)))
    wanted = np.degrees(geodesic_angle(multiply(conjugate(old), new), np.array([1.0, 0, 0, 0])))
    assert np.abs(apart - wanted).max() < off
    untouched = (MOTION.rotations == corrected().rotations).all(axis=2)
    assert apart[untouched & (wanted < 1e-6)].max() < off
    return (MOTION.rotations != corrected().rotations).any(axis=2).sum()


def geodesic(q):
    return geodesic_angle(q, np.broadcast_to([1.0, 0.0, 0.0, 0.0], q.shape))


def test_a_scene_of_bvh(tmp_path):
    """Native Euler angles, with the figure turned and scaled in the room, and quaternions."""
    keys = written(tmp_path / "keys.py")
    dry = written(tmp_path / "dry.py", dry_run=True)
    for mode, scale in (("NATIVE", 1.0), ("QUATERNION", 0.01), ("XZY", 1.0)):
        out = blender(
            tmp_path,
            ["empty"],
            ["bvh", CLIP.path, mode],
            ["smooth"] if mode == "XZY" else ["turn", 40, scale],
            ["look", tmp_path / "0.npz", FRAMES],
            ["script", dry],
            ["look", tmp_path / "1.npz", FRAMES],
            ["script", keys],
            ["look", tmp_path / "2.npz", FRAMES],
            ["script", keys],
        )
        before, dried, after = (Seen(tmp_path / f"{k}.npz") for k in range(3))
        assert np.array_equal(before.poses, dried.poses)
        count = check(before, after, scale, 1e-6, 0.01)
        assert f"dry run: {count} keys would be set" in out
        assert f"{count} keys were set; " in out
        assert f"{count} keys are already correct" in out
        still = (MOTION.rotations == corrected().rotations).all(axis=(1, 2))
        assert np.array_equal(before.poses[still], after.poses[still])
        assert before.keys == after.keys
        if mode == "QUATERNION":  # none is on the other side, between which a figure would spin
            assert ((before.sides * after.sides).sum(axis=2) > 0.0).all()


_QUOTES = (
    '"', "'", "\\", '\\"', "\\'", '"]', '["a"]', '"] = 1 #', "'''", '\\\\"]', "{", "}", "{0}",
    "{}}", "%", "%(x)s", "#", "\\n", "a\nb", '\n"""\nraise SystemExit(9)\n', "ümlaut", "骨",
    "\U0001f9b4",
)  # fmt: skip


def test_hostile_names_are_data_and_their_keys_land(tmp_path):
    """Those of at most 63 bytes, which is all that a name in Blender may have."""
    texts = [text for text in dict.fromkeys((*hostile_texts(), *_QUOTES)) if _fits_blender(text)]
    assert len(texts) >= 50
    joints = len(MOTION.skeleton)
    for k, action in ((0, '"] {0} \\'), (len(texts) - joints, "a'b\nc")):
        names = tuple(texts[k : k + joints])
        skeleton = replace(MOTION.skeleton, names=names)
        before, after = (replace(m, skeleton=skeleton) for m in (MOTION, corrected()))
        options = SceneOptions("blender", take=action)
        script = scene_script('"""\nraise SystemExit(9)\n', before, after, [], options)
        (tmp_path / "keys.py").write_text(script, "utf-8")
        out = blender(
            tmp_path,
            ["empty"],
            ["bvh", CLIP.path],
            ["rename_all", names, action],
            ["look", tmp_path / "0.npz", FRAMES],
            ["script", tmp_path / "keys.py"],
            ["look", tmp_path / "1.npz", FRAMES],
            ["script", tmp_path / "keys.py"],
        )
        count = check(*(Seen(tmp_path / f"{i}.npz", names) for i in (0, 1)), 1.0, 1e-6, 0.01)
        assert f"{count} keys were set; " in out
        assert f"{count} keys are already correct" in out
    assert not list(tmp_path.glob("**/hostile*"))


def _fits_blender(text):
    data = text.encode("utf-8", "surrogatepass")
    return len(data) <= 63 and data.decode("utf-8", "ignore") == text


@pytest.mark.parametrize("simplify", [0.0, 1.0])
def test_a_scene_of_fbx(tmp_path, simplify):
    """Simplified curves have few keys: beside a run some come to hold what was there."""
    keys = written(tmp_path / "keys.py", take="walk_injected")
    out = blender(
        tmp_path,
        ["empty"],
        ["bvh", CLIP.path],
        ["to_fbx", tmp_path / "w.fbx", simplify],
        ["empty"],
        ["fbx", tmp_path / "w.fbx"],
        ["look", tmp_path / "0.npz", FRAMES],
        ["script", keys],
        ["look", tmp_path / "1.npz", FRAMES],
    )
    assert "keys were set" in out, out
    before, after = Seen(tmp_path / "0.npz"), Seen(tmp_path / "1.npz")
    if simplify:  # the scene itself is then off the clip by more: told apart from our own change
        still = (MOTION.rotations == corrected().rotations).all(axis=(1, 2))
        assert np.abs(before.poses[still] - after.poses[still]).max() < 1e-4 * HEIGHT
        assert sum(map(sum, after.keys.values())) > sum(map(sum, before.keys.values()))
    else:
        check(before, after, 1.0, 1e-4, 0.2)
        # Keys of an FBX lie up to a thousandth of a frame beside the frames, and so between two.
        assert before.keys == after.keys


def test_scenes_that_are_refused(tmp_path):
    keys = written(tmp_path / "keys.py")
    start = written(tmp_path / "start.py", start=0.0)
    take = written(tmp_path / "take.py", take="run")
    for job, script, words in (
        (
            ["rename", "LeftHand", "Hand"],
            keys,
            "missing in the scene: LeftHand (another namespace?)",
        ),
        (["shift_keys", 30], keys, "of the figure's height away from its position in the clip"),
        (["shift_keys", 0], start, "set START = 1"),
        (
            ["shift_keys", 0],
            take,
            "expected the action run on the armature walk_injected, found walk_injected",
        ),
        (
            ["constrain", "LeftForeArm", "Head"],
            keys,
            "of the figure's height away|differs from its channels",
        ),
    ):
        out = blender(
            tmp_path,
            ["empty"],
            ["bvh", CLIP.path],
            job,
            ["look", tmp_path / "0.npz", FRAMES],
            ["script", script],
            ["look", tmp_path / "1.npz", FRAMES],
        )
        assert any(word in out for word in words.split("|")), out
        assert "refused: " in out
        assert "nothing was keyed" in out
        with np.load(tmp_path / "0.npz") as a, np.load(tmp_path / "1.npz") as b:
            assert np.array_equal(a["poses"], b["poses"])
