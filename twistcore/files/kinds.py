"""Recognise the kind of a file from its first bytes, for messages about unexpected files."""

from __future__ import annotations

import re
from typing import NamedTuple

from twistcore.files.wide_text import first_bytes_as_utf8

LOOKED_AT = 512  # number of bytes at the start of a file from which its kind is recognised

_CONVERT = "convert it to BVH with `twistcore convert`"
_UNPACK = "unpack it first"
_SOLVE = "markers have no joints: solve them onto a skeleton first and export that as BVH"


class FileKind(NamedTuple):
    """A kind of file.

    Parameters
    ----------
    words
        The kind's name, such as 'an FBX file (binary)'.
    advice
        Advice for a user who has given such a file by mistake, or ''.
    """

    words: str
    advice: str = ""


# Formats that can be read, and formats of this project.
BVH = FileKind("a BVH file", "give it a name that ends in .bvh")
NPZ = FileKind("an .npz", "give it a name that ends in .npz")
AMC = FileKind("an AMC file", "give it a name that ends in .amc")
SESSION = FileKind(
    "a session",
    ("replay it with `twistcore apply SESSION CLIP -o OUT`, or open it in twist-inspector"),
)
JSON = FileKind("a JSON document")
PICKLE = FileKind(
    "a Python pickle",
    "an AIST++ pickle needs a name that ends in .pkl; save the arrays of any other pickle "
    "as .npz with numpy.savez, because the program never runs pickles",
)

_ASF = FileKind("an ASF skeleton without motion", "open its .amc")
_TEXT_OF_OURS = re.compile(rb'^\{\s*"schema":\s*"twistcore\.([a-z_-]+)/')

_BEGINNINGS: tuple[tuple[bytes, FileKind], ...] = (
    (b"Kaydara FBX Binary", FileKind("an FBX file (binary)", _CONVERT)),
    (b"; FBX ", FileKind("an FBX file (text)", f"save it as binary FBX, then {_CONVERT}")),
    (b"glTF", FileKind("a glTF file (binary)", _CONVERT)),
    (b"BLENDER", FileKind("a Blender file", _CONVERT)),
    (b"PK\x05\x06", FileKind("an empty ZIP archive")),
    (
        b"\x93NUMPY",
        FileKind("a single NumPy array (.npy)", "save its arrays by name with numpy.savez"),
    ),
    (b"\x1f\x8b", FileKind("a gzip archive", _UNPACK)),
    (b"\xfd7zXZ\x00", FileKind("an xz archive", _UNPACK)),
    (b"BZh", FileKind("a bzip2 archive", _UNPACK)),
    (b"\x28\xb5\x2f\xfd", FileKind("a Zstandard archive", _UNPACK)),
    (b"7z\xbc\xaf\x27\x1c", FileKind("a 7-Zip archive", _UNPACK)),
    (b"Rar!\x1a\x07", FileKind("a RAR archive", _UNPACK)),
    (b"\x89PNG\r\n", FileKind("a PNG image")),
    (b"\xff\xd8\xff", FileKind("a JPEG image")),
    (b"GIF8", FileKind("a GIF image")),
    (b"%PDF-", FileKind("a PDF document")),
    (b"\x1a\x45\xdf\xa3", FileKind("a Matroska or WebM video")),
    (b"PathFileType", FileKind("a TRC file of markers", _SOLVE)),
    (
        b"version https://git-lfs.github.com/spec/",
        FileKind("a Git LFS pointer, not the file itself", "`git lfs pull` fetches the file"),
    ),
    (
        b"/annex/objects/",
        FileKind("a git-annex pointer, not the file itself", "`git annex get` fetches the file"),
    ),
    (b"PXR-USDC", FileKind("a USD file")),
    (b"#usda ", FileKind("a USD file")),
    (b"//Maya ASCII", FileKind("a Maya scene", "export its skeleton as BVH or FBX")),
    (b"\x89HDF\r\n", FileKind("an HDF5 file")),
    (b"SQLite format 3\x00", FileKind("an SQLite database")),
)


