"""What a session file says, key by key, and what is said of one that is damaged."""

import hashlib
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.messages import names_in_one_line
from tests.twistcore.small_review import (
    ARM,
    BULK,
    CHAINS,
    CLIP,
    FLIPPED,
    FOREARM,
    LIMB,
    SEEN,
    TAU,
    TRACKING,
    flip,
    state,
    twist,
)
from twistcore.detection import Kind
from twistcore.detection.interval_json import (
    interval_from_json,
    interval_to_json,
    radians_to_json_degrees,
    tau_from_json,
    tau_to_json,
)
from twistcore.errors import FormatError, TwistError
from twistcore.quamo.tracking_settings import Tracking, tracking_from_json, tracking_to_json
from twistcore.review.model import Decision, Judged
from twistcore.review.session import (
    judged_from_json,
    judged_to_json,
    read_session,
    read_session_with_hash,
    session_bytes,
    session_document,
    session_from_document,
    tracks_place_or_both_ways,
    write_session,
)
from twistcore.skeleton.rig import AS_FOUND, OwnChain, Rig

RIG = Rig((OwnChain(("hip", "chest")),), ("LeftClavicle",))
BOTH_WAYS = replace(TRACKING, causal=False)
PLACE = replace(TRACKING, place=True)
SPLINE = replace(TRACKING, causal=False, spline=True, cutoff=5.5)
BURSTS = replace(SPLINE, bursts=tuple((name, 3, 9) for name in SPLINE.joints))
TWISTS = state(BULK, SEEN)


def document(of=TWISTS):
    """As a file has it."""
    return json.loads(session_bytes(CLIP, of))


def test_every_key_of_a_session():
    plain = {"by_hand": False, "edited": False, "supported": True}
    unsaid = {"reviewer": "", "decided_at": "", "note": "", "reason": ""}
    expected = {
        "schema": "twistcore.session/1",
        "clip": str(CLIP.path.absolute()),
        "sha256": hashlib.sha256(CLIP.data).hexdigest(),
        "fps": 100.0,
        "method": "paper",
        "tau_deg": {c.name: 5.0 for c in CHAINS},
        "next_id": 3,
        "intervals": [
            {
                "id": 1,
                "chain": ARM,
                "start": 0,
                "stop": 2,
                "offset_deg": 30.0,
                "confidence": 0.5,
                "open": False,
                "residual_deg": 0.0,
                "decision": "accepted",
                **plain,
                **unsaid,
                "by_hand": True,
                "in_bulk": True,
            },
            {
                "id": 2,
                "chain": FOREARM,
                "start": 0,
                "stop": 2,
                "offset_deg": [20.0, -10.5],
                "confidence": 0.75,
                "open": True,
                "residual_deg": -1.5,
                "decision": "rejected",
                "by_hand": False,
                "edited": True,
                "supported": False,
                "reviewer": "Ada",
                "decided_at": "2026-01-02T03:04:05+00:00",
                "note": "a real turn",
                "reason": "motion",
            },
        ],
    }
    assert document() == expected
    assert list(document()) == list(expected)
    assert session_document(CLIP, TWISTS) == expected
    more = replace(state(FLIPPED, tau=TAU), tracking=BOTH_WAYS, rig=RIG, left_out=((0, 1),))
    kinds = {"kind": "limb flip", "carried": True, "joint": "LeftHand"}
    (only,) = document(more)["intervals"]
    assert only == {
        **{"id": 3, "chain": LIMB, "start": 0, "stop": 1, "offset_deg": 170.0},
        **{"confidence": None, "open": False, "residual_deg": 0.0, "decision": "undecided"},
        **kinds, **plain, **unsaid,
    }  # fmt: skip
    found = document(more)
    assert found["rig"] == {"add": [{"joints": ["hip", "chest"]}], "remove": ["LeftClavicle"]}
    assert found["left_out"] == [[0, 1]]
    assert found["tracking"] == {
        "joints": ["LeftHand", "hip"], "gains": "hand", "kp": 500.0, "kd": 12.5, "ka": 0.25,
        "weights": "", "causal": False, "place": False,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("number", "of"),
    [
        (1, TWISTS),
        (1, replace(TWISTS, left_out=((0, 1),))),
        (2, replace(TWISTS, tracking=TRACKING)),
        (3, replace(TWISTS, rig=RIG)),
        (3, state(FLIPPED)),
        (3, state(BULK, FLIPPED)),
        (3, state(Judged(1, twist(kind=Kind.LONE_JUMP, joint="hip")))),
        (3, state(tau=TAU)),
        (3, replace(TWISTS, rig=RIG, tracking=TRACKING)),
        (4, replace(TWISTS, tracking=BOTH_WAYS)),
        (4, replace(TWISTS, tracking=PLACE)),
        (4, replace(TWISTS, rig=RIG, tracking=PLACE)),
        (4, replace(TWISTS, tracking=Tracking((), causal=False, place=True))),
        (6, replace(TWISTS, tracking=SPLINE)),
        (6, replace(TWISTS, rig=RIG, tracking=BURSTS)),
        (6, replace(state(BULK, FLIPPED), tracking=SPLINE)),
    ],
)
def test_the_oldest_schema_that_can_say_it_and_all_of_it_comes_back(number, of):
    found = document(of)
    assert found["schema"] == f"twistcore.session/{number}"
    for key, there in (("rig", of.rig), ("left_out", of.left_out), ("tracking", of.tracking)):
        assert (key in found) == bool(there)
    assert [("kind" in i, "carried" in i, "joint" in i) for i in found["intervals"]] == [
        (number > 2,) * 3 for _ in of.intervals
    ]
    back = session_from_document(found)
    assert (back.clip, back.sha256, back.fps) == (found["clip"], found["sha256"], found["fps"])
    again = back.state
    assert (again.method, again.next_id, dict(again.tau)) == ("paper", of.next_id, dict(of.tau))
    assert (again.tracking, again.rig, again.left_out) == (of.tracking, of.rig, of.left_out)
    assert list(again.chain_order) == list(of.tau)
    for now, then in zip(again.intervals, of.intervals, strict=True):
        assert vars(replace(now, interval=None)) == vars(replace(then, interval=None))
        one, other = (dict(vars(j.interval)) for j in (now, then))
        np.testing.assert_allclose(one.pop("offset"), other.pop("offset"), atol=1e-11)
        assert one.pop("residual") == pytest.approx(other.pop("residual"), abs=1e-11)
        assert one == other
    assert document(again) == found


