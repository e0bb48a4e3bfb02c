"""What every public verb keeps, whatever it is given: of clips, of motions, and of reviews."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import twistcore
from tests.conftest import ASSETS
from tests.tiers import examples
from tests.twistcore import amc_files
from tests.twistcore.amass_files import write_amass
from tests.twistcore.reviews import CHAINS, CLIP, LIMBS, commands, fresh
from tests.twistcore.strategies import angles, axes, orders, quaternions
from twistcore import (
    Interval,
    Motion,
    OwnChain,
    Rig,
    Skeleton,
    TwistError,
    analyse,
    detect,
    find_chains,
    find_limbs,
    read_clip,
    read_session,
    refine,
    survey_folder,
    twist_signals,
    write_clip,
    write_motion,
    write_session,
)
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rig import read_rig, write_rig
from twistcore.skeleton.rotation import (
    conjugate,
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    rotate,
    twist_angle,
    wrap,
)

WALK = CLIP.motion.sliced(130, 230)
FOUND = detect(WALK)
SOME = settings(
    max_examples=examples(8),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
seeds = st.integers(0, 2**32 - 1)


def told(found):
    """What is found, to compare."""
    return [(i.chain, i.start, i.stop, i.kind, round(i.shown, 6)) for i in found]


def shape_of(chains):
    return [(type(c), c.parent, c.child, c.grandchild, c.side, c.segment) for c in chains]


def all_of(motion):
    chains = find_chains(motion)
    return *chains, *find_limbs(motion, chains)


# -- files -----------------------------------------------------------------------------------------


@st.composite
def bvh_texts(draw):
    """Figures of any shape with numbers in any writing."""
    rng = np.random.default_rng(draw(seeds))
    depth, columns, lines = 0, 0, ["HIERARCHY"]
    for k in range(draw(st.integers(1, 7))):
        order = draw(orders)
        placed = k == 0 or rng.random() < 0.2
        words = [f"{a}position" for a in "XYZ"] * placed + [f"{a}rotation" for a in order]
        columns += len(words)
        up = int(rng.integers(0, depth)) if k else 0
        lines += ["}"] * up
        depth += 1 - up
        lines += [f"{'JOINT' if k else 'ROOT'} j{k % 3}", "{", f"OFFSET 0 {rng.normal():.4g} 1e-1"]
        lines += [f"CHANNELS {len(words)} {' '.join(words)}"]
    lines += ["}"] * depth
    rows = rng.normal(scale=200.0, size=(draw(st.integers(1, 4)), columns))
    form = draw(st.sampled_from(["%.6f", "%g", "%.17g", "%+.2f", "%.3e", "%d"]))
    lines += ["MOTION", f"Frames: {len(rows)}", "Frame Time: .02"]
    lines += [draw(st.sampled_from([" ", "\t", "  "])).join(form % x for x in row) for row in rows]
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join([*lines, ""])


@SOME
@given(bvh_texts())
def test_a_bvh_is_read_and_written_byte_for_byte_and_what_was_made_of_it_is_the_same(
    tmp_path, text
):
    path, out = tmp_path / "a.bvh", tmp_path / "b.bvh"
    path.write_bytes(text.encode())
    clip = read_clip(path)
    assert write_clip(clip, clip.motion, out) == ()
    assert out.read_bytes() == path.read_bytes()
    write_motion(clip.motion, out)
    again = read_clip(out).motion
    here, there = (forward_kinematics(m) for m in (clip.motion, again))
    assert again.skeleton.names == clip.skeleton.names
    assert again.skeleton.parents.tolist() == clip.skeleton.parents.tolist()
    assert geodesic_angle(here[0], there[0]).max() < 1e-6
    np.testing.assert_allclose(here[1], there[1], atol=1e-4)
    assert again.frame_time == pytest.approx(clip.frame_time)


@pytest.mark.parametrize("kind", ["amc", "npz", "packed npz"])
def test_other_formats_are_read_and_written_byte_for_byte(kind, tmp_path):
    if kind == "amc":
        path = amc_files.written(tmp_path / "in", full=True, frames=12)
    else:
        path = write_amass(tmp_path / "a.npz", WALK, packed=kind != "npz")
    clip = read_clip(path)
    out = tmp_path / f"out{path.suffix}"
    assert write_clip(clip, clip.motion, out) == ()
    assert out.read_bytes() == path.read_bytes()
    once = refine(clip.motion, all_of(clip.motion), shifts(clip.motion, 0))
    write_clip(clip, once, out)
    if kind != "amc":
        assert geodesic_angle(read_clip(out).motion.rotations, once.rotations).max() < 1e-6


# -- a figure elsewhere, of another size, with other names, in a mirror, backwards -----------------


def moved(motion, by):
    return replace(motion, positions=motion.positions + by)


def turned(motion, q):
    """The whole figure about the origin."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = normalise(multiply(q, rotations[:, 0]))
    return replace(motion, rotations=rotations, positions=rotate(q, motion.positions))


