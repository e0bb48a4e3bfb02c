"""Files of poses as names with what stands under them: .npz, and pickles without running them."""

from __future__ import annotations

import bz2
import io
import lzma
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np

from twistcore.errors import TwistError
from twistcore.ordinary_files import read_file
from twistcore.quamo.pickled_arrays import Unreadable, read_pickle

SUFFIXES = (".npz", ".npy", ".pkl", ".pickle", ".joblib", ".pt", ".pth")
_LARGEST = 1 << 31  # bytes that are taken into memory
_CONVERT = "save its arrays by name with numpy.savez"
# What joblib compresses with, by the first bytes; gzip is zlib with another header.
_COMPRESSED: tuple[tuple[bytes, Callable[[], Any]], ...] = (
    (b"\x78", zlib.decompressobj),
    (b"\x1f\x8b", lambda: zlib.decompressobj(31)),
    (b"BZh", bz2.BZ2Decompressor),
    (b"\xfd7zXZ", lzma.LZMADecompressor),
    (b"\x5d\x00\x00", lzma.LZMADecompressor),
)


class PosesError(TwistError):
    """A file that cannot be read as poses: one sentence."""


def holds_poses(path: Path) -> bool:
    """A file of poses by its name, where everything else is a BVH."""
    return path.suffix.lower() in SUFFIXES


def read_names(path: Path) -> dict[Any, Any]:
    """What a file holds under its names: arrays, dicts, lists, words, numbers.

    A pickle is read without running anything (:mod:`pickled_arrays
    <twistcore.quamo.pickled_arrays>`), so are dicts within an .npz. Raises PosesError, OSError.
    """
    if path.stat().st_size > _LARGEST:
        raise _too_large(path)
    data = read_file(path)
    try:
        if data.startswith(b"PK"):
            found = _archive(path, data)
        elif data.startswith(b"\x93NUMPY"):
            found = _member(io.BytesIO(data))
        else:
            found = read_pickle(_decompressed(path, data))
    except PosesError:
        raise
    except Exception:  # a damaged archive fails in as many ways as it has parts
        raise PosesError(
            f"{path}: expected an .npz, .npy or pickle of arrays; {_CONVERT} if it is none"
        ) from None
    if not isinstance(found, dict):
        raise PosesError(f"{path}: expected names with arrays, found {described(found)}")
    return found


def described(value: Any) -> str:
    """In a few words for a sentence: the shape of an array, what a dict or list holds."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, dict):
        some = [f"{name} {_short(item)}".strip() for name, item in list(value.items())[:12]]
        more = f" and {len(value) - len(some)} more" if len(value) > len(some) else ""
        return printable((", ".join(some) + more) or "nothing")
    return printable(_short(value))


def printable(text: str) -> str:
    """On one line and not long, whatever a file calls its arrays."""
    return "".join(c if c.isprintable() else "?" for c in text[:1000])


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return str(value.shape)
    if isinstance(value, dict | list):
        return f"({'dict' if isinstance(value, dict) else 'list'} of {len(value)})"
    if isinstance(value, Unreadable):
        return f"({value.kind})"
    return f"({type(value).__name__})"


def _too_large(path: Path) -> PosesError:
    return PosesError(f"{path}: expected at most {_LARGEST >> 30} GiB; leave out vertices")


def _decompressed(path: Path, data: bytes) -> bytes:
    for start, make in _COMPRESSED:
        if data.startswith(start):
            reader = make()
            out: bytes = reader.decompress(data, _LARGEST)
            if not reader.eof:
                if len(out) >= _LARGEST:
                    raise _too_large(path)
                raise ValueError("cut off")
            return out
    return data


def _archive(path: Path, data: bytes) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = archive.namelist()
        if any(name.endswith("data.pkl") for name in names):
            raise PosesError(f"{path}: expected arrays of numpy, found a file of torch; {_CONVERT}")
        if sum(info.file_size for info in archive.infolist()) > _LARGEST:
            raise _too_large(path)
        found = {}
        for name in names:
            with archive.open(name) as file:
                found[name.removesuffix(".npy")] = _member(file)
        return found


def _member(file: IO[bytes]) -> Any:
    form = np.lib.format
    if form.read_magic(file) == (1, 0):
        shape, by_column, dtype = form.read_array_header_1_0(file)
    else:
        file.seek(0)
        form.read_magic(file)
        shape, by_column, dtype = form.read_array_header_2_0(file)
    raw = file.read()
    if dtype.hasobject:
        return read_pickle(raw)
    return np.frombuffer(raw, dtype=dtype).reshape(shape, order="F" if by_column else "C")
