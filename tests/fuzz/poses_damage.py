"""Damage to archives and pickles of arrays: members, shapes, dtypes, headers, and bytes."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import pickle
import pickletools
import random
import struct
import zipfile
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

DTYPES = ("<f8", ">f8", "<f4", ">f4", "<f2", "<f4", "<i4", "|b1", "<c16", "|S8", "<U2", "O", "|V8")
SHAPES = (
    (10**18, 72), (-1, 72), (0, 72), (0, 10**18), (60, -66), (1,) * 40, (), (True, 72), (2.5, 3),
    (10**30,), (60, 22, 3), (1, 66), (4, 72), "text", None, (60, "a"),
)  # fmt: skip
NAMES = (
    "poses", "trans", "mocap_framerate", "fps", "J", "offsets", "root_orient", "pose_body",
    "global_orient", "body_pose", "transl", "pose", "smpl_thetas", "track_ids", "cam_trans",
    "outputs", "pred_rotmat", "pred_trans", "frame_ids", "smpl_params_global", "../poses",
    "/etc/poses", "po\nses", "poses.npy", "", "data.pkl", "x" * 300,
)  # fmt: skip
# Of a directory's record: form, and the byte that it begins at.
_FIELDS = (
    ("<H", 6), ("<H", 8), ("<H", 10), ("<I", 16), ("<I", 20), ("<I", 24), ("<H", 28), ("<H", 30),
    ("<I", 42),
)  # fmt: skip
_SIZES = (0.0, 1e-320, 1e-9, 1e-3, 1.0, 3.2, 100.0, 1e5, 9e5, 1e7, 1e300, np.inf, np.nan)


def damaged(data: bytes, rng: random.Random) -> bytes:
    """A copy with one to four damages of bytes, as often as not near an end, where headers are."""
    for _ in range(rng.randint(1, 4)):
        near = min(len(data), 900)
        at = rng.choice((rng.randrange(near + 1), rng.randrange(len(data) + 1)))
        at = rng.choice((at, len(data) - at))
        what = rng.randrange(5)
        if what == 0:
            data = data[:at] + data[at + rng.choice((1, 4, 100, len(data))) :]
        elif what == 1:
            data = data[:at] + data[at : at + 40] * rng.choice((2, 100)) + data[at:]
        elif what == 2:
            data = data[:at] + bytes(rng.randrange(256) for _ in range(4)) + data[at + 4 :]
        else:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
    return data


def archive(arrays: Mapping[str, Any], rng: random.Random) -> bytes:
    """An .npz of arrays, of which some are others, or none."""
    for _ in range(rng.randint(0, 3)):
        arrays = _other(dict(arrays), rng)
    members = {f"{name}.npy": npy(value) for name, value in arrays.items()}
    if rng.random() < 0.2:
        name = rng.choice([*members] or ["a.npy"])
        members[name] = _odd_header(members.get(name, b""), rng)
    plain, packed = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED
    compress = rng.choice((plain, plain, packed))
    if rng.random() < 0.04:
        compress = rng.choice((zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA))
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", compress, compresslevel=1) as made:
        for name, raw in members.items():
            made.writestr(zipfile.ZipInfo(name), raw, compress)  # with no time of its own
    data = out.getvalue()
    if rng.random() < 0.2:
        data = _odd_directory(data, rng)
    return damaged(data, rng) if rng.random() < 0.2 else data


def names(arrays: Mapping[str, Any], rng: random.Random) -> bytes:
    """A pickle of names, some with other things under them, perhaps compressed."""
    made: dict[Any, Any] = dict(arrays)
    for _ in range(rng.randint(0, 4)):
        made = _other(made, rng)
    if rng.random() < 0.4:
        key = rng.choice([*made] or ["poses"])
        made[key] = _odd_value(made.get(key), rng)
    if rng.random() < 0.3:
        inside = rng.choice(("outputs", "smpl_params_global", 0, np.int64(3), "7"))
        made = {inside: made, **({"8": made} if rng.random() < 0.3 else {})}
    try:
        data = pickle.dumps(made, protocol=rng.randint(0, 5))
    except RuntimeError:  # an array of more axes than pickles of old have
        data = pickle.dumps(None)
    if rng.random() < 0.4:
        data = instructions(data, rng)
    if rng.random() < 0.15:
        data = damaged(data, rng)
    squeeze = rng.choice((bytes, bytes, zlib.compress, gzip.compress, bz2.compress, lzma.compress))
    data = squeeze(data)
    return damaged(data, rng) if rng.random() < 0.1 else data


def npy(value: Any) -> bytes:
    """As numpy saves it."""
    out = io.BytesIO()
    np.lib.format.write_array(out, np.asanyarray(value), allow_pickle=True)
    return out.getvalue()


def header(descr: Any, by_column: Any, shape: Any, raw: bytes = b"") -> bytes:
    """An .npy that says this of itself."""
    text = repr({"descr": descr, "fortran_order": by_column, "shape": shape}).encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + raw


def _other(arrays: dict[Any, Any], rng: random.Random) -> dict[Any, Any]:
    """With one array of another name, kind, shape, order, or with other numbers."""
    numeric = [k for k, v in arrays.items() if isinstance(v, np.ndarray) and v.dtype.kind == "f"]
    key = rng.choice(numeric or ["poses"])
    value = np.array(arrays.get(key, np.zeros(3)))
    what = rng.randrange(7)
    with np.errstate(all="ignore"):
        if what == 0:
            arrays[rng.choice(NAMES)] = arrays.pop(key, value)
        elif what == 1 and rng.random() < 0.5:
            arrays.pop(key, None)
        elif what == 2:
            arrays[key] = np.abs(value).astype(rng.choice(DTYPES))
        elif what == 3 and value.size:
            flat = value.reshape(-1)
            size = rng.choice(_SIZES)
            for _ in range(rng.choice((1, 20, 500))):
                flat[rng.randrange(len(flat))] = rng.choice((-1.0, 1.0)) * size
            arrays[key] = value
        elif what == 4:
            arrays[key] = np.asfortranarray(value)
        elif what == 5:
            arrays = _of_frames(arrays, rng.choice((0, 1, 1, 2, 3, 5, 300)), rng)
        else:
            arrays[key] = rng.choice((value[None], value[..., None], value.T, value.reshape(-1)))
    return arrays


def _of_frames(arrays: dict[Any, Any], count: int, rng: random.Random) -> dict[Any, Any]:
    """All with so many frames, or all but one."""
    out = {}
    for key, value in arrays.items():
        long = isinstance(value, np.ndarray) and value.ndim > 1 and len(value) > 24
        out[key] = np.resize(value, (count, *value.shape[1:])) if long else value
    if rng.random() < 0.2:
        key = rng.choice([*out])
        out[key] = arrays[key]
    return out


def _odd_header(raw: bytes, rng: random.Random) -> bytes:
    """A member whose header tells of what is not there, or is none."""
    what = rng.randrange(5)
    if what == 0:
        return header("<f8", rng.choice((False, True)), rng.choice(SHAPES), raw[128:])
    if what == 1:
        descr = rng.choice((*DTYPES, [("x", "<f8")], "(66,)<f8", "<M8[s]", "nothing", None, {}))
        return header(descr, False, (4, 66), bytes(4 * 66 * 8))
    if what == 2:  # few bytes that become many
        rows = rng.choice((1000, 20_000, 100_000))
        return header(rng.choice(("<f2", "<f8")), False, (rows, 156), bytes(rows * 312))
    if what == 3:
        return b"\x93NUMPY" + bytes([rng.randrange(5), 0]) + raw[8:]
    text = rng.choice((b"(" * 5000, b"'''\n", b"{" * 100, b"-" * 9000 + b"1", b"\xff\xfe", b"1L"))
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + raw[128:]


def _odd_directory(data: bytes, rng: random.Random) -> bytes:
    """Sizes, places, flags or methods of a member that are not so, in one record or both."""
    out = bytearray(data)
    records = [
        k for k in range(len(data) - 46) if data[k : k + 4] in (b"PK\x01\x02", b"PK\x03\x04")
    ]
    for _ in range(rng.randint(1, 2)):
        if not records:
            break
        at = rng.choice(records)
        form, field = rng.choice(_FIELDS)
        most = 0xFFFF if form == "<H" else 0xFFFFFFFF
        struct.pack_into(
            form, out, at + field, rng.choice((0, 1, 8, 40, 200, most, rng.randint(0, most)))
        )
    return bytes(out)


def _odd_value(value: Any, rng: random.Random) -> Any:
    """Something else under a name: lists, dicts, words, objects, numbers beyond all."""
    loop: list[Any] = []
    loop.append(loop)
    return rng.choice((
        None, True, 10**400, -1, "text", b"bytes", [], {}, loop, [value], {"poses": value},
        [np.zeros(3)] * 4, np.atleast_1d(value).tolist(), [*np.atleast_1d(value)],
        np.array(value, dtype=object), float("nan"), 1j, {1, 2}, np.float32(3.0), random.Random,
        [{"smpl": {}, "tid": [1], "time": 0}], np.empty((0, 3)), np.ma.zeros(3), range(3),
    ))  # fmt: skip


# -- the instructions of a pickle --------------------------------------------------------------

_WORDS = (b"numpy\ndtype", b"_codecs\nencode", b"numpy.core.numeric\n_frombuffer", b"builtins\nset",
          b"numpy.core.multiarray\nscalar", b"numpy.core.multiarray\n_reconstruct", b"a\nb",
          b"collections\nOrderedDict", b"joblib.numpy_pickle\nNumpyArrayWrapper")  # fmt: skip
_NUMBERS = (0, 1, 3, 255, 65_537, 576_000_000, 8_600_000_000, -1, (1 << 61) - 1, 1 << 400)


def _instruction(rng: random.Random) -> bytes:
    """One instruction, with or without what it works on."""
    simple = b"()]}t1l d0 2NRabseu\x81\x85\x86\x87\x8f\x90\x91\x92\x93\x94".replace(b" ", b"")
    what = rng.randrange(8)
    if what == 0:
        return b"c" + rng.choice(_WORDS) + b"\n"
    if what == 1:
        value = rng.choice(_NUMBERS)
        raw = value.to_bytes(value.bit_length() // 8 + 1, "little", signed=True)
        return b"\x8a" + bytes([len(raw)]) + raw
    if what == 2:
        return rng.choice((b"p%d\n" % abs(rng.choice(_NUMBERS)), b"q\x01", b"h\x01", b"g1\n"))
    if what == 3:
        return b"\x8c\x04text"
    if what == 4:  # one value many times within itself
        return rng.choice((b"2\x86", b"](2e2", b"}(N2", b"2\x85\x94")) * rng.choice((1, 60, 3000))
    return bytes([rng.choice(simple)])


def instructions(data: bytes, rng: random.Random) -> bytes:
    """A pickle with instructions that are missing, repeated, exchanged, or others."""
    try:
        places = [(op.code, at) for op, _, at in pickletools.genops(data) if at is not None]
    except Exception:  # joblib puts bytes between the instructions
        return data
    ends = [at for _, at in places[1:]] + [len(data)]
    found = [
        data[at:end] for (code, at), end in zip(places, ends, strict=True) if code != "\x95"
    ]  # without the lengths of the frames, which would not be right
    for _ in range(rng.choice((1, 1, 2, 5))):
        at, other = rng.randrange(1, len(found) + 1), rng.randrange(1, len(found) + 1)
        what = rng.randrange(5)
        if what == 0:
            found[at:at] = [_instruction(rng) for _ in range(rng.choice((1, 2, 6)))]
        elif what == 1:
            found[at : at + rng.choice((1, 3, 30))] = []
        elif what == 2:
            found[at:at] = found[other : other + rng.choice((1, 5, 40))] * rng.choice((1, 2, 500))
        elif what == 3:
            found[at : at + 1] = found[other : other + 1]
        else:
            found[at : at + 1] = [_instruction(rng)]
    return b"".join(found)