def scaled(motion, by):
    skeleton = motion.skeleton
    ends = tuple((j, tuple(by * np.array(end))) for j, end in skeleton.ends)
    other = replace(skeleton, offsets=by * skeleton.offsets, ends=ends)
    return replace(motion, skeleton=other, positions=by * motion.positions)


def renamed(motion, how):
    return replace(motion, skeleton=replace(motion.skeleton, names=tuple(map(how, names(motion)))))


def names(motion):
    return motion.skeleton.names


def other_side(name):
    """The name on the other side, of a limb's two joints too."""
    swapped = name.replace("Left", "~").replace("Right", "Left")
    return swapped.replace("~", "Right")


def mirrored(motion):
    """x becomes −x, left becomes right."""
    across, q = np.array([-1.0, 1.0, 1.0]), np.array([1.0, 1.0, -1.0, -1.0])
    skeleton = motion.skeleton
    ends = tuple((j, tuple(across * np.array(end))) for j, end in skeleton.ends)
    other = replace(skeleton, offsets=across * skeleton.offsets, ends=ends)
    made = replace(motion, skeleton=other, positions=across * motion.positions)
    return renamed(made.with_rotations(motion.rotations * q), other_side)


@SOME
@given(quaternions, st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3))
def test_where_a_figure_stands_and_how_it_is_turned_changes_nothing(q, by):
    other = moved(turned(WALK, q), np.array(by))
    assert shape_of(all_of(other)) == shape_of(all_of(WALK))
    assert told(detect(other)) == told(FOUND)
    assert np.abs(analyse(other).poses[1] - (rotate(q, analyse(WALK).poses[1]) + by)).max() < 1e-6


@SOME
@given(st.floats(-3.0, 3.0))
def test_the_unit_of_length_changes_nothing(power):
    other = scaled(WALK, 10.0**power)
    assert shape_of(all_of(other)) == shape_of(all_of(WALK))
    assert told(detect(other)) == told(FOUND)


@pytest.mark.parametrize(
    "how", [lambda n: f"mixamorig:{n}", lambda n: f"Bip01 {n}", str.lower, lambda n: f"rig_{n}"]
)
def test_a_rig_s_own_way_to_write_names_changes_nothing(how):
    other = renamed(WALK, how)
    assert shape_of(all_of(other)) == shape_of(all_of(WALK))
    assert told(detect(other)) == [(how(i[0]), *i[1:]) for i in told(FOUND)]


def test_in_a_mirror_the_other_side_is_found_and_turned_the_other_way():
    other = detect(mirrored(WALK))
    assert told(FOUND)
    assert len(other) == len(FOUND)
    for i in FOUND:
        (same,) = (o for o in other if (o.start, o.chain) == (i.start, other_side(i.chain)))
        assert (same.stop, same.kind) == (i.stop, i.kind)
        np.testing.assert_allclose(wrap(same.offset + i.offset), 0.0, atol=1e-6)


