"""Chains that a person wants: made, refused, kept in sessions, journals and files, replayed."""

import json

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.twistcore.test_all_joints import stepping
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import refine
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.errors import FormatError, TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import (
    ChangeChains,
    Decide,
    Decision,
    Insert,
    Journal,
    Redetect,
    Review,
    read_session,
    replay_journal,
    session_bytes,
    write_session,
)
from twistcore.review.other_chains import chain_change_command
from twistcore.review.replay import accepted_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import Limb, find_limbs
from twistcore.skeleton.rig import (
    AS_FOUND,
    OwnChain,
    Rig,
    read_rig,
    rig_from_json,
    rig_to_json,
    skeleton_hash,
    write_rig,
)
from twistcore.synthesis import InjectedError, inject

SPINE = OwnChain(("Spine", "Spine1", "Neck1"))
FINGER = OwnChain(("LeftFingerBase", "LeftHandIndex1"))
ARM = OwnChain(("Spine1", "LeftArm", "LeftHand"), limb=True)
OWN = Rig((SPINE, FINGER, ARM), ("LeftShoulder", "RightLeg"))


def names(chains):
    return [c.name for c in chains]


def changed(clip, review, rig):
    """The review taken to other chains, and its analysis then."""
    before = analyse(clip, rig=review.state.rig)
    after = before.with_rig(rig)
    review.do(chain_change_command(before, after, review.state))
    return after


def test_a_decision_on_the_whole_body_stays_when_the_first_chain_goes():
    clip = stepping(150)
    found = analyse(clip).detect()
    review = Review(found)
    (step,) = (j for j in review.state.intervals if j.interval.kind == Kind.BODY_STEP)
    review.do(Decide((step.id,), Decision.REJECTED, "Ada"))
    first, second, *_ = (c.name for c in found.chains)
    assert step.interval.chain == first
    changed(clip, review, Rig(remove=(first,)))
    (there,) = (j for j in review.state.intervals if j.interval.kind == Kind.BODY_STEP)
    assert (there.interval.chain, there.decision) == (second, Decision.REJECTED)
    assert (there.reviewer, there.supported) == ("Ada", True)
    changed(clip, review, AS_FOUND)
    (back,) = (j for j in review.state.intervals if j.interval.kind == Kind.BODY_STEP)
    assert (back.interval.chain, back.decision) == (first, Decision.REJECTED)


# -- chains ----------------------------------------------------------------------------------------


def test_nothing_added_and_removed_is_what_is_found(sample):
    chains = find_chains(sample.motion)
    found = names((*chains, *find_limbs(sample.motion, chains)))
    assert names(AS_FOUND.chains(sample.motion)) == found
    assert not AS_FOUND
    assert OWN


def test_chains_and_limbs_are_added_and_removed(walk):
    found, chains = names(AS_FOUND.chains(walk.motion)), OWN.chains(walk.motion)
    left = [name for name in found if name not in OWN.remove]
    own = [c for c in chains if c.name not in left]
    assert names(own) == ["Spine", "LeftFingerBase", "Spine1-LeftHand"]
    assert [isinstance(c, Limb) for c in chains] == sorted(isinstance(c, Limb) for c in chains)
    assert isinstance(own[-1], Limb)
    assert own[1].grandchild < 0
    assert OWN.summary() == "3 added, 2 removed"


def test_a_joint_below_the_child_may_have_joints_between(walk):
    """Its direction is then that of the frame: the neck bends between them."""
    chain = SPINE.made(walk.motion)
    skeleton = walk.motion.skeleton
    assert skeleton.names[chain.grandchild] == "Neck1"
    assert chain.arm.shape == (walk.motion.frames, 3)
    np.testing.assert_allclose(np.linalg.norm(chain.arm, axis=1), 1.0)


@pytest.mark.parametrize(
    ("joints", "limb", "facts"),
    [
        (("Spine", "Tail"), False, ("'Tail'",)),
        (("Spine",), False, ("1",)),
        (("Spine", "Spine1"), True, ("2",)),
        (("Neck", "Spine"), False, ("Spine", "Neck")),
        (("Spine", "Head"), False, ("Head", "Spine", "Spine1")),
        (("Spine1", "Neck"), False, ("Neck", "Spine1")),
        (("LeftArm", "LeftForeArm"), False, ("'LeftArm'",)),
        (("LeftArm", "LeftForeArm", "LeftHand"), True, ("'LeftArm-LeftHand'",)),
    ],
)
def test_what_is_no_chain_is_refused_in_a_sentence(walk, joints, limb, facts):
    with refused(TwistError, *facts):
        AS_FOUND.with_chain(walk.motion, OwnChain(joints, limb))


