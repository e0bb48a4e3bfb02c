"""The wording of sentences that people meet most: each as in tests/golden_sentences.py.

`python -m tests.twistcore.test_golden_sentences` writes that file as the program words them now.
"""

import shutil
import sys
import tempfile
from contextlib import redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

import twistcore as tc
from tests import golden_sentences
from tests.conftest import ASSETS
from tests.golden_sentences import SENTENCES
from tests.twistcore import amc_files
from tests.twistcore.test_bvh import small
from twistcore.analysis.why_not import why_frame_bounds_no_interval
from twistcore.batch.gates import parse_batch_rule
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.formats.amc import parse_amc, parse_asf
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Annotate, Decide, Decision, LeaveOut, Redetect, Remove
from twistcore.skeleton.rig import AS_FOUND, OwnChain

WALK, DIRTY = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh"
BVH = small(np.arange(27).reshape(3, 9))
ASF, AMC = amc_files.asf(False), amc_files.amc(False)


def _refusal(work, *arguments, **more):
    """What the error says; nothing where there is none."""
    try:
        work(*arguments, **more)
    except (tc.TwistError, TypeError, ValueError, OSError) as error:
        return str(error)
    return ""


def _bvh_errors():
    damage = {
        "no hierarchy": (b"HIERARCHY", b"hierarchy!"),
        "no motion": (b"MOTION", b""),
        "no frame time": (b"Frame Time", b"Time"),
        "count of frames": (b"Frames: 3", b"Frames: x"),
        "no number": (b"4.000000", b"nan"),
        "decimal comma": (b"4.000000", b"4,0"),
        "short row": (b"13.000000 ", b""),
        "offset": (b"OFFSET 0 1 0", b"OFFSET 0 one 0"),
        "channel": (b"CHANNELS 3", b"CHANNELS 4"),
    }
    yield "empty", _refusal(parse_bvh, b"")
    for name, (old, new) in damage.items():
        yield name, _refusal(parse_bvh, BVH.replace(old, new, 1), "clip.bvh")


def _bvh_warnings():
    damage = {
        "fewer rows": (b"Frames: 3", b"Frames: 300"),
        "rate for its reciprocal": (b"Time: 0.01", b"Time: 120"),
        "no frame time": (b"Time: 0.01", b"Time: 0"),
        "no offset": (b"OFFSET 0 1 0", b""),
    }
    for name, (old, new) in damage.items():
        yield name, str(parse_bvh(BVH.replace(old, new, 1)).warnings[0])
    yield "cut row", str(parse_bvh(BVH.rstrip()[:-20]).warnings[-1])
    yield "UTF-16", str(parse_bvh(BVH.decode().encode("utf-16")).warnings[0])


def _amc():
    asf = parse_asf(ASF)
    for name, old, new in (
        ("no section", b":root", b":roots"),
        ("unit", b"angle deg", b"angle gon"),
        ("name twice", b"name ltibia", b"name lfemur"),
        ("no bone", b"ltibia lfoot", b"ltibia lfood"),
    ):
        yield name, _refusal(parse_asf, ASF.replace(old, new, 1))
    for name, old, new in (
        ("no number", b"lradius ", b"lradius x"),
        ("unknown bone", b"lradius", b"lradios"),
        ("missing bone", b"lhumerus", b"# lhumerus"),
    ):
        yield name, _refusal(parse_amc, AMC.replace(old, new, 1), asf)
    yield "rate", str(parse_amc(AMC, asf).warnings[0])


def _files(folder):
    yield "missing", _refusal(tc.read_clip, folder / "none.bvh")
    yield "folder", _refusal(tc.read_clip, folder)
    for name, head in (
        ("picture", b"\x89PNG\r\n\x1a\n"),
        ("FBX", b"Kaydara FBX Binary  \x00\x1a\x00"),
        ("ZIP", b"PK\x03\x04"),
        ("session", b'{"schema": "twistcore.session/3", "clip"'),
        ("AMC", b"#!OML:ASF F:\\VICON\n:FULLY-SPECIFIED"),
    ):
        (folder / "clip.bvh").write_bytes(head + bytes(600))
        yield name, _refusal(tc.read_clip, folder / "clip.bvh")
    poses, path = np.zeros((5, 72)), folder / "poses.npz"
    for name, arrays in (
        ("no place", {"poses": poses}),
        ("width", {"poses": poses[:, :70], "trans": poses[:, :3]}),
        ("no finite number", {"poses": poses + np.nan, "trans": poses[:, :3]}),
    ):
        np.savez(path, **arrays)
        yield name, _refusal(tc.read_clip, path)
    yield "no session", _refusal(tc.read_session, folder / "none.twist.json")
    yield "clip for a session", _refusal(tc.read_session, WALK)
    shutil.copy(WALK, folder / "walk.bvh")
    clip = tc.read_clip(folder / "walk.bvh")
    yield "own source", _refusal(write_clip, clip, clip.motion, clip.path)