def test_what_a_schema_does_not_know_is_passed_over():
    extra = {"rig": {"add": 3}, "tracking": {"joints": 3}, "of_later": 1}
    old = session_from_document(document() | extra).state
    assert (old.rig, old.tracking) == (AS_FOUND, None)
    for number in (3, 4):
        schema = {"schema": f"twistcore.session/{number}"}
        wanted = document(replace(TWISTS, rig=RIG)) | schema
        assert session_from_document(wanted).state.rig == RIG
        assert session_from_document(wanted).state.tracking is None
        assert session_from_document(wanted | {"tracking": None}).state.tracking is None
        del wanted["rig"]
        assert session_from_document(wanted).state.rig == AS_FOUND
    tracked = document(replace(TWISTS, tracking=TRACKING)) | {"rig": {"add": 3}}
    assert session_from_document(tracked).state.rig == AS_FOUND


def refusal(read, *arguments, **more):
    with pytest.raises(FormatError) as caught:
        read(*arguments, **more)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_document_of_another_schema_is_none():
    known = [f"'twistcore.session/{n}'" for n in (1, 2, 3, 4, 5, 6)]
    for other in (
        [],
        None,
        3,
        {},
        {"schema": 1},
        {"schema": "twistcore.session/7"},
        {"schema": []},
    ):
        assert names_in_one_line(refusal(session_from_document, other), *known)


@pytest.mark.parametrize(
    "key", ["clip", "sha256", "fps", "method", "tau_deg", "next_id", "intervals"]
)
def test_a_session_needs_each_of_its_keys(key):
    damaged = document()
    del damaged[key]
    assert names_in_one_line(refusal(session_from_document, damaged), f" {key}")


@pytest.mark.parametrize(
    ("damage", "facts"),
    [
        ({"clip": 3}, ("clip", "3")),
        ({"clip": "a\0b"}, ("clip",)),
        ({"sha256": None}, ("sha256",)),
        ({"fps": 0}, ("fps", "0")),
        ({"method": ["paper"]}, ("method",)),
        ({"tau_deg": []}, ("tau_deg",)),
        ({"tau_deg": {"a": 0.0}}, ("tau_deg", "0")),
        ({"tau_deg": {"a": "5"}}, ("tau_deg",)),
        ({"tau_deg": {5: 5.0}}, ("tau_deg",)),
        ({"next_id": 2.0}, ("next_id", "0")),
        ({"next_id": 2}, ("next_id",)),
        ({"next_id": 1}, ("next_id",)),
        ({"intervals": {}}, ("intervals",)),
        ({"intervals": [3]}, ("intervals", "1")),
        ({"left_out": [[1]]}, ("left_out", "1", "[start, stop]")),
        ({"schema": "twistcore.session/2"}, ("tracking",)),
        ({"schema": "twistcore.session/3"}, ("intervals", "1", "kind")),
        ({"schema": "twistcore.session/3", "intervals": [], "rig": 3}, ("rig", "3")),
        ({"schema": "twistcore.session/4", "intervals": [], "tracking": 3}, ("tracking",)),
    ],
)
def test_a_damaged_session_says_what_was_expected_where(damage, facts):
    assert names_in_one_line(refusal(session_from_document, document() | damage), *facts)


