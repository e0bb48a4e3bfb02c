"""A wrong kind of file is named, with what to do, by its first bytes; a right one never is."""

import io
import json
import pickle
import zipfile

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import refused
from twistcore.errors import TwistError
from twistcore.files.kinds import (
    AMC,
    BVH,
    LOOKED_AT,
    NPZ,
    detect_file_kind,
    wrong_file_kind_message,
)
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
    (b"Kaydara FBX Binary  \x00\x1a\x00", ("FBX", "`twistcore convert`")),
    (b"; FBX 7.3.0 project file\n", ("FBX", "binary")),
    (b"glTF\x02\x00\x00\x00", ("glTF", "`twistcore convert`")),
    (b'{\n  "asset": {"version": "2.0"}}', ("glTF", "`twistcore convert`")),
    (b"BLENDER-v402", ("Blender", "`twistcore convert`")),
    (zipped("clips/walk.bvh"), ("ZIP", "unpack")),
    (arrays(), (".npz",)),
    (b"\x93NUMPY\x01\x00", (".npy",)),
    (b"\x1f\x8b\x08\x00", ("gzip", "unpack")),
    (b"\x89PNG\r\n\x1a\n", ("PNG",)),
    (b"\x02\x50\x14\x00", ("C3D", "markers")),
    (b"PathFileType\t4\t(X/Y/Z)", ("TRC", "markers")),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:", ("LFS",)),
    (b"/annex/objects/SHA256E-s123--ab.bvh\n", ("git-annex", "`git annex")),
    (pickle.dumps({"poses": [1.0]}), ("pickle", "Python")),
    (pickle.dumps({"poses": [1.0]}, protocol=2), (".npz", "numpy.savez")),
    (b"\x00\x00\x00\x18ftypmp42", ("MP4",)),
    (b"\x00\x00\x00\x14ftypqt  ", ("MOV",)),
    (b"\x00\x00\x00\x08wide", ("MOV",)),
    (b"RIFF\x00\x00\x00\x00AVI LIST", ("AVI",)),
    (b"%PDF-1.7", ("PDF",)),
    (b"\n<!doctype html><html>", ("HTML", "download")),
    ("\ufeff<html>".encode("utf-16-le"), ("HTML",)),
    ("\ufeff<html>".encode("utf-8"), ("HTML",)),
    (b'{"schema": "twistcore.session/3", "clip"', ("session", "`twistcore apply SESSION CLIP")),
    (b'{\n "schema": "twistcore.truth/1"', ("JSON", "twistcore.truth")),
    (b'[{"a": 1}]', ("JSON",)),
    (b"# AST/ASF file using VICON dataset", ("ASF", ".amc")),
    (b"#!OML:ASF F:\\VICON\n:FULLY-SPECIFIED", ("AMC", ".amc")),
]


@pytest.mark.parametrize(("data", "facts"), NAMED, ids=str)
def test_what_is_no_bvh_is_named_in_one_sentence(tmp_path, data, facts):
    path = tmp_path / "clip.bvh"
    path.write_bytes(data + bytes(600))
    with refused(TwistError, f"{path}: ", "BVH", *facts):
        read_clip(path)


@pytest.mark.parametrize(("name", "kind"), [("clip.npz", ".npz"), ("clip.amc", "AMC")])
def test_a_bvh_of_another_name_is_told_its_own(tmp_path, name, kind):
    path = tmp_path / name
    path.write_bytes((ASSETS / "walk.bvh").read_bytes())
    with refused(TwistError, "BVH", ".bvh"):
        read_clip(path)
    path.write_bytes(b"%PDF-1.7")
    with refused(TwistError, kind, "PDF"):
        read_clip(path)


def test_a_clip_in_the_place_of_a_session_is_named():
    with refused(TwistError, "session", "BVH"):
        read_session(ASSETS / "walk.bvh")
    with pytest.raises(TwistError, match=r"JSON .*twistcore.truth"):
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
        assert detect_file_kind(head) is BVH
        assert wrong_file_kind_message(head, BVH) is None
    assert wrong_file_kind_message(arrays(), NPZ) is None
    assert wrong_file_kind_message(b":FULLY-SPECIFIED\n:DEGREES\n1\n", AMC) is None


@pytest.mark.parametrize("data", [b"", b"P", b"{", b"hello", b"1 2 3", b"\x00" * 40, b"\xff\xfeH"])
def test_what_cannot_be_told_is_left_to_the_reader(data):
    assert detect_file_kind(data) is None
    if data:
        with pytest.raises(TwistError, match="HIERARCHY"):
            parse_bvh(data)