def _names():
    clip = tc.read_clip(WALK)
    yield "chain", _refusal(tc.detect, clip, "Tail")
    yield "chain near", _refusal(tc.detect, clip, "LeftAm")
    yield "chain of several", _refusal(tc.detect, clip, "left leg")
    yield "person", _refusal(tc.analyse, clip, people="Kim")
    yield "detector", _refusal(tc.detect, clip, method="median")
    yield "no clip", _refusal(tc.detect, "walk.bvh")
    yield "two units", _refusal(tc.detect, clip, tau_degrees=5.0, tau_radians=0.1)
    for joints in (("Spine", "Tail"), ("Spine",), ("Neck", "Spine"), ("LeftArm", "LeftForeArm")):
        own = OwnChain(joints)
        yield f"own chain {' '.join(joints)}", _refusal(AS_FOUND.with_chain, clip.motion, own)
    for rule in ("severity", "jitter>1", "severity>many", "affected>2"):
        yield f"rule {rule}", _refusal(parse_batch_rule, rule)


def _review():
    found = tc.detect(tc.read_clip(DIRTY))
    yield "detection", repr(found)
    yield "no edge", why_frame_bounds_no_interval(found, "LeftForeArm", 50).text
    yield "in an interval", why_frame_bounds_no_interval(found, "LeftForeArm", found[0].start).text
    review = tc.Review(found)
    for command in (
        Decide((1,), Decision.ACCEPTED),
        Annotate(1, "a"),
        Redetect({"LeftArm": 0.3}, ()),
        LeaveOut(((0, 9),)),
        LeaveOut(()),
    ):
        review.do(command)
        yield f"{len(review.history)}", review.undo_text
    yield "hand-made", _refusal(review.do, Remove(3))
    yield "here", Kind.LONE_JUMP.info.here.format(frames="1–2", size="", joint="Hips")


def _commands(folder):
    for words in (
        f"detect {DIRTY}",
        f"refine {DIRTY} -o OUT/out.bvh",
        "detect OUT",
        "signals w.bvh",
        "detect w.bvh --tau 200",
        "detect w.bvh --fps 0",
        "refine w.bvh -o OUT/o.bvh --min-confidence 2",
        "refine w.bvh -o OUT/o.fbx",
        "convert OUT/a.obj -o OUT/o.bvh",
    ):
        told = StringIO()
        with redirect_stdout(told), redirect_stderr(told), suppress(SystemExit):
            main(words.replace("OUT", str(folder)).split())
        yield words.replace(str(ASSETS), "ASSETS"), told.getvalue().splitlines()[-1]


def said(folder):
    """Every sentence by its name."""
    makers = {
        "bvh": _bvh_errors(),
        "bvh warning": _bvh_warnings(),
        "amc": _amc(),
        "file": _files(folder),
        "name": _names(),
        "review": _review(),
        "command": _commands(folder),
    }
    places = {str(folder): "FOLDER", str(ASSETS): "ASSETS"}
    sentences = {}
    for about, maker in makers.items():
        for name, sentence in maker:
            for place, word in places.items():
                sentence = sentence.replace(place, word)
            sentences[f"{about}: {name}"] = sentence
    return sentences


@pytest.fixture(scope="module")
def now(tmp_path_factory):
    return said(tmp_path_factory.mktemp("golden"))


@pytest.mark.parametrize("name", SENTENCES)
def test_a_sentence_is_worded_as_agreed(now, name):
    assert now[name] == SENTENCES[name]


def test_every_sentence_is_agreed_on(now):
    assert list(now) == list(SENTENCES)
    assert [name for name, sentence in now.items() if not sentence or "\n" in sentence] == []


if __name__ == "__main__":
    head = Path(golden_sentences.__file__).read_text("utf-8").partition("SENTENCES")[0]
    with tempfile.TemporaryDirectory() as temporary:
        lines = [f"    {k!r}: {v!r},\n" for k, v in said(Path(temporary)).items()]
    Path(golden_sentences.__file__).write_text(
        f"{head}SENTENCES = {{\n{''.join(lines)}}}\n", "utf-8"
    )
    sys.stdout.write(f"{len(lines)} sentences\n")
