"""Pickles of a few bytes that would take for ever, or all memory, if each value were believed."""

import pickle
import struct
import tracemalloc

import numpy as np
import pytest

from tests.tiers import parametrize
from tests.twistcore.processor_time import spent
from tests.twistcore.test_hostile_archives import npy, packed
from twistcore.errors import TwistError
from twistcore.formats.npz import parse_npz, parse_pkl, pickled_arrays
from twistcore.formats.npz.pickled_arrays import LimitError, Unreadable, read_pickle
from twistcore.formats.smpl.pose_layouts import find_poses

START = b"\x80\x04"
DOUBLED = b")" + b"2\x86" * 60  # a tuple of a tuple twice, and so on: 2^60 of them
SECONDS = 10.0  # of processor time; some of these took hours


def text(words):
    return b"X" + struct.pack("<I", len(words)) + words


def name_of(module, name):
    return text(module) + text(name) + b"\x93"


def number(value):
    return b"\x8a\x09" + value.to_bytes(9, "little", signed=True)


def array(count, shape):
    """An array that numpy makes of a buffer, which is `count`."""
    kind = name_of(b"numpy", b"dtype") + text(b"b1") + b"\x85R"
    made = name_of(b"numpy.core.numeric", b"_frombuffer")
    return made + b"(" + count + kind + shape + b"\x85" + text(b"C") + b"tR"


def bytes_of(size):
    return b"\x96" + struct.pack("<Q", size) + bytes(size)


ENCODE, DTYPE = name_of(b"_codecs", b"encode"), name_of(b"numpy", b"dtype")
LONG = text(b"a" * 500_000)
PRIME = (1 << 61) - 1  # integers that differ by it have the same hash
ATTACKS = {
    "a tuple as a key": b"}" + DOUBLED + b"Ns",
    "tuples as keys of a dict at once": b"(" + DOUBLED + b"Nd",
    "a tuple in a set": b"\x8f(" + DOUBLED + b"\x90",
    "a tuple in a frozen set": b"(" + DOUBLED + b"\x91",
    "a tuple as a text": ENCODE + DOUBLED + b"\x85R",
    "a tuple as a dtype": DTYPE + DOUBLED + b"\x85R",
    "bytes by their number": array(number(576_000_000), number(576_000_000)),
    "more bytes by their number": array(number(8_600_000_000), number(8_600_000_000)),
    "thousands of classes": b"".join(b"ca\n%x\n" % k for k in range(20_000)),
    "a text encoded again and again": LONG + b"\x94" + ENCODE
    + b"\x94](" + b"h\x01h\x00\x85R" * 10_000 + b"e",
    "a state set again and again": name_of(b"numpy.core.multiarray", b"_reconstruct")
    + b")R\x94(K\x01" + number(500_000) + b"\x85" + DTYPE + text(b"b1") + b"\x85R\x89" + LONG
    + b"t\x94" + b"b" + b"h\x01b" * 10_000,
    "a call with a million arguments": b"(" + b"N" * 500_000 + b"t\x94" + ENCODE
    + b"\x94](" + b"h\x01h\x00R0" * 10_000 + b"e",
    "an object with a million arguments": b"(" + b"N" * 500_000 + b"t\x94"
    + name_of(b"a", b"b") + b"\x94](" + b"h\x01h\x00\x81" * 10_000 + b"e",
    "an array that is filled again and again": array(bytes_of(2_000_000), number(2_000_000))
    + b"NK\x01s" * 50_000,
    "an array of many axes": array(b"C\x00", b"(" + number(1 << 60) + b"2" * 300_000 + b"t"),
    "long keys that are equal": b"}" + (LONG + b"\x94") * 2 + b"00"
    + (b"h\x00Ns" + b"h\x01Ns") * 20_000,
    "memories whose numbers hash alike": b"N"
    + b"".join(b"p%d\n" % (k * PRIME) for k in range(1, 30_000)),
}  # fmt: skip


def held(work):
    """The error of some work, which may take little time and memory."""
    tracemalloc.start()
    try:
        found, seconds = spent(work)
        assert tracemalloc.get_traced_memory()[1] < 64 << 20
    finally:
        tracemalloc.stop()
    assert seconds < SECONDS
    return found


@parametrize("attack", ATTACKS, quick=3)
def test_a_pickle_takes_little_time_and_memory(attack, tmp_path):
    data = START + ATTACKS[attack] + b"."
    error = held(lambda: parse_pkl(data, tmp_path / "a.pkl"))
    assert isinstance(error, TwistError)
    assert str(error).startswith(str(tmp_path))
    assert "\n" not in str(error)


@pytest.mark.parametrize("opcode", [b"}", b"]", b"(", b"N", b"2", b"\x8f"])
def test_more_instructions_than_a_file_of_its_size_needs_are_refused(opcode, monkeypatch):
    monkeypatch.setattr(pickled_arrays, "_INSTRUCTIONS", 1_000)
    assert "objects" in refused(START + b"(}" + opcode * 2_000 + b"l.")
    assert len(read_pickle(START + b"(" + b"N" * 900 + b"l.")) == 900


def refused(data):
    with pytest.raises(LimitError) as error:
        read_pickle(data)
    return str(error.value)


@pytest.mark.thorough
def test_numbers_of_a_long_recording_are_no_attack():
    """A list of numbers has nine bytes for each instruction."""
    numbers = [0.5 * k for k in range(400_000)]
    assert read_pickle(pickle.dumps(numbers)) == numbers


@pytest.mark.parametrize(("deep", "reads"), [(90, True), (120, False), (100_000, False)])
def test_lists_are_read_to_some_depth(deep, reads):
    data = START + b"]" * deep + b"a" * (deep - 1) + b"."
    assert (repr(read_pickle(data)) == "[" * deep + "]" * deep) if reads else refused(data)


def test_values_may_be_used_twice_but_not_without_end():
    pose = np.zeros((100, 72))
    assert read_pickle(pickle.dumps([pose] * 4))[3].shape == (100, 72)
    assert "too often" in refused(pickle.dumps([pose] * 10_000))
    shared = [0]
    for _ in range(60):
        shared = [shared, shared]
    assert "too often" in refused(pickle.dumps(shared))
    shared.append(shared)
    assert "itself" in refused(pickle.dumps(shared))


def test_sets_and_keys_of_tuples_do_not_matter_next_to_poses():
    more = {(1, 2): 3, "tags": {1, 2}, "others": frozenset("ab"), b"b": None, None: 1, 2.5: 2}
    found = read_pickle(pickle.dumps({"poses": np.ones((2, 66)), **more}))
    assert found["poses"].sum() == 132.0
    assert (found[b"b"], found[None], found[2.5]) == (None, 1, 2)
    assert isinstance(found["tags"], Unreadable)
    assert len(found) == 1 + len(more)


def test_one_frame_of_a_video_is_not_repeated_without_end(tmp_path):
    crowd = {"smpl_thetas": np.zeros((5_000, 72), np.float16)}
    data = packed(results=npy(np.array(dict.fromkeys(range(5_000), crowd), dtype=object)))
    error = held(lambda: parse_npz(data, tmp_path / "a.npz"))
    assert "too often" in str(error)


def test_names_that_nobody_needs_are_not_repeated_for_each_person(tmp_path):
    names = {"poses": np.zeros((2_000, 1, 72)), "trans": np.zeros((2_000, 1, 3)), "fps": 25.0}
    error = held(lambda: find_poses(tmp_path, names | dict.fromkeys(range(20_000))))
    assert "--person" in str(error)
    assert find_poses(tmp_path, names | {"unneeded": 1}, person="7").rate == 25.0