def test_ids_are_each_its_own_and_may_have_gaps():
    one, other = document()["intervals"]
    both = document() | {"next_id": 9}
    assert session_from_document(both).state.next_id == 9
    assert len(session_from_document(both | {"intervals": [one]}).state.intervals) == 1
    twice = both | {"intervals": [one, other | {"id": 1}]}
    assert "next_id" in refusal(session_from_document, twice)


# -- the file --------------------------------------------------------------------------------------


def test_a_file_is_written_whole_and_read_with_the_mark_of_its_bytes(tmp_path):
    path = tmp_path / "a.twist.json"
    write_session(CLIP, TWISTS, path)
    data = path.read_bytes()
    assert data == session_bytes(CLIP, TWISTS)
    assert json.loads(data) == document()
    session, mark = read_session_with_hash(path)
    assert mark == hashlib.sha256(data).hexdigest()
    assert session_bytes(CLIP, session.state) == data
    assert session_bytes(CLIP, read_session(path).state) == data


def test_what_is_no_session_file_is_told_by_its_kind(tmp_path):
    path = tmp_path / "a"
    with pytest.raises(TwistError) as caught:
        read_session(path)
    assert names_in_one_line(str(caught.value), f"{path}: ")
    for data, fact in (
        (b"\x89PNG\r\n", "PNG"),
        (b'{"schema": "twistcore.journal/1"}', "JSON"),
        (b'{"a": 1}', "schema"),
        (b"{", "JSON"),
        (b'{"schema": "twistcore.session/1"}', "clip"),
    ):
        path.write_bytes(data)
        assert names_in_one_line(refusal(read_session, path), f"{path}: ", fact)


# -- angles ----------------------------------------------------------------------------------------


def test_angles_are_degrees_with_nine_decimals_and_no_minus_nothing():
    assert radians_to_json_degrees(math.radians(12.3456789014)) == 12.345678901
    assert radians_to_json_degrees(math.radians(-12.3456789016)) == -12.345678902
    assert [math.copysign(1.0, radians_to_json_degrees(x)) for x in (-0.0, -1e-12)] == [1.0, 1.0]
    tau = {"a": math.radians(2.25), LIMB: 1.0}
    assert tau_to_json(tau) == {"a": 2.25, LIMB: 57.295779513}
    assert tau_from_json({"a": 180, "b": 1e-3}) == {"a": math.pi, "b": math.radians(1e-3)}
    assert tau_from_json({"a": 1e9, "b": 1e6}) == dict.fromkeys("ab", math.radians(1e6))
    assert names_in_one_line(refusal(tau_from_json, 3), "tau_deg", "3")


# -- intervals -------------------------------------------------------------------------------------


def test_a_kind_is_told_where_it_is_asked_for_or_none_of_the_first():
    assert "kind" not in interval_to_json(twist())
    told = {"kind": "counter-twist", "carried": False, "joint": ""}
    assert interval_to_json(twist(), kinds=True) == interval_to_json(twist()) | told
    assert interval_to_json(flip())["kind"] == "limb flip"
    assert judged_to_json(SEEN, kinds=True)["kind"] == "counter-twist"
    assert "kind" not in judged_to_json(SEEN)
    assert interval_from_json(interval_to_json(twist())).kind is Kind.COUNTER_TWIST


def test_an_offset_is_one_number_or_one_for_every_frame():
    entry = interval_to_json(twist(ARM, 3, 6, (1.0, 2.0, 3.0)))
    assert entry["offset_deg"] == pytest.approx([1.0, 2.0, 3.0])
    back = interval_from_json(entry)
    assert (back.start, back.stop, back.offset.shape) == (3, 6, (3,))
    np.testing.assert_allclose(np.degrees(back.offset), [1.0, 2.0, 3.0])
    for listed in (7.0, [7.0], [7, 7, 7]):
        same = interval_from_json(entry | {"offset_deg": listed})
        np.testing.assert_allclose(np.degrees(same.offset), [7.0] * 3)
    for damage in ([], [1.0, 2.0], [1.0] * 4):
        said = refusal(interval_from_json, entry | {"offset_deg": damage})
        assert names_in_one_line(said, "offset_deg", "3", len(damage))
    long = interval_from_json(entry | {"start": 0, "stop": 20_000_000, "offset_deg": 1.0})
    assert (long.offset.strides, long.frames) == ((0,), 20_000_000)


