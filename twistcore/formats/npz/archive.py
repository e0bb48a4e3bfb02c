"""Read individual arrays of an .npz file, and replace arrays in the file's bytes."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import NpzError
from twistcore.files.kinds import NPZ, wrong_file_kind_message
from twistcore.formats.bvh.header import quoted_word
from twistcore.work.frozen import dataclass

LARGEST = 1 << 31  # maximum number of bytes that are read into memory
# Limit for a file's unpacked bytes: a constant plus a multiple of its size. Motion is compressed to
# a third. Data that is compressed to a thousandth is a figure without motion or an attack.
_FREE, _RATIO = 1 << 25, 64
_EMPTY = 1 << 16  # maximum length of an axis of an array without elements
_NUMBER = 8  # number of bytes of a value in memory
# Compression methods that can be unpacked up to a limit.
_AS_NUMPY = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_NPY = ".npy"
_DESCRIPTOR = 1 << 3  # flag: sizes and checksum are stored after the data
_ENCRYPTED = 1 << 0
_ZIP64 = 1  # kind of a member's extra field
_HEADER = 30  # number of bytes of a member's header without name and extra field


def array_names_in(path: Path) -> list[str] | None:
    """Return the names of the arrays in an .npz file, or None if the file is invalid.

    No array is read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            return [name.removesuffix(_NPY) for name in archive.namelist()]
    except Exception:  # a damaged archive can raise almost anything
        return None


@dataclass(frozen=True, eq=False)
class Archive:
    """An .npz file.

    Attributes
    ----------
    path
        The file, for messages.
    data
        The file's bytes.
    infos
        ZIP information about each member, keyed by array name.
    """

    path: Path
    data: bytes = field(repr=False)
    infos: Mapping[str, zipfile.ZipInfo]

    def __contains__(self, name: object) -> bool:
        return name in self.infos

    def described(self) -> str:
        """Return the names of the arrays as one short line for a message."""
        return shorten_npz_array_names(self.infos)

    def array(self, name: str) -> NDArray[Any]:
        """Return an array.

        Raises NpzError if the array is damaged or contains objects, which could run code.
        """
        return self._member(name)[1]

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """Return the file's bytes with some arrays replaced by arrays of the same size and dtype.

        Uncompressed arrays are overwritten in place. If a replaced array is compressed, its length
        changes, so the whole archive is packed again. Members keep their order and compression.

        Raises NpzError if another array turns out to be damaged.
        """
        contents = {name: self._content(name, values) for name, values in arrays.items()}
        return self.with_contents(contents)

    def with_contents(self, contents: Mapping[str, bytes]) -> bytes:
        """Return the file's bytes with members replaced by bytes of the same length."""
        if all(self.infos[name].compress_type == zipfile.ZIP_STORED for name in contents):
            return self._in_place(contents)
        return self._packed(contents)

    def raw(self, name: str) -> bytes:
        """Return a member's unpacked bytes. Raises NpzError if they are damaged."""
        info = self.infos[name]
        try:
            with (
                zipfile.ZipFile(io.BytesIO(self.data)) as archive,
                archive.open(info) as member,
            ):
                # Without a limit, all data would be unpacked before the declared size is checked.
                return member.read(max(info.file_size, 1))
        except Exception:
            raise self._damaged(name) from None

    def _damaged(self, name: str) -> NpzError:
        return NpzError(f"{self.path}: expected a complete array {quoted_word(name)}")

    def _member(self, name: str) -> tuple[bytes, NDArray[Any], bool]:
        """Return a member's header and values, and True if the values are in column-major order."""
        raw = self.raw(name)
        try:
            start, shape, dtype, by_column = npy_header(raw)
            if not dtype.hasobject:
                flat = np.frombuffer(raw, dtype=dtype, offset=start)
                values = flat.reshape(shape, order="F" if by_column else "C")
        except Exception:  # a damaged header, which is a Python literal, can raise almost anything
            raise self._damaged(name) from None
        if dtype.hasobject:
            raise NpzError(
                f"{self.path}: expected numbers in {quoted_word(name)}, found objects, which "
                "cannot be unpacked without running code"
            )
        if _NUMBER * values.size > unpack_limit_in_bytes(len(self.data)):
            raise _too_much(self.path, _NUMBER * values.size, len(self.data))
        return raw[:start], values, by_column

    def _content(self, name: str, values: NDArray[Any]) -> bytes:
        header, there, by_column = self._member(name)
        assert (values.size, values.dtype) == (there.size, there.dtype)
        return header + values.reshape(there.shape).tobytes("F" if by_column else "C")

    def _in_place(self, contents: Mapping[str, bytes]) -> bytes:
        data = bytearray(self.data)
        sums = {}
        for name, content in contents.items():
            info = self.infos[name]
            at = info.header_offset
            lengths = struct.unpack_from("<HH", data, at + 26)
            start = at + 30 + sum(lengths)
            stop = start + len(content)
            data[start:stop] = content
            sums[at] = struct.pack("<I", zlib.crc32(content))
            if info.flag_bits & _DESCRIPTOR:
                at = stop + 4 * (data[stop : stop + 4] == b"PK\x07\x08") - 14
            data[at + 14 : at + 18] = sums[info.header_offset]
        for at, offset in _directory(self.data):
            if offset in sums:
                data[at + 16 : at + 20] = sums[offset]
        return bytes(data)

    def _packed(self, contents: Mapping[str, bytes]) -> bytes:
        out = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(self.data)) as old:
            comment = old.comment
        with zipfile.ZipFile(out, "w") as new:
            new.comment = comment
            for name, info in self.infos.items():
                fresh = zipfile.ZipInfo(info.filename, info.date_time)
                for kept in ("compress_type", "comment", "create_system", "external_attr"):
                    setattr(fresh, kept, getattr(info, kept))
                fresh.extra = b"" if _has_zip64(info.extra) else info.extra
                new.writestr(fresh, contents[name] if name in contents else self.raw(name))
        return out.getvalue()


