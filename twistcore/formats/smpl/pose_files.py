"""Read pose files (.npz, .npy or pickles) as named arrays, without running code from the file."""

from __future__ import annotations

import bz2
import lzma
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.errors import NpzError, TwistError
from twistcore.files.ordinary import read_file
from twistcore.formats.npz.archive import (
    LARGEST,
    npy_header,
    open_archive,
    unpack_limit_in_bytes,
)
from twistcore.formats.npz.pickled_arrays import LimitError, Unreadable, read_pickle

SUFFIXES = (".npz", ".npy", ".pkl", ".pickle", ".joblib", ".pt", ".pth")
_DICTIONARY = 1 << 27  # bytes of memory for xz, twice as much as its largest preset needs
_CONVERT = "save its arrays by name with numpy.savez"
# The compressions that joblib uses: the first bytes of a file, and the decompressor. gzip is zlib
# with another header.
_COMPRESSED: tuple[tuple[bytes, Callable[[], Any]], ...] = (
    (b"\x78", zlib.decompressobj),
    (b"\x1f\x8b", lambda: zlib.decompressobj(31)),
    (b"BZh", bz2.BZ2Decompressor),
    (b"\xfd7zXZ", lambda: lzma.LZMADecompressor(memlimit=_DICTIONARY)),
    (b"\x5d\x00\x00", lambda: lzma.LZMADecompressor(memlimit=_DICTIONARY)),
)


class PosesError(TwistError):
    """Raised if a file cannot be read as poses."""


def is_pose_file(path: Path) -> bool:
    """Return True if a file has the suffix of a pose file. All other files are read as BVH."""
    return path.suffix.lower() in SUFFIXES


def read_pose_file(path: Path) -> dict[Any, Any]:
    """Return the contents of a pose file, keyed by name.

    The values are arrays, dicts, lists, strings and numbers. Pickles, including pickled dicts
    inside an .npz, are read without running code
    (:mod:`pickled_arrays <twistcore.formats.npz.pickled_arrays>`). Raises PosesError if the file is
    not a pose file, and OSError if it cannot be read.
    """
    if path.stat().st_size > LARGEST:
        raise _too_large(path, LARGEST)
    data = read_file(path)
    try:
        if data.startswith(b"PK"):
            found = _archive(path, data)
        elif data.startswith(b"\x93NUMPY"):
            found = _array(data)
        else:
            found = read_pickle(_decompressed(path, data))
    except PosesError:
        raise
    except NpzError as error:
        raise PosesError(str(error)) from None
    except LimitError as error:
        raise PosesError(f"{path}: {error}") from None
    except Exception:  # a damaged archive raises many different errors
        raise PosesError(
            f"{path}: expected an .npz, .npy or pickle of arrays; if it is in another format, "
            f"{_CONVERT}"
        ) from None
    if not isinstance(found, dict):
        raise PosesError(f"{path}: expected named arrays, found {describe_pose_file_value(found)}")
    return found


def describe_pose_file_value(value: Any) -> str:
    """Describe a value for a message: the shape of an array, or the contents of a dict or list."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, dict):
        some = [f"{name} {_short(item)}".strip() for name, item in list(value.items())[:12]]
        more = f" and {len(value) - len(some)} more" if len(value) > len(some) else ""
        return printable_pose_file_text((", ".join(some) + more) or "nothing")
    return printable_pose_file_text(_short(value))


def printable_pose_file_text(text: str) -> str:
    """Shorten a string for a message, and replace unprintable characters such as line breaks."""
    return "".join(c if c.isprintable() else "?" for c in text[:1000])


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return str(value.shape)
    if isinstance(value, dict | list):
        return f"({'dict' if isinstance(value, dict) else 'list'} of {len(value)})"
    if isinstance(value, Unreadable):
        return f"({value.kind})"
    return f"({type(value).__name__})"


def _too_large(path: Path, most: int) -> PosesError:
    return PosesError(f"{path}: expected at most {most >> 20} MiB unpacked; leave out vertices")


def _decompressed(path: Path, data: bytes) -> bytes:
    for start, make in _COMPRESSED:
        if data.startswith(start):
            reader = make()
            most = unpack_limit_in_bytes(len(data))
            out: bytes = reader.decompress(data, most)
            if not reader.eof:
                if len(out) >= most:
                    raise _too_large(path, most)
                raise ValueError("the file is truncated")
            return out
    return data


def _archive(path: Path, data: bytes) -> dict[str, Any]:
    archive = open_archive(path, data)
    if any(name.endswith("data.pkl") for name in archive.infos):
        raise PosesError(f"{path}: expected NumPy arrays, found a PyTorch file; {_CONVERT}")
    return {name: _array(archive.raw(name)) for name in archive.infos}


def _array(raw: bytes) -> Any:
    """Return the array or object stored in the bytes of an .npy file."""
    start, shape, dtype, by_column = npy_header(raw)
    if dtype.hasobject:
        return read_pickle(raw[start:])
    flat = np.frombuffer(raw, dtype=dtype, offset=start)
    return flat.reshape(shape, order="F" if by_column else "C")