def test_a_rig_of_another_skeleton_is_refused(walk):
    with pytest.raises(TwistError, match="'Tail'"):
        Rig(remove=("Tail",)).chains(walk.motion)


def test_what_was_removed_comes_back_as_it_was(walk):
    rig = AS_FOUND.without("LeftShoulder")
    again = rig.with_chain(walk.motion, OwnChain(("LeftShoulder", "LeftArm", "LeftForeArm")))
    assert again == AS_FOUND
    assert AS_FOUND.with_chain(walk.motion, SPINE).without("Spine") == AS_FOUND
    other = rig.with_chain(walk.motion, OwnChain(("LeftShoulder", "LeftArm")))
    assert other.without("LeftShoulder") == rig


# -- on them everything works ----------------------------------------------------------------------


@pytest.mark.parametrize("joints", [SPINE.joints, ("Neck", "Neck1", "Head"), ("Neck1", "Head")])
def test_an_error_in_an_own_chain_is_found_and_taken_out(walk, joints):
    own = OwnChain(joints)
    motion, rig = walk.motion, Rig((own,))
    chain = own.made(motion)
    offset = np.full(40, np.radians(70.0))
    dirty = inject(motion, [chain], [InjectedError(own.name, 120, 160, offset)])
    found = analyse(dirty, rig=rig).detect()
    (only,) = [i for i in found if i.chain == own.name]
    assert (only.start, only.stop) == (120, 160)
    assert abs(only.delta - np.radians(70.0)) < np.radians(0.5)
    assert own.name not in analyse(dirty).detect().tau
    chains = found.chains_and_limbs
    turned = np.linalg.norm(refine(dirty, chains, found).rotations - motion.rotations, axis=2)
    assert turned.max() < np.radians(0.5)


def test_the_paper_detector_signals_and_limb_flips_know_them(walk):
    analysis = analyse(walk, rig=OWN)
    assert {"Spine", "LeftFingerBase"} <= analysis.signals.keys()
    assert "Spine" in analysis.detect("paper", kinds=[Kind.COUNTER_TWIST]).tau
    assert "Spine1-LeftHand" in analysis.detect(kinds=[Kind.LIMB_FLIP]).tau


# -- reviews ---------------------------------------------------------------------------------------


@pytest.fixture
def review(dirty_walk):
    """With a verdict on everything in the left forearm."""
    review = Review.of(analyse(dirty_walk).detect())
    ids = tuple(j.id for j in review.state.of_chain("LeftForeArm"))
    review.do(Decide(ids, Decision.ACCEPTED, "me", "2026-01-01T00:00:00+00:00"))
    return review


def test_a_chain_goes_with_its_intervals_and_undo_brings_both_back(dirty_walk, review):
    before = review.state
    changed(dirty_walk, review, AS_FOUND.without("LeftForeArm"))
    assert "LeftForeArm" not in review.state.tau
    assert not review.state.of_chain("LeftForeArm")
    others = [j for j in before.intervals if j.interval.chain != "LeftForeArm"]
    assert [j for j in review.state.intervals if j.id < before.next_id] == others
    new = [j.interval for j in review.state.intervals if j.id >= before.next_id]
    jumps = {(i.kind, i.joint) for i in new if i.kind == Kind.LONE_JUMP}
    assert jumps == {(Kind.LONE_JUMP, "LeftForeArm")}
    assert all(i.open for i in new)  # what LeftArm shows of it is no error of its own for sure
    review.undo()
    assert review.state is before
    review.redo()
    assert review.state.rig.remove == ("LeftForeArm",)


def test_a_chain_of_the_same_name_but_other_joints_begins_anew(dirty_walk, review):
    other = Rig((OwnChain(("LeftForeArm", "LeftHand")),), ("LeftForeArm",))
    changed(dirty_walk, review, other)
    assert all(j.decision == Decision.UNDECIDED for j in review.state.of_chain("LeftForeArm"))


def test_tau_that_a_person_set_stays_and_neighbours_are_looked_at_again(dirty_walk, review):
    review.do(Redetect({"RightUpLeg": 0.5}, ()))
    at = review.state.tau["RightUpLeg"]
    command_before = review.state
    after = changed(dirty_walk, review, AS_FOUND.with_chain(dirty_walk.motion, SPINE))
    assert review.state.tau["RightUpLeg"] == at
    assert review.state.tau.keys() == {c.name for c in after.chains_and_limbs}
    kept = [j for j in review.state.intervals if j.interval.chain == "LeftForeArm"]
    assert kept == list(command_before.of_chain("LeftForeArm"))