def shorten_npz_array_names(names: Iterable[str]) -> str:
    """Return names as one short line for a message."""
    every = list(names)
    more = f" and {len(every) - 12} more" if len(every) > 12 else ""
    text = "".join(c if c.isprintable() else "?" for c in ", ".join(every[:12])[:500])
    return (text or "nothing") + more


def open_archive(path: Path, data: bytes) -> Archive:
    """Open an .npz file without unpacking its members. Raises NpzError if the file is invalid."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = archive.infolist()
    except Exception:
        instead = wrong_file_kind_message(data, NPZ)
        raise NpzError(f"{path}: {instead or 'expected an .npz archive'}") from None
    check_members(path, infos, len(data))
    return Archive(path, data, {info.filename.removesuffix(_NPY): info for info in infos})


def check_members(path: Path, infos: Sequence[zipfile.ZipInfo], size: int) -> None:
    """Raise NpzError unless all members can be read, do not overlap and have plausible sizes.

    Nothing is unpacked. The sum of the declared sizes is limited by
    :func:`unpack_limit_in_bytes`, and a member is never read beyond its declared size. `size`
    is the size of the file in bytes.
    """
    if len({info.filename.removesuffix(_NPY) for info in infos}) < len(infos):
        raise NpzError(f"{path}: expected every array once, found two with the same name")
    if any(info.flag_bits & _ENCRYPTED for info in infos):
        raise NpzError(f"{path}: expected arrays that are not encrypted")
    if odd := [info for info in infos if info.compress_type not in _AS_NUMPY]:
        raise NpzError(
            f"{path}: expected arrays that are stored or deflated, as numpy writes them, "
            f"but {quoted_word(odd[0].filename)} is compressed differently"
        )
    if (total := sum(info.file_size for info in infos)) > unpack_limit_in_bytes(size):
        raise _too_much(path, total, size)
    stop = 0
    for info in sorted(infos, key=lambda info: info.header_offset):
        if info.header_offset < stop:
            raise NpzError(f"{path}: expected separate arrays, found one inside another")
        stop = info.header_offset + _HEADER + info.compress_size


def unpack_limit_in_bytes(size: int) -> int:
    """Return how many bytes may be unpacked from a file of `size` bytes."""
    return min(LARGEST, _FREE + _RATIO * size)


def npy_header(raw: bytes) -> tuple[int, tuple[int, ...], np.dtype[Any], bool]:
    """Return the contents of the header of an .npy file.

    Returns
    -------
    tuple
        The offset of the values in bytes, their shape, their dtype, and True for column-major
        order.

    Raises
    ------
    ValueError
        If a length is negative or impossibly large. A damaged header can raise almost any
        exception.
    """
    file, form = io.BytesIO(raw), np.lib.format
    version = form.read_magic(file)
    if version not in ((1, 0), (2, 0), (3, 0)):
        raise ValueError(version)
    first = version == (1, 0)
    with warnings.catch_warnings():
        # Headers that Python 2 wrote, and some damaged ones, cause warnings.
        warnings.simplefilter("ignore")
        read = form.read_array_header_1_0 if first else form.read_array_header_2_0
        shape, by_column, dtype = read(file)
    check_array_shape_fits_file(shape, len(raw))
    return file.tell(), shape, dtype, by_column


def check_array_shape_fits_file(shape: Sequence[int], size: int) -> None:
    """Raise ValueError if an array in a file of `size` bytes cannot have this shape."""
    if not all(0 <= length <= max(size, _EMPTY) for length in shape):
        raise ValueError(shape)


def _too_much(path: Path, found: int, size: int) -> NpzError:
    most, found = unpack_limit_in_bytes(size) >> 20, found >> 20
    return NpzError(
        f"{path}: expected at most {most} MiB of arrays in a file of this size, found {found} MiB"
    )


def too_large_error(path: Path) -> NpzError:
    """Return the error for a file that is too large or whose arrays are too large."""
    return NpzError(f"{path}: expected a file and arrays of at most {LARGEST >> 30} GiB")


def _directory(data: bytes) -> list[tuple[int, int]]:
    """Return two offsets for each entry of the ZIP directory: its own and its local header's."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        at, infos = archive.start_dir, archive.infolist()
    found = []
    for info in infos:
        found.append((at, info.header_offset))
        at += 46 + sum(struct.unpack_from("<HHH", data, at + 28))
    return found


def _has_zip64(extra: bytes) -> bool:
    at = 0
    while at + 4 <= len(extra):
        kind, length = struct.unpack_from("<HH", extra, at)
        if kind == _ZIP64:
            return True
        at += 4 + length
    return False