def test_backwards_the_signals_are_those_forwards_a_frame_later():
    backwards = WALK.at(np.arange(WALK.frames)[::-1])
    for chain in find_chains(WALK):
        one, other = (twist_signals(m, chain) for m in (WALK, backwards))
        np.testing.assert_allclose(other.theta_p[::-1], one.theta_p, atol=1e-12)
        np.testing.assert_allclose(other.strength[:0:-1], one.strength[1:], atol=1e-9)
        np.testing.assert_allclose(other.dtheta_c[:0:-1], -one.dtheta_c[1:], atol=1e-9)


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_the_shortest_clips_are_looked_at_and_left_as_they_are(frames):
    motion = WALK.sliced(0, frames)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        analysis = analyse(motion)
        found = analysis.detect()
        assert shape_of(analysis.chains) == shape_of(find_chains(WALK))
        for name, signals in analysis.signals.items():
            assert signals.strength.shape == analysis.by().strength(name).shape == (frames,)
            assert np.isfinite(signals.theta_c).all()
        refined = refine(motion, analysis.chains_and_limbs, automatic_corrections(found))
    assert (refined.rotations == motion.rotations).all()


# -- signals ---------------------------------------------------------------------------------------


@settings(max_examples=examples(40))
@given(st.lists(quaternions, min_size=2, max_size=5), axes, angles)
def test_swing_and_twist_are_the_rotation(parent, axis, turn):
    """q = q_s ⊗ R_a(θp), where q_s has no twist about a; and a twist more is a twist more."""
    q = np.array(parent)
    child = np.tile([1.0, 0.0, 0.0, 0.0], (len(q), 1))
    skeleton = Skeleton(("a", "b", "c"), np.array([-1, 0, 1]), np.array([[0, 0, 0], axis, axis]))
    motion = Motion(
        skeleton, np.stack([q, child, child], axis=1), (), np.zeros((len(q), 0, 3)), 0.1
    )
    chain = twistcore.Chain("a", 0, 1, 2, axis, np.array([0.0, 0.0, 1.0]))
    found = twist_signals(motion, chain)
    sound = found.swing_reliability > 1e-3
    twist = quaternion_from_axis_angle(axis, found.theta_p)
    swing = multiply(q, conjugate(twist))
    assert np.abs(twist_angle(swing, axis))[sound].max(initial=0.0) < 1e-6
    assert geodesic_angle(multiply(swing, twist), q).max() < 1e-6
    more = multiply(q, quaternion_from_axis_angle(axis, turn))
    later = twist_signals(motion.with_rotations(np.stack([more, child, child], axis=1)), chain)
    assert np.abs(wrap(later.theta_p - found.theta_p - turn))[sound].max(initial=0.0) < 1e-6


# -- taking out ------------------------------------------------------------------------------------


def shifts(motion, seed):
    """Intervals of any chains and limbs, none over another of a limb's own frames."""
    rng = np.random.default_rng(seed)
    every = all_of(motion)
    out = []
    for k in rng.choice(len(every), 3, replace=False).tolist():
        start, stop = sorted(rng.integers(0, motion.frames + 1, 2).tolist())
        out.append(Interval(every[k].name, start, stop, rng.uniform(-3.0, 3.0, stop - start)))
    return out


@SOME
@given(seeds)
def test_only_the_frames_and_joints_of_what_is_taken_out_change(seed):
    every = {c.name: c for c in all_of(WALK)}
    wanted = shifts(WALK, seed)
    refined = refine(WALK, [*every.values()], wanted)
    may = np.zeros(WALK.rotations.shape[:2], dtype=bool)
    for i in wanted:
        may[i.start : i.stop, list(every[i.chain].changed_joints(WALK.skeleton))] = True
    assert (refined.rotations == WALK.rotations)[~may].all()
    assert refined.positions is WALK.positions
    assert (refine(WALK, [*every.values()], []).rotations == WALK.rotations).all()
    backwards = refine(WALK, [*every.values()], wanted[::-1])
    assert geodesic_angle(backwards.rotations, refined.rotations).max() < 1e-6


