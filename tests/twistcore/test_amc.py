"""ASF/AMC: what the numbers mean, and that only those of corrected bones and frames change."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import names_in_one_line, refused
from tests.twistcore import amc_files
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.correction.twist_removal import (
    joints_lacking_channels,
    refine,
    remove_twist,
)
from twistcore.cli import main
from twistcore.errors import AmcError
from twistcore.formats.amc import parse_amc, parse_asf, read_amc
from twistcore.formats.clip import changed_rotations, create_file_patch_for_motion, write_clip
from twistcore.formats.reading import read_clip
from twistcore.review import Review, session_bytes
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, quaternion_from_euler

FULL, FEW = (parse_amc(amc_files.amc(f), parse_asf(amc_files.asf(f))) for f in (True, False))
LIMB, TURNED = "rfemur-rfoot", (60, 68)
TWISTED = (100, 112)


def with_errors(clip, carried=True):
    """A flip of the right leg; where the figure can, also a counter-twist of the left arm."""
    free = replace(clip.motion, skeleton=replace(clip.motion.skeleton, rotatable=None))
    flip, twist = np.zeros((2, clip.frames))
    flip[slice(*TURNED)], twist[slice(*TWISTED)] = np.radians(170.0), np.radians(60.0)
    offsets = {LIMB: -flip} | ({"lhumerus": twist} if clip.skeleton.rotatable.sum() > 19 else {})
    chains = analyse(clip).chains_and_limbs
    return remove_twist(free, chains, offsets, {LIMB: -flip} if carried else {}).rotations


def dirty(folder, full, name="01_03"):
    """A file with errors, and its source."""
    source = read_amc(amc_files.written(folder, full))
    out = folder / f"{name}.amc"
    write_clip(source, source.motion.with_rotations(with_errors(source)), out)
    return out


def tokens_by_place(data):
    """{(frame, bone, which): number's text} of an AMC, read without any code of ours."""
    out, frame = {}, 0
    for line in data.decode().splitlines()[3:]:
        name, *words = line.split()
        if not words:
            frame = int(name)
        out |= {(frame, name, k): word for k, word in enumerate(words)}
    return out


@pytest.mark.parametrize("full", [True, False])
def test_joints_are_where_the_documentation_of_the_format_puts_them(full):
    # T = T_parent · B, with the bone's rotation C·R·C⁻¹ at its start and the next bone at its end.
    clip = FULL if full else FEW
    frame, values = 41, amc_files.numbers(full)
    turned = {"root": Rotation.from_euler("xyz", values["root"][frame, 3:], degrees=True)}
    ends = {"root": values["root"][frame, :3]}
    _, places = forward_kinematics(clip.motion)
    for name, parent, direction, length, axis, dofs in amc_files.bones():
        start = clip.skeleton.index(name)
        np.testing.assert_allclose(places[frame, start], ends[parent], atol=1e-4)
        letters = amc_files.of(name, dofs, full).replace("r", "").split()
        own = Rotation.identity()
        for letter, angle in zip(letters, values.get(name, [[]] * 200)[frame], strict=True):
            own = Rotation.from_euler(letter, angle, degrees=True) * own
        axes = Rotation.from_euler("xyz", axis, degrees=True)
        turned[name] = turned[parent] * axes * own * axes.inv()
        along = np.array(direction) / np.linalg.norm(direction) * length
        ends[name] = ends[parent] + turned[name].apply(along)
        if (joint := clip.skeleton.end_offsets.get(start)) is not None:
            np.testing.assert_allclose(joint, along, atol=1e-9)


@pytest.mark.parametrize("clip", [FULL, FEW], ids=["full", "few"])
def test_what_is_not_changed_keeps_every_byte(clip):
    assert create_file_patch_for_motion(clip, clip.motion).data == clip.data
    again = create_file_patch_for_motion(
        clip, replace(clip.motion, rotations=clip.motion.rotations.copy())
    )
    assert again.data == clip.data


@pytest.mark.parametrize("clip", [FULL, FEW], ids=["full", "few"])
def test_every_rotation_written_anew_means_the_same(clip):
    every = np.zeros(clip.motion.rotations.shape[:2], dtype=np.bool_)
    every[:] = clip.skeleton.rotatable
    again = parse_amc(clip.patched(clip.motion, every).data, clip.asf)
    assert geodesic_angle(again.motion.rotations, clip.motion.rotations).max() < 1e-7
    np.testing.assert_allclose(again.values, clip.values, atol=1e-6)  # the same branch, too


@pytest.mark.parametrize("full", [True, False])
def test_refine_changes_the_numbers_of_accepted_frames_and_bones_alone(tmp_path, full, capsys):
    path, out = dirty(tmp_path, full), tmp_path / "01_03_refined.amc"
    assert main(["refine", str(path), "-o", str(out)]) == 0
    count = (
        "2 of 2 intervals corrected (1 counter-twist, 1 limb flip)"
        if full
        else "1 of 1 intervals corrected"
    )
    assert count in capsys.readouterr().out
    before, after = (tokens_by_place(p.read_bytes()) for p in (path, out))
    assert before.keys() == after.keys()
    changed = {(bone, frame) for (frame, bone, _), word in before.items()
               if word != after[frame, bone, _]}  # fmt: skip
    allowed = {("rfemur", f + 1) for f in range(*TURNED)}
    if full:
        twisted = [f + 1 for f in range(*TWISTED)]
        allowed |= {(bone, f) for bone in ("lhumerus", "lradius") for f in twisted}
    assert changed == allowed
    assert not any("e" in after[place] for place in after if after[place] != before[place])
    assert {len(after[p].partition(".")[2]) for p in after if after[p] != before[p]} == {6}
    clean = read_amc(tmp_path / "01_02.amc").motion
    assert geodesic_angle(read_amc(out).motion.rotations, clean.rotations).max() < 1e-5
    capsys.readouterr()
    assert main(["diff", str(path), str(out)]) == 0
    said = capsys.readouterr().out
    assert ("rfemur" in said, "lradius" in said) == (True, full)


@pytest.mark.thorough
@pytest.mark.usefixtures("batch_here")
def test_the_skeleton_goes_along_into_another_folder(tmp_path):
    path, other = dirty(tmp_path, full=True), tmp_path / "other"
    other.mkdir()
    assert main(["refine", str(path), "-o", str(other / "out.amc")]) == 0
    skeleton = read_amc(path).asf.path
    assert (other / skeleton.name).read_bytes() == skeleton.read_bytes()
    batch = ["batch", str(path), "-o", str(tmp_path / "batch"), "--refine", "--workers", "1"]
    assert main(batch) == 0
    corrected = read_amc(tmp_path / "batch" / "corrected" / path.name)
    assert corrected.data == (other / "out.amc").read_bytes()


def test_another_skeleton_there_is_not_taken_for_the_clips(tmp_path, capsys):
    path, other = dirty(tmp_path, full=True), tmp_path / "other"
    other.mkdir()
    skeleton = other / read_amc(path).asf.path.name
    skeleton.write_bytes(b"of another figure")
    assert main(["refine", str(path), "-o", str(other / "out.amc")]) == 2
    assert names_in_one_line(capsys.readouterr().err, str(skeleton))
    assert sorted(other.iterdir()) == [skeleton]


def test_a_session_replays_the_bytes(tmp_path):
    path, out, again = dirty(tmp_path, True), tmp_path / "out.amc", tmp_path / "again.amc"
    clip = read_clip(path)
    review = Review.of(analyse(clip).detect())
    review.accept()
    session = tmp_path / "s.json"
    session.write_bytes(session_bytes(clip, review.state))
    assert main(["apply", str(session), str(path), "-o", str(out)]) == 0
    assert main(["refine", str(path), "-o", str(again)]) == 0
    assert out.read_bytes() == again.read_bytes() != path.read_bytes()


def test_a_bone_that_cannot_turn_so_is_told_and_left(tmp_path, capsys):
    chains = {c.name: c for c in analyse(FEW).chains_and_limbs}
    assert uncorrectable_joints(FEW.motion, chains["rhumerus"]) == ("rradius",)
    assert uncorrectable_joints(FEW.motion, chains[LIMB]) == ("rfoot",)
    assert uncorrectable_joints(FEW.motion, chains[LIMB], carried=True) == ()
    path = amc_files.written(tmp_path, False)
    assert main(["info", str(path)]) == 0
    said = capsys.readouterr().out
    assert re.search(r"Right Arm .*: rradius\n", said)
    assert re.search(r"Right leg .*: rfoot\n", said)
    # A flip whose foot was kept, in a figure of which the motion shows it though no file could.
    shown = FEW.motion.with_rotations(with_errors(FEW, carried=False))
    (kept,) = (i for i in analyse(shown).detect(kinds=["limb flip"]))
    assert not kept.carried
    assert joints_lacking_channels(shown, chains[LIMB], [kept]) == ("rfoot",)
    left = refine(shown, tuple(chains.values()), [kept])
    assert np.array_equal(left.rotations, shown.rotations)
    changed = np.zeros(shown.rotations.shape[:2], dtype=np.bool_)
    changed[5, FEW.skeleton.index("rradius")] = True
    with refused(ValueError, "'rradius'"):
        FEW.patched(shown, changed)


def test_one_of_two_flips_is_corrected_where_the_end_of_the_other_was_kept():
    free = replace(FEW.motion, skeleton=replace(FEW.motion.skeleton, rotatable=None))
    chains = analyse(FEW).chains_and_limbs
    both, along = np.zeros((2, FEW.frames))
    both[20:30] = both[60:68] = along[60:68] = 2.5
    bad = remove_twist(free, chains, {LIMB: both}, {LIMB: along})
    told = remove_twist(
        FEW.motion.with_rotations(bad.rotations), chains, {LIMB: -both}, {LIMB: -along}
    )
    changed = (told.rotations != bad.rotations).any(axis=2)
    assert np.flatnonzero(changed.any(axis=1)).tolist() == list(range(60, 68))


def test_what_is_shown_is_what_is_written():
    analysis = analyse(FEW.motion.with_rotations(with_errors(FEW)))
    (carried,) = analysis.detect(kinds=["limb flip"])
    kept = replace(carried, start=carried.start + 4, stop=carried.stop + 4, carried=False)
    shown = Corrected(analysis)
    shown.take([carried, kept])
    told = refine(analysis.motion, analysis.chains_and_limbs, [carried, kept])
    for joint, ways in enumerate(forward_kinematics(told)[1][:, :, None].swapaxes(0, 1)):
        np.testing.assert_array_equal(shown.joint_paths(np.array([joint]), 0, FEW.frames), ways)
    assert (told.rotations != analysis.motion.rotations).any()


def test_angles_are_those_of_the_file_about_the_axes_of_the_bone():
    joint = FEW.skeleton.index("lhumerus")
    np.testing.assert_allclose(FEW.angles(joint), amc_files.numbers(False)["lhumerus"], atol=1e-3)
    order, angles = FEW.euler(joint)
    q = FEW.as_written(joint, FEW.motion.rotations[:, joint])
    assert geodesic_angle(quaternion_from_euler(order, angles), q).max() < 1e-7
    assert FEW.euler(FEW.skeleton.index("lradius")) is None
    assert FEW.angles(FEW.skeleton.index("lfoot")).shape == (FEW.frames, 2)


def test_radians_mean_the_same_and_stay_radians():
    angles, lines = np.radians(FULL.values), [":FULLY-SPECIFIED :RADIANS"]
    for frame in range(FULL.frames):
        lines.append(str(frame + 1))
        for joint, layout in enumerate(FULL.asf.channels):
            columns = sorted([*layout.rotation, *(c for _, c in layout.position)])
            shown = [FULL.values[frame, c] if c < 3 else angles[frame, c] for c in columns]
            if columns:
                lines.append(f"{FULL.skeleton.names[joint]} {' '.join(f'{x:.12f}' for x in shown)}")
    clip = parse_amc("\n".join(lines).encode(), FULL.asf)
    assert geodesic_angle(clip.motion.rotations, FULL.motion.rotations).max() < 1e-9
    turned = clip.motion.rotations.copy()
    turned[3] = FULL.motion.rotations[90]
    again = parse_amc(
        create_file_patch_for_motion(clip, clip.motion.with_rotations(turned)).data, FULL.asf
    )
    assert geodesic_angle(again.motion.rotations, turned).max() < 1e-9


def test_rate():
    assert FULL.frame_time == 1 / 120
    assert names_in_one_line(str(FULL.warnings[0]), "120", "--fps")
    assert parse_amc(FULL.data, FULL.asf, fps=60.0).frame_time == 1 / 60
    said = FULL.data.replace(b":DEGREES", b":DEGREES\r\n:SAMPLES-PER-SECOND 100")
    clip = parse_amc(said, FULL.asf)
    assert (clip.frame_time, clip.warnings) == (0.01, ())


def test_the_root_starts_elsewhere():
    asf = parse_asf(amc_files.asf(True).replace(b"position 0 0 0", b"position 1 2 3"))
    clip = parse_amc(FULL.data, asf)
    assert "position" in str(clip.warnings[0])
    moved = clip.motion.positions - FULL.motion.positions
    np.testing.assert_allclose(moved, np.broadcast_to([1.0, 2.0, 3.0], moved.shape))
    there = clip.motion.positions.copy()
    there[9, 0, 1] += 0.5
    again = parse_amc(
        create_file_patch_for_motion(clip, replace(clip.motion, positions=there)).data, asf
    )
    np.testing.assert_allclose(again.motion.positions, there, atol=1e-6)
    assert again.values[9, 1] == pytest.approx(FULL.values[9, 1] + 0.5)


def test_order_of_the_degrees_of_freedom():
    asf = parse_asf(amc_files.asf(True).replace(b"dof rx ry rz", b"dof rz rx ry", 1))  # lfemur
    clip = parse_amc(FULL.data, asf)
    x, y, z = amc_files.numbers(True)["lfemur"][5]
    axes = Rotation.from_euler("z", 20.0, degrees=True)
    own = Rotation.from_euler("zxy", [x, y, z], degrees=True)
    q = (axes * own * axes.inv()).as_quat(scalar_first=True)
    joint = clip.skeleton.index("lfemur")
    assert geodesic_angle(clip.motion.rotations[5, joint], q) < 1e-5
    every = np.zeros(clip.motion.rotations.shape[:2], dtype=np.bool_)
    every[:, joint] = True
    again = parse_amc(clip.patched(clip.motion, every).data, asf)
    assert not changed_rotations(again, again.motion).any()
    assert geodesic_angle(again.motion.rotations, clip.motion.rotations).max() < 1e-7


def test_the_skeleton_beside(tmp_path):
    path = amc_files.written(tmp_path, False, name="05_02")
    own = amc_files.asf(False).replace(b"length 7.1 ", b"length 9.5 ")
    assert read_clip(path).asf.path.name == "05.asf"
    (tmp_path / "other.ASF").write_bytes(own)
    assert read_clip(path).asf.path.name == "05.asf"
    copied = path.rename(tmp_path / "05_02_fixed_again.AMC")
    assert read_clip(copied).asf.path.name == "05.asf"
    (tmp_path / "05.asf").rename(tmp_path / "05_02.asf")
    assert read_clip(copied).asf.path.name == "05_02.asf"
    (tmp_path / "05_02.asf").rename(tmp_path / "elsewhere.asf")
    with refused(AmcError, "05_02_fixed_again.asf", " 2 "):
        read_clip(copied)
    (tmp_path / "elsewhere.asf").unlink()
    assert read_clip(copied).skeleton.offsets[2:].max() > 3.0
    (tmp_path / "other.ASF").unlink()
    with refused(AmcError, "05_02_fixed_again.asf"):
        read_clip(copied)


def test_its_skeleton_alone_is_no_clip(tmp_path):
    amc_files.written(tmp_path, True)
    with refused(AmcError, ".amc", path=str(tmp_path / "01.asf")):
        read_clip(tmp_path / "01.asf")


@pytest.mark.parametrize(
    ("old", "new", "line", "column", "facts"),
    [
        (b"lradius 7", b"lradius x7", 17, 9, ("'x7",)),
        (b"lradius 7", b"lradius nan 7", 17, 13, ("'lradius'", "1", "2")),
        (b"lradius", b"lradios", 17, 1, ("'lradios'", "skeleton.asf")),
        (b"\r\n2\r\n", b"\r\nltoes 1\r\n2\r\n", 25, 1, ("'ltoes'", "frame 1")),
        (b"lhumerus", b"# lhumerus", 25, 1, ("'lhumerus'", "frame 1")),
        (b":DEGREES\r\n1\r\n", b"\r\n", 4, 1, ("'root'",)),
        (b":DEGREES", b":SAMPLES-PER-SECOND 0", 3, 21, ()),
        (b"root 4", b"root 1e300", 5, 6, ("'1e300'",)),
    ],
)
def test_bad_motions_are_one_sentence_with_a_place(old, new, line, column, facts):
    data = FEW.data.replace(b"lradius ", b"lradius 7", 1)
    assert old in data
    with refused(AmcError, *facts, path="clip.amc", line=line, column=column):
        parse_amc(data.replace(old, new, 1), FEW.asf)


@pytest.mark.parametrize(
    ("old", "new", "line", "column", "facts"),
    [
        (b":root", b":roots", 1, None, (":root",)),
        (b"angle deg", b"angle gon", 7, 9, ("deg", "rad", "'gon'")),
        (b"order TX", b"order TW", 11, 10, ("RZ", "'TW'")),
        (b"dof rx", b"dof tx", 29, 9, ("rx, ry", "'tx'")),
        (b"dof rx ry", b"dof rx rx", 29, 12, ("'rx'",)),
        (b"name ltibia", b"name lfemur", 36, 11, ("'lfemur'",)),
        (b"length 7.1 ", b"length many ", 27, 13, ("length", "'many'")),
        (b"direction 0.56 -0.75 0.35", b"direction 0 0 0", 19, 6, ("direction",)),
        (b"axis 0 0.0 20.0  XYZ", b"axis 0 0 20", 28, 15, ("XYZ", "'axis'")),
        (b"axis 0 0.0 20.0  XYZ", b"axis 0 0 20 XXY", 28, 18, ("XYZ", "'XXY'")),
        (b"ltibia lfoot", b"ltibia lfood", 222, 12, (":bonedata", "'lfood'")),
        (b"    ltibia lfoot\r\n", b"", 217, 1, ("'lfoot'",)),
        (b"ltibia lfoot", b"ltibia lfoot rfoot", 226, 12, ("'rfoot'",)),
        (b"  end\r\n:hier", b"\r\n:hier", 215, 12, ("'end'", ":bonedata")),
        (b"# AST", b"AST", 1, 1, ("'AST/ASF'",)),
    ],
)
def test_bad_skeletons_are_one_sentence_with_a_place(old, new, line, column, facts):
    data = amc_files.asf(False)
    assert old in data
    with refused(AmcError, *facts, path="skeleton.asf", line=line, column=column):
        parse_asf(data.replace(old, new, 1))


def test_a_last_frame_that_was_cut_off_is_left_out_and_told():
    cut = FEW.data[: FEW.data.rindex(b"lclavicle")]
    clip = parse_amc(cut, FEW.asf)
    assert clip.frames == FEW.frames - 1
    assert len(clip.warnings) == len(FEW.warnings) + 1
    turned = clip.motion.rotations.copy()
    turned[-1, 0] = turned[40, 0]
    again = parse_amc(
        create_file_patch_for_motion(clip, clip.motion.with_rotations(turned)).data, FEW.asf
    )
    assert geodesic_angle(again.motion.rotations, turned).max() < 1e-7


def test_control_characters_in_comments_move_no_number():
    data = FEW.data.replace(b"\r\n2\r\n", b"\r\n# a\x01b c # 5\r\n2\r\n")
    clip = parse_amc(data, FEW.asf)
    turned = clip.motion.rotations.copy()
    turned[50, 0] = turned[90, 0]
    again = parse_amc(
        create_file_patch_for_motion(clip, clip.motion.with_rotations(turned)).data, FEW.asf
    )
    assert geodesic_angle(again.motion.rotations, turned).max() < 1e-7