def test_another_rig_takes_along_what_it_does_not_change(walk):
    before = analyse(walk)
    signals, poses = before.signals, before.poses
    after = before.with_rig(Rig((SPINE,), ("LeftArm",)))
    assert after.poses is poses
    assert after.signals["LeftForeArm"] is signals["LeftForeArm"]
    assert list(after.signals) == names(after.chains)
    expected = analyse(walk, rig=after.rig).signals["Spine"]
    np.testing.assert_array_equal(after.signals["Spine"].theta_p, expected.theta_p)
    assert after.with_rig(after.rig) is after


def test_a_command_that_contradicts_itself_changes_nothing(review):
    with pytest.raises(ValueError, match="'Tail'"):
        ChangeChains(AS_FOUND, {"LeftArm": 0.1}, ("Tail",), ()).apply(review.state)


def test_a_session_has_its_chains_and_replays_without_the_program(
    tmp_path, dirty_walk, review, capsys
):
    after = changed(dirty_walk, review, OWN)
    review.do(Insert(new_constant_offset_interval("Spine", 50, 70, 0.4)))
    review.do(Decide((review.state.next_id - 1,), Decision.ACCEPTED))
    session, out = tmp_path / "walk.twist.json", tmp_path / "out.bvh"
    write_session(dirty_walk, review.state, session)
    document = json.loads(session.read_bytes())
    assert document["schema"] == "twistcore.session/3"
    assert rig_from_json(document["rig"]) == OWN == read_session(session).state.rig
    clip = str(dirty_walk.path)
    assert main(["apply", str(session), clip, "-o", str(out)]) == 0
    expected = tmp_path / "expected.bvh"
    motion = accepted_motion(dirty_walk, after.chains_and_limbs, review.state)
    write_clip(dirty_walk, motion, expected)
    assert out.read_bytes() == expected.read_bytes() != dirty_walk.path.read_bytes()
    capsys.readouterr()
    for damage in ({"add": [{"joints": ["Spine", "Tail"]}]}, {"remove": ["Tail"]}):
        session.write_text(json.dumps(document | {"rig": damage}), "utf-8")
        assert main(["apply", str(session), clip, "-o", str(out)]) == 2
        assert names_in_one_line(capsys.readouterr().err, f"{clip}: ", "'Tail'")
    for damage in (3, {"add": 3}, {"add": [{}]}, {"add": [{"joints": ["A"]}]}, {"remove": [1]}):
        session.write_text(json.dumps(document | {"rig": damage}), "utf-8")
        with pytest.raises(FormatError, match=r"walk\.twist\.json"):
            read_session(session)


def test_a_review_of_chains_as_found_is_written_as_ever(dirty_walk, review):
    document = json.loads(session_bytes(dirty_walk, review.state))
    assert "rig" not in document


def test_a_journal_has_the_change_and_its_undo(tmp_path, dirty_walk, review):
    path = tmp_path / "walk.journal"
    journal = Journal(path, dirty_walk, review.state)
    before = analyse(dirty_walk)
    after = before.with_rig(OWN)
    command = chain_change_command(before, after, review.state, "Other chains")
    began = session_bytes(dirty_walk, review.state)
    review.do(command)
    journal.do(command)
    again = replay_journal(path, dirty_walk)
    assert (again.damaged, again.review.undo_text) == (0, "Other chains")
    assert session_bytes(dirty_walk, again.review.state) == session_bytes(dirty_walk, review.state)
    journal.append({"undo": True})
    undone = replay_journal(path, dirty_walk).review
    assert session_bytes(dirty_walk, undone.state) == began
    journal.append({"redo": True})
    journal.append({"session": json.loads(began)})  # an undo of what the journal does not know
    journal.close()
    recovered = replay_journal(path, dirty_walk)
    assert recovered.damaged == 0
    assert session_bytes(dirty_walk, recovered.review.state) == began


def test_a_journal_with_chains_that_the_clip_has_not_counts_until_there(
    tmp_path, dirty_walk, review
):
    path = tmp_path / "walk.journal"
    journal = Journal(path, dirty_walk, review.state)
    for rig, tau in ((Rig(remove=("Tail",)), {}), (OWN, {"LeftArm": 0.1})):
        journal.do(ChangeChains(rig, tau, (), ()))
        assert replay_journal(path, dirty_walk).damaged > 0
        assert replay_journal(path, dirty_walk).entries == 0
    journal.close()