@SOME
@given(seeds)
def test_what_is_taken_out_of_a_chain_and_put_back_is_as_it_was_and_moves_no_joint(seed):
    rng = np.random.default_rng(seed)
    chain = CHAINS[int(rng.integers(len(CHAINS)))]
    offset = rng.uniform(-3.0, 3.0, 40)
    one = Interval(chain.name, 30, 70, offset)
    refined = refine(WALK, CHAINS, [one])
    put_back = refine(refined, CHAINS, [replace(one, offset=-offset)])
    assert geodesic_angle(put_back.rotations, WALK.rotations).max() < 1e-6
    assert geodesic_angle(refined.rotations, WALK.rotations).max() > 1e-3
    below = (chain.child, *WALK.skeleton.children[chain.child])
    here, there = (forward_kinematics(m)[1][:, below] for m in (WALK, refined))
    np.testing.assert_allclose(here, there, atol=1e-8)


def test_taken_out_once_there_is_nothing_left_to_take_out():
    refined = refine(WALK, FOUND.chains_and_limbs, automatic_corrections(FOUND))
    again = detect(refined)
    assert automatic_corrections(FOUND)
    assert not automatic_corrections(again)
    twice = refine(refined, again.chains_and_limbs, automatic_corrections(again))
    assert (twice.rotations == refined.rotations).all()


# -- folders, rigs, sessions -----------------------------------------------------------------------


def test_a_folder_is_looked_at_worst_first_whatever_else_lies_in_it(tmp_path):
    for name in ("walk", "walk_injected"):
        (tmp_path / f"{name}.bvh").write_bytes((ASSETS / f"{name}.bvh").read_bytes())
    (tmp_path / "broken.bvh").write_bytes(b"HIERARCHY")
    (tmp_path / "notes.txt").write_bytes(b"none")
    found = survey_folder(tmp_path)
    assert [s.path.name for s in found] == ["walk_injected.bvh", "walk.bvh", "broken.bvh"]
    assert [bool(s.problem) for s in found] == [False, False, True]
    assert "expected" in found[-1].problem
    assert survey_folder(tmp_path / "none") == []


@settings(max_examples=examples(15))
@given(st.sampled_from([*CHAINS, *LIMBS]), st.sampled_from([*CHAINS, *LIMBS]))
def test_a_chain_removed_and_added_as_one_s_own_is_the_chain_that_was_found(one, other):
    found = {c.name: c for c in Rig().chains(WALK)}
    rig = Rig().without(one.name)
    assert one.name not in {c.name for c in rig.chains(WALK)}
    joints = [names(WALK)[j] for j in (one.parent, one.child, one.grandchild) if j >= 0]
    own = OwnChain(tuple(joints), limb=one in LIMBS)
    assert own.name == one.name
    back = rig.with_chain(WALK, own)
    made = {c.name: c for c in back.chains(WALK)}
    np.testing.assert_allclose(made[one.name].axis, found[one.name].axis)
    assert made.keys() == found.keys()
    assert len(rig.without(other.name).chains(WALK)) == len(found) - 1 - (other is not one)
    with pytest.raises(TwistError, match="already"):
        back.with_chain(WALK, own)


@given(st.lists(st.text(min_size=1), min_size=2, max_size=3), st.lists(st.text(), max_size=3))
@SOME
def test_a_rig_is_read_as_it_was_written(tmp_path, joints, removed):
    rig = Rig((OwnChain(tuple(joints)),), tuple(dict.fromkeys(removed)))
    write_rig(tmp_path / "a.toml", rig, WALK.skeleton, "walk")
    assert read_rig(tmp_path / "a.toml") == rig


@settings(SOME, max_examples=examples(4))
@given(st.data())
def test_a_review_is_read_as_it_was_written(tmp_path, data):
    review = fresh()
    for _ in range(data.draw(st.integers(1, 6))):
        review.do(data.draw(commands(review.state)))
    write_session(CLIP, review.state, tmp_path / "a.json")
    session = read_session(tmp_path / "a.json")
    assert (session.sha256, session.fps) == (CLIP.sha256, CLIP.motion.fps)
    assert [(j.id, j.decision) for j in session.state.intervals] == [
        (j.id, j.decision) for j in review.state.intervals
    ]
    write_session(CLIP, session.state, tmp_path / "b.json")
    first, second = ((tmp_path / n).read_bytes() for n in ("a.json", "b.json"))
    assert first == second
