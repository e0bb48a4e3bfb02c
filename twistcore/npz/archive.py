"""An .npz as it was read: its arrays one by one, and the same bytes with some of them replaced."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import NpzError
from twistcore.file_kinds import NPZ, found_instead

LARGEST = 1 << 31  # bytes that are taken into memory
_NPY = ".npy"
_DESCRIPTOR = 1 << 3  # flag: sizes and check sum stand behind the data
_ENCRYPTED = 1 << 0
_ZIP64 = 1  # of an extra field


def names_in(path: Path) -> list[str] | None:
    """The names of an .npz, of which no array is read; None where it is damaged or none."""
    try:
        with zipfile.ZipFile(path) as archive:
            return [name.removesuffix(_NPY) for name in archive.namelist()]
    except (OSError, zipfile.BadZipFile):
        return None


@dataclass(frozen=True, eq=False)
class Archive:
    """path: for sentences; data: the bytes; infos: what the directory says of every member."""

    path: Path
    data: bytes = field(repr=False)
    infos: Mapping[str, zipfile.ZipInfo]

    def __contains__(self, name: object) -> bool:
        return name in self.infos

    def described(self) -> str:
        """The names, for a sentence: on one line and not long."""
        some = list(self.infos)[:12]
        more = f" and {len(self.infos) - len(some)} more" if len(self.infos) > len(some) else ""
        text = "".join(c if c.isprintable() else "?" for c in ", ".join(some)[:500])
        return (text or "nothing") + more

    def array(self, name: str) -> NDArray[Any]:
        """The array of a name; NpzError where it is damaged, or an object, which would be run."""
        return self._member(name)[1]

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """The bytes with these arrays, of the sizes and dtypes that are there; nothing else moves.

        Members that are stored plainly are replaced where they stand. A compressed one gets
        another length: then the archive is packed anew, members in their order, each compressed
        as it was. NpzError where another array proves to be damaged on that way.
        """
        contents = {name: self._content(name, values) for name, values in arrays.items()}
        if all(self.infos[name].compress_type == zipfile.ZIP_STORED for name in contents):
            return self._in_place(contents)
        return self._packed(contents)

    def _raw(self, name: str) -> bytes:
        info = self.infos[name]
        if info.file_size > LARGEST:
            raise too_large(self.path)
        try:
            with zipfile.ZipFile(io.BytesIO(self.data)) as archive:
                return archive.read(info)
        except Exception:  # a damaged archive fails in as many ways as it has parts
            raise NpzError(f"{self.path}: expected a whole array {name!r}") from None

    def _member(self, name: str) -> tuple[bytes, NDArray[Any], bool]:
        """Its header, its values and whether these stand column by column."""
        raw = self._raw(name)
        file, form = io.BytesIO(raw), np.lib.format
        try:
            first = form.read_magic(file) == (1, 0)
            read = form.read_array_header_1_0 if first else form.read_array_header_2_0
            shape, by_column, dtype = read(file)
            if not dtype.hasobject:
                start = file.tell()
                flat = np.frombuffer(raw, dtype=dtype, offset=start)
                values = flat.reshape(shape, order="F" if by_column else "C")
                return raw[:start], values, by_column
        except ValueError:  # also of a header that is no Python literal
            raise NpzError(f"{self.path}: expected a whole array {name!r}") from None
        raise NpzError(
            f"{self.path}: expected numbers in {name!r}, found objects, which only a program that "
            "is run could unpack"
        )

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
                new.writestr(fresh, contents[name] if name in contents else self._raw(name))
        return out.getvalue()


def open_archive(path: Path, data: bytes) -> Archive:
    """The members of an .npz; none is unpacked yet. NpzError."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = archive.infolist()
    except Exception:
        instead = found_instead(data, NPZ)
        raise NpzError(f"{path}: {instead or 'expected an .npz of numpy'}") from None
    named = {info.filename.removesuffix(_NPY): info for info in infos}
    if len(named) < len(infos):
        raise NpzError(f"{path}: expected every array once, found two of one name")
    if any(info.flag_bits & _ENCRYPTED for info in infos):
        raise NpzError(f"{path}: expected arrays that are not encrypted")
    return Archive(path, data, named)


def too_large(path: Path) -> NpzError:
    """For a file or an array in it."""
    return NpzError(f"{path}: expected at most {LARGEST >> 30} GiB")


def _directory(data: bytes) -> list[tuple[int, int]]:
    """Where each entry of the directory stands, and where its member does."""
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