def detect_file_kind(head: bytes) -> FileKind | None:
    """Return the kind of a file from its first 512 bytes, or None if unknown.

    Text may be in UTF-8, UTF-16 or UTF-32.
    """
    head = first_bytes_as_utf8(head)
    for beginning, kind in _BEGINNINGS:
        if head.startswith(beginning):
            return kind
    return _zip(head) or _film(head) or _pickle(head) or _c3d(head) or _text(head)


def wrong_file_kind_message(head: bytes, *expected: FileKind) -> str | None:
    """Return a message such as 'expected a BVH file, but this is a PNG image', or None.

    `head` contains the first bytes of a file. `expected` are the kinds that the reader accepts; the
    message mentions the first of them. The result is None for an expected or unknown kind.
    """
    kind = detect_file_kind(head)
    if kind is None or kind in expected:
        return None
    clips = (BVH, NPZ, AMC)  # renaming the file helps only if a clip is expected
    helps = kind.advice and (kind not in clips or expected[0] in clips)
    sentence = f"expected {expected[0].words}, but this is {kind.words}"
    return f"{sentence}; {kind.advice}" if helps else sentence


def _zip(head: bytes) -> FileKind | None:
    """Recognise a ZIP archive or .npz file by the name of its first member, which is at byte 30."""
    if not head.startswith(b"PK\x03\x04"):
        return None
    name = head[30 : 30 + int.from_bytes(head[26:28], "little")]
    return FileKind("a ZIP archive", _UNPACK) if name and not name.endswith(b".npy") else NPZ


def _film(head: bytes) -> FileKind | None:
    if head[4:8] == b"ftyp":
        quick = head[8:12] == b"qt  "
        return FileKind("a video (MOV)" if quick else "a video (MP4)")
    if head[4:8] in (b"moov", b"mdat", b"wide"):
        return FileKind("a video (MOV)")
    if head.startswith(b"RIFF"):
        return FileKind("a video (AVI)" if head[8:12] == b"AVI " else "a sound or an image (RIFF)")
    return None


def _c3d(head: bytes) -> FileKind | None:
    """Recognise a C3D file by its second byte, 0x50, and by its first, which is usually 2."""
    if len(head) > 2 and head[1] == 0x50 and 2 <= head[0] < 0x20:
        return FileKind("a C3D file of markers", _SOLVE)
    return None


def _pickle(head: bytes) -> FileKind | None:
    """Recognise a pickle of protocol 2 to 5. Python 3 writes such pickles by default."""
    return PICKLE if head[:1] == b"\x80" and head[1:2] in (b"\2", b"\3", b"\4", b"\5") else None


def _text(head: bytes) -> FileKind | None:
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    word = text[:16].upper()
    if word.startswith(b"HIERARCHY"):
        return BVH
    if word.startswith((b"<!DOCTYPE HTML", b"<HTML", b"<HEAD", b"<BODY")):
        advice = "download the file itself instead of a log-in page or a viewer"
        return FileKind("a web page (HTML)", advice)
    if word.startswith(b"<?XML"):
        return FileKind("an XML document")
    if word.startswith((b"# AST/ASF", b":VERSION")):
        return _ASF
    if word.startswith((b"#!OML:ASF", b":FULLY-SPECIFIED")):
        return AMC
    return _json(text)


def _json(text: bytes) -> FileKind | None:
    if ours := _TEXT_OF_OURS.match(text):
        name = ours[1].decode()
        return SESSION if name == "session" else FileKind(f"a JSON document (twistcore.{name})")
    if not re.match(rb'\{\s*["}]|\[\s*[\[{"\d\]-]', text):
        return None
    return FileKind("a glTF file (text)", _CONVERT) if b'"asset"' in text else JSON
