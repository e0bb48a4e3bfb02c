"""A wrong kind of file is named, with what to do, by its first bytes; a right one never is."""

import io
import json
import pickle
import zipfile

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.errors import TwistError
from twistcore.files.kinds import AMC, BVH, LOOKED_AT, NPZ, found_instead, kind_of
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.reading import read_clip
from twistcore.review import read_session


def zipped(name):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr(name, "x")
    return out.getvalue()


def arrays():
    out = io.BytesIO()
    np.savez(out, poses=np.zeros((2, 3)))
    return out.getvalue()


NAMED = [
    (b"Kaydara FBX Binary  \x00\x1a\x00", "FBX file (binary); `twistcore convert`"),
    (b"; FBX 7.3.0 project file\n", "FBX file (text); save it as binary FBX"),
    (b"glTF\x02\x00\x00\x00", "glTF file (binary); `twistcore convert`"),
    (b'{\n  "asset": {"version": "2.0"}}', "glTF file (text); `twistcore convert`"),
    (b"BLENDER-v402", "Blender file; `twistcore convert`"),
    (zipped("clips/walk.bvh"), "ZIP archive; unpack it first"),
    (arrays(), "an .npz; give it a name that ends in .npz"),
    (b"\x93NUMPY\x01\x00", "single array of numpy (.npy); save its arrays by name"),
    (b"\x1f\x8b\x08\x00", "gzip archive; unpack it first"),
    (b"\x89PNG\r\n\x1a\n", "PNG picture"),
    (b"\x02\x50\x14\x00", "C3D file of markers; markers have no joints: solve them"),
    (b"PathFileType\t4\t(X/Y/Z)", "TRC file of markers; markers have no joints: solve them"),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:", "LFS pointer, not the file"),
    (
        b"/annex/objects/SHA256E-s123--ab.bvh\n",
        "git-annex pointer, not the file itself; `git annex",
    ),
    (pickle.dumps({"poses": [1.0]}), "a pickle of Python"),
    (pickle.dumps({"poses": [1.0]}, protocol=2), "as .npz with numpy.savez"),
    (b"\x00\x00\x00\x18ftypmp42", "film (MP4)"),
    (b"\x00\x00\x00\x14ftypqt  ", "film (MOV)"),
    (b"\x00\x00\x00\x08wide", "film (MOV)"),
    (b"RIFF\x00\x00\x00\x00AVI LIST", "film (AVI)"),
    (b"%PDF-1.7", "PDF document"),
    (b"\n<!doctype html><html>", "web page (HTML); download the file itself"),
    ("\ufeff<html>".encode("utf-16-le"), "web page (HTML)"),
    ("\ufeff<html>".encode("utf-8"), "web page (HTML)"),
    (b'{"schema": "twistcore.session/3", "clip"', "a session; `twistcore apply SESSION CLIP"),
    (b'{\n "schema": "twistcore.truth/1"', "a JSON document (twistcore.truth)"),
    (b'[{"a": 1}]', "a JSON document"),
    (b"# AST/ASF file using VICON dataset", "ASF skeleton without motion; open its .amc"),
    (b"#!OML:ASF F:\\VICON\n:FULLY-SPECIFIED", "AMC file; give it a name that ends in .amc"),
]


@pytest.mark.parametrize(("data", "words"), NAMED, ids=[words for _, words in NAMED])
def test_what_is_no_bvh_is_named_in_one_sentence(tmp_path, data, words):
    path = tmp_path / "clip.bvh"
    path.write_bytes(data + bytes(600))
    with pytest.raises(TwistError) as told:
        read_clip(path)
    assert str(told.value).startswith(f"{path}: expected a BVH file, but this is ")
    assert words in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [("clip.npz", "expected an .npz, but"), ("clip.amc", "expected an AMC file, but")],
)
def test_a_bvh_of_another_name_is_told_its_own(tmp_path, name, said):
    path = tmp_path / name
    path.write_bytes((ASSETS / "walk.bvh").read_bytes())
    with pytest.raises(TwistError, match=r"this is a BVH file; give it a name that ends in \.bvh"):
        read_clip(path)
    path.write_bytes(b"%PDF-1.7")
    with pytest.raises(TwistError, match=f"{said} this is a PDF document"):
        read_clip(path)


def test_a_clip_in_the_place_of_a_session_is_named():
    with pytest.raises(TwistError, match="expected a session, but this is a BVH file"):
        read_session(ASSETS / "walk.bvh")
    with pytest.raises(TwistError, match=r"but this is a JSON document \(twistcore.truth\)"):
        read_session(ASSETS / "walk_injected.truth.json")


def test_a_session_whose_keys_are_in_another_order_is_still_read_as_one(tmp_path):
    path = tmp_path / "walk.twist.json"
    path.write_text(json.dumps({"clip": "walk.bvh", "schema": "twistcore.session/1"}))
    with pytest.raises(TwistError) as told:
        read_session(path)
    assert "but this is" not in str(told.value)


def test_every_clip_of_ours_is_known_for_what_it_is():
    for path in sorted(ASSETS.glob("*.bvh")):
        head = path.read_bytes()[:LOOKED_AT]
        assert kind_of(head) is BVH
        assert found_instead(head, BVH) is None
    assert found_instead(arrays(), NPZ) is None
    assert found_instead(b":FULLY-SPECIFIED\n:DEGREES\n1\n", AMC) is None


@pytest.mark.parametrize("data", [b"", b"P", b"{", b"hello", b"1 2 3", b"\x00" * 40, b"\xff\xfeH"])
def test_what_cannot_be_told_is_left_to_the_reader(data):
    assert kind_of(data) is None
    if data:
        with pytest.raises(TwistError, match="HIERARCHY"):
            parse_bvh(data)