@pytest.mark.parametrize("key", ["offset_deg", "residual_deg"])
def test_angles_in_a_file_have_bounds(key):
    entry = interval_to_json(twist())
    for at_most in (1e6, -1e6):
        found = interval_from_json(entry | {key: at_most})
        value = found.residual if key == "residual_deg" else found.offset[0]
        assert value == math.radians(at_most)
    for damage in (1e6 + 1, -1e6 - 1, "3", True, None):
        said = refusal(interval_from_json, entry | {key: damage})
        assert names_in_one_line(said, key, "-1000000.0", " 1000000.0")


@pytest.mark.parametrize(
    "damage",
    [
        {"chain": 3}, {"start": -1}, {"stop": 0}, {"confidence": "high"}, {"confidence": True},
        {"open": 1}, {"kind": " "}, {"carried": 0}, {"joint": None},
        *({k: ...} for k in interval_to_json(twist())),
    ],
)  # fmt: skip
def test_a_damaged_interval_says_what_was_expected_where(damage):
    entry = interval_to_json(twist()) | damage
    whole = {key: value for key, value in entry.items() if value is not ...}
    [key] = damage
    assert names_in_one_line(refusal(interval_from_json, whole), f" {key}")


def test_a_judged_interval_of_the_first_files_has_no_reason_and_was_looked_at():
    entry = judged_to_json(replace(SEEN, reason=""))
    del entry["reason"]
    assert judged_from_json(entry).reason == ""
    assert judged_from_json(entry).in_bulk is False
    assert judged_from_json(entry | {"reason": "noise"}).reason == "noise"
    assert judged_from_json(entry | {"in_bulk": True}).in_bulk is True
    assert judged_from_json(entry).decision is Decision.REJECTED


@pytest.mark.parametrize(
    "damage",
    [
        *({k: 3} for k in ("by_hand", "edited", "supported", "in_bulk")),
        *({k: 3} for k in ("reviewer", "decided_at", "note", "reason")),
        *({k: ...} for k in ("id", "decision", "by_hand", "edited", "supported", "reviewer")),
        *({k: ...} for k in ("note", "stop", "decided_at")),
        {"id": -1}, {"id": "1"}, {"decision": "maybe"},
    ],
)  # fmt: skip
def test_a_damaged_verdict_says_what_was_expected_where(damage):
    whole = {k: v for k, v in (judged_to_json(SEEN) | damage).items() if v is not ...}
    [key] = damage
    assert names_in_one_line(refusal(judged_from_json, whole), f" {key}")


def test_where_kinds_must_be_told_an_interval_without_is_damaged():
    entry = judged_to_json(SEEN, kinds=True)
    assert judged_from_json(entry, kinds=True).id == 2
    for key in ("kind", "carried"):
        without = {k: v for k, v in entry.items() if k != key}
        assert f" {key}" in refusal(judged_from_json, without, kinds=True)
        assert judged_from_json(without).id == 2
    for kinds in (False, True):
        assert "interval" in refusal(judged_from_json, 3, kinds=kinds)


# -- tracking --------------------------------------------------------------------------------------


LEARNED = Tracking(("hip",), learned=True, weights="0123456789abcdef", place=True)


@pytest.mark.parametrize("tracking", [TRACKING, BOTH_WAYS, PLACE, LEARNED])
def test_tracking_comes_back(tracking):
    entry = tracking_to_json(tracking)
    assert entry["gains"] == ("learned" if tracking.learned else "hand")
    assert tracking_from_json(json.loads(json.dumps(entry))) == tracking
    assert tracks_place_or_both_ways(tracking) == (tracking is not TRACKING)
    assert not tracks_place_or_both_ways(None)
    del entry["causal"], entry["place"]
    assert tracking_from_json(entry) == replace(tracking, causal=True, place=False)


@pytest.mark.parametrize(
    "damage",
    [
        *({k: ...} for k in ("joints", "gains", "kp", "kd", "ka", "weights")),
        *({k: "3"} for k in ("kp", "kd", "ka")),
        {"joints": "hip"}, {"joints": [3]}, {"joints": []}, {"gains": "magic"}, {"weights": 3},
        {"causal": 1}, {"place": 0},
    ],
)  # fmt: skip
def test_damaged_tracking_says_what_was_expected_where(damage):
    entry = tracking_to_json(TRACKING) | damage
    whole = {k: v for k, v in entry.items() if v is not ...}
    [key] = damage
    assert names_in_one_line(refusal(tracking_from_json, whole), key)
    assert names_in_one_line(refusal(tracking_from_json, 3), "tracking", "3")
    place = tracking_to_json(PLACE) | {"joints": []}
    assert tracking_from_json(place).joints == ()
