"""A common interface for the named arrays in archives and pickles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import NpzError
from twistcore.files.kinds import PICKLE, wrong_file_kind_message
from twistcore.formats.bvh.header import quoted_word
from twistcore.formats.npz.archive import shorten_npz_array_names
from twistcore.formats.npz.pickled_arrays import LimitError, Places, read_pickle_with_offsets
from twistcore.work.frozen import dataclass


class Arrays(Protocol):
    """A file with named arrays: an archive or a pickle.

    See :class:`Archive <twistcore.formats.npz.archive.Archive>` and :class:`PickledDict`.
    """

    @property
    def path(self) -> Path:
        """Path of the file, for use in messages."""
        ...

    def __contains__(self, name: object) -> bool: ...

    def described(self) -> str:
        """Return the names of the arrays as one short line for a message."""
        ...

    def array(self, name: str) -> NDArray[Any]:
        """Return an array. Raises NpzError if it is damaged or does not contain numbers."""
        ...

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """Return the file's bytes with arrays replaced by arrays of the same size and dtype."""
        ...


@dataclass(frozen=True, eq=False)
class PickledDict:
    """A pickle of named arrays, which is read without executing it.

    Attributes
    ----------
    path
        The file, for messages.
    data
        The file's bytes.
    names
        The contents, keyed by name.
    places
        Offsets of the arrays' bytes in the file.
    """

    path: Path
    data: bytes = field(repr=False)
    names: Mapping[Any, Any] = field(repr=False)
    places: Places = field(repr=False)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def described(self) -> str:
        """Return the names of the arrays as one short line for a message."""
        return shorten_npz_array_names(map(str, self.names))

    def array(self, name: str) -> NDArray[Any]:
        """Return an array, or a list of plain numbers as an array.

        Raises NpzError for any other contents.
        """
        found = self.names[name]
        numbers = isinstance(found, int | float | np.generic) or (
            isinstance(found, list | tuple) and all(isinstance(x, int | float) for x in found)
        )
        values = np.asarray(found) if numbers else found
        if not isinstance(values, np.ndarray):
            raise NpzError(
                f"{self.path}: expected only numbers in {quoted_word(name)}, found other values"
            )
        return values

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """Return the file's bytes with some arrays replaced by arrays of the same size and dtype.

        All other bytes stay the same. Raises NpzError if the pickle's protocol is so old that
        lengths would change.
        """
        data = bytearray(self.data)
        for name, values in arrays.items():
            overwrite_array(data, self.path, self.places, self.array(name), values)
        return bytes(data)


def overwrite_array(
    data: bytearray,
    path: Path,
    places: Places,
    there: NDArray[Any],
    values: NDArray[Any],
    offset: int = 0,
) -> None:
    """Overwrite the bytes of an array in a pickle with new values.

    Parameters
    ----------
    data
        The bytes to change.
    path
        The file, for messages.
    places
        Offsets of the arrays' bytes in the pickle.
    there
        The array as it was read. Its dtype, shape and memory order are kept.
    values
        The new values.
    offset
        Offset of the pickle in `data`.

    Raises
    ------
    NpzError
        If the pickle's protocol is so old that lengths would change.
    """
    start = places.of(there)
    by_column = there.flags.f_contiguous and not there.flags.c_contiguous
    order: Literal["C", "F"] = "F" if by_column else "C"
    raw = there.tobytes(order)
    if start is None or bytes(data[offset + start : offset + start + len(raw)]) != raw:
        raise NpzError(
            f"{path}: expected arrays that can be replaced in place, but the protocol of this "
            "pickle is older than 3: write it again with pickle.dump, or as .npz with "
            "numpy.savez"
        )
    fresh = np.asarray(values, dtype=there.dtype).reshape(there.shape).tobytes(order)
    data[offset + start : offset + start + len(raw)] = fresh


def open_pickle(path: Path, data: bytes) -> PickledDict:
    """Open a pickle of named arrays. Raises NpzError if it has other contents."""
    if instead := wrong_file_kind_message(data, PICKLE):
        raise NpzError(f"{path}: {instead}")
    try:
        names, places = read_pickle_with_offsets(data)
    except LimitError as error:
        raise NpzError(f"{path}: {error}") from None
    except ValueError:
        raise NpzError(f"{path}: expected a complete pickle of arrays") from None
    if not isinstance(names, dict):
        raise NpzError(f"{path}: expected a pickle with a dictionary of named arrays")
    return PickledDict(path, data, names, places)