# -- files and the command line --------------------------------------------------------------------


def test_a_file_holds_a_rig(tmp_path, walk):
    path = tmp_path / "rig.toml"
    odd = Rig((OwnChain(('a"b', "ü\udce9")),), ("x\\y",))
    for rig in (OWN, AS_FOUND, odd):
        write_rig(path, rig, walk.motion.skeleton, "walk.bvh")
        assert read_rig(path) == rig
        assert rig_from_json(json.loads(json.dumps(rig_to_json(rig)))) == rig


def test_a_file_holds_any_name(tmp_path_factory, walk):
    """A joint may have every letter in its name that a clip can hold, and so may its file."""
    path = tmp_path_factory.mktemp("rigs") / "rig.toml"

    @given(st.text(st.characters(exclude_categories=["Cs"])), st.text())
    @example("\x7f", "walk\n[[chain]].bvh")
    def check(name, source):
        rig = Rig((OwnChain((name, "B")),), (name,))
        write_rig(path, rig, walk.motion.skeleton, source)
        assert read_rig(path) == rig

    check()


def test_the_mark_of_a_skeleton_is_that_of_its_joints(walk, dirty_walk):
    dance = read_bvh(ASSETS / "dance.bvh")
    mark = skeleton_hash(walk.motion.skeleton)
    assert mark == skeleton_hash(dirty_walk.motion.skeleton)
    assert len(mark) == 64
    same = walk.motion.skeleton.names == dance.motion.skeleton.names
    assert (mark == skeleton_hash(dance.motion.skeleton)) == same


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[[chain", "TOML"),
        ('[[chain]]\njoints = "Spine"\n', "joints"),
        ('[[chain]]\njoints = ["Spine"]\n', "1 joint"),
        ('[[chain]]\njoints = ["A", "B"]\nkind = "limb"\n', "2 joints"),
        ('[[chain]]\njoints = ["A", "B"]\nkind = "tail"\n', "joints"),
        ("remove = 3\n", "remove"),
        ("[LeftArm]\ntau_deg = 2.0\n", "'LeftArm'"),
        ('[[chain]]\njoints = ["Spine", "Tail"]\n', "'Tail'"),
        ('remove = ["Tail"]\n', "'Tail'"),
    ],
)
def test_a_bad_file_is_refused_in_a_sentence(tmp_path, capsys, text, told):
    path = tmp_path / "rig.toml"
    path.write_text(text, "utf-8")
    assert main(["detect", str(ASSETS / "walk.bvh"), "--rig", str(path)]) == 2
    said = capsys.readouterr().err
    assert names_in_one_line(said, str(path), told)


@pytest.mark.thorough
def test_commands_take_a_rig(tmp_path, walk, capsys):
    path, clip = tmp_path / "rig.toml", str(ASSETS / "walk_injected.bvh")
    write_rig(path, OWN, walk.motion.skeleton, "walk.bvh")
    rig = ["--rig", str(path)]
    assert main(["info", clip, "--json", *rig]) == 0
    info = json.loads(capsys.readouterr().out)
    assert "Spine" in [c["chain"] for c in info["chains"]]
    assert "Spine1-LeftHand" in [c["limb"] for c in info["limbs"]]
    assert main(["detect", clip, "--json", "--chain", "Spine", *rig]) == 0
    assert list(json.loads(capsys.readouterr().out)["tau_deg"]) == ["Spine"]
    csv, out = tmp_path / "s.csv", tmp_path / "o.bvh"
    assert main(["signals", clip, "--csv", str(csv), *rig]) == 0
    text = csv.read_text("utf-8")
    assert "\nLeftFingerBase,0," in text
    assert "\nRightLeg," not in text
    assert main(["refine", clip, "-o", str(out), "--report", str(tmp_path / "r"), *rig]) == 0
    report = json.loads((tmp_path / "r" / "walk_injected.report.json").read_bytes())
    assert "Spine" in [c["chain"] for c in report["chains"]]
    assert main(["refine", clip, "-o", str(path), *rig]) == 2
    profile = tmp_path / "tau.toml"
    words = ["tune", clip, "-o", str(profile), "--seeds", "1", "--workers", "1", *rig]
    assert main(words) == 0
    assert "[Spine]" in profile.read_text("utf-8").replace('"', "")
