"""Read arrays, lists, dicts, strings and numbers from a pickle without executing anything.

A pickle can name any function to be called, so this module never looks up a name. The few names
that numpy and joblib write for arrays are mapped to classes of this module, and all other names to
an object that ignores all operations. Bytes are converted to arrays of plain numbers by this module
and not by numpy's unpickling, which allocates as much memory as the file demands. The position of
the bytes in the file is stored. With it, an array can be replaced by one of equal size without
writing the pickle again.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.npz.archive import check_shape

_KINDS = "biuf"  # dtypes that are plain numbers
_KEY = 1 << 60  # an integer up to this size is its own hash


class Unreadable:
    """An object of an unsupported class, which ignores all operations."""

    kind = "object"

    def __new__(cls, *_: object, **__: object) -> Unreadable:
        """Create the object, ignoring all arguments."""
        return super().__new__(cls)

    def __init__(self, *_: object, **__: object) -> None:
        pass

    def set_state(self, state: Any) -> None:
        """Ignore the state."""

    def append(self, item: Any) -> None:
        """Ignore the item."""

    def extend(self, items: Any) -> None:
        """Ignore the items."""

    def add(self, item: Any) -> None:
        """Ignore the item."""

    def __setitem__(self, key: Any, value: Any) -> None:
        pass


class _Dtype(Unreadable):
    """A replacement for numpy.dtype that stores a type code and a byte order."""

    def __init__(self, letters: object = "", *_: object) -> None:
        self.letters, self.order = str(letters), "="

    def set_state(self, state: Any) -> None:
        self.order = str(state[1])

    def plain(self) -> np.dtype[Any]:
        """Return the numpy dtype. Raises ValueError unless it is a dtype of plain numbers."""
        found = np.dtype(self.letters)
        if self.order in ("<", ">"):
            found = np.dtype(self.order + found.str[1:])
        if found.kind not in _KINDS or found.subdtype or found.names:
            raise ValueError("an array does not contain plain numbers")
        return found


class _Array(Unreadable):
    """A replacement for numpy.ndarray, which is created empty before its state is set."""

    value: Any = None

    def set_state(self, state: Any) -> None:
        _, shape, dtype, by_column, data = state
        if isinstance(data, list):  # objects
            self.value = _objects(data, shape)
            return
        raw = data.encode("latin1") if isinstance(data, str) else data
        self.value = _shaped(raw, dtype, shape, "F" if by_column else "C")


class _Inline(Unreadable):
    """A placeholder that joblib writes for an array whose bytes follow in the stream."""

    state: Any = None

    def set_state(self, state: Any) -> None:
        self.state = state

    def read(self, source: io.BytesIO) -> Any:
        """Return the array that follows in the stream."""
        shape, dtype = tuple(self.state["shape"]), self.state["dtype"]
        if dtype.letters.startswith("O"):
            return _Reader(source).load()
        if self.state.get("numpy_array_alignment_bytes") is not None:
            source.read(source.read(1)[0])
        count = _count(shape) * dtype.plain().itemsize
        return _shaped(source.read(count), dtype, shape, self.state["order"])


def _check_keys(keys: list[Any]) -> None:
    """Raise UnpicklingError for large integer keys, which might all have the same hash."""
    if any(isinstance(key, int) and abs(key) > _KEY for key in keys):
        raise pickle.UnpicklingError("a key is too large")


def _count(shape: tuple[Any, ...]) -> int:
    """Return the number of elements, computed with Python integers, which cannot overflow."""
    out = 1
    for n in shape:
        if not isinstance(n, int) or n < 0:
            raise ValueError("the shape of an array is not a tuple of whole numbers")
        out *= n
    return out


def _shaped(raw: Any, dtype: Any, shape: Any, order: str) -> NDArray[Any]:
    if not isinstance(dtype, _Dtype):
        raise TypeError("an array has no dtype")
    shape = tuple(shape)
    plain, count = dtype.plain(), _count(shape)
    check_shape(shape, len(raw))
    if len(raw) != count * plain.itemsize:
        raise ValueError("the size of an array does not match its shape")
    return np.frombuffer(raw, dtype=plain).reshape(shape, order="F" if order == "F" else "C")


def _objects(items: list[Any], shape: Any) -> Any:
    """Return the items of an object array as a list, or the only item if it has no dimensions."""
    return items[0] if not shape and len(items) == 1 else items


def _reconstruct(*_: object) -> _Array:
    return _Array()


def _from_buffer(raw: Any, dtype: Any, shape: Any, order: Any) -> NDArray[Any]:
    return _shaped(raw if isinstance(raw, bytearray) else bytes(raw), dtype, shape, str(order))


def _scalar(dtype: Any, raw: Any = b"") -> Any:
    return _shaped(raw.encode("latin1") if isinstance(raw, str) else raw, dtype, (1,), "C")[0]


def _mapping(*_: object) -> dict[Any, Any]:
    return {}


def _empty(*_: object) -> bytes:
    return b""


def _latin(text: Any, *_: object) -> bytes:
    return str(text).encode("latin1")


_CORE = ("numpy.core", "numpy._core")
_NAMES: dict[tuple[str, str], Any] = {
    ("numpy", "dtype"): _Dtype,
    ("joblib.numpy_pickle", "NumpyArrayWrapper"): _Inline,
    ("collections", "defaultdict"): _mapping,
    ("collections", "OrderedDict"): _mapping,
    ("_codecs", "encode"): _latin,  # the form of bytes in the first protocols
    ("__builtin__", "bytes"): _empty,
    **{(f"{c}.multiarray", "_reconstruct"): _reconstruct for c in _CORE},
    **{(f"{c}.multiarray", "scalar"): _scalar for c in _CORE},
    **{(f"{c}.numeric", "_frombuffer"): _from_buffer for c in _CORE},
}


class Places:
    """Offsets of the arrays' bytes in the pickle from which they were read."""

    def __init__(self) -> None:
        self._starts: dict[int, tuple[Any, int]] = {}  # keyed by id() of the object with the bytes

    def note(self, held: Any, start: int) -> None:
        """Store the offset of some bytes, and keep `held` alive so that its id() stays unique."""
        self._starts[id(held)] = held, start

    def of(self, array: NDArray[Any]) -> int | None:
        """Return the offset of an array's first byte, or None if its bytes are not in the file."""
        held: Any = array
        while isinstance(held, np.ndarray):
            held = held.base
        held = held.obj if isinstance(held, memoryview) else held
        found = self._starts.get(id(held))
        return None if found is None else found[1]


class _Reader(pickle._Unpickler):  # written in Python, as joblib puts bytes between opcodes
    """An unpickler that never looks up a name.

    `source` is in memory, so a false length cannot cause more memory to be allocated.
    """

    inherited: ClassVar[dict[int, Callable[[Any], None]]] = pickle._Unpickler.dispatch
    dispatch: ClassVar[dict[int, Callable[[Any], None]]] = dict(inherited)
    stack: list[Any]  # the next three attributes are set by load()
    read: Callable[[int], bytes]
    append: Callable[[Any], None]
    _unframer: Any

    def __init__(self, source: io.BytesIO, places: Places | None = None) -> None:
        super().__init__(source)
        self.source, self.places = source, places
        self._frame = 0  # offset of the frame being read

    def find_class(self, module: str, name: str) -> Any:
        known = _NAMES.get((module, name))
        return known or type("Unread", (Unreadable,), {"kind": f"{module}.{name}"})

    def _build(self) -> None:
        # The inherited method sets attributes of any object, even of classes.
        state = self.stack.pop()
        made = self.stack[-1]
        if not isinstance(made, Unreadable):
            raise pickle.UnpicklingError("a state for an object that cannot have a state")
        made.set_state(state)
        if isinstance(made, _Inline):
            self.stack[-1] = made.read(self.source)

    def _bytearray(self) -> None:
        # The inherited method allocates memory before it checks for the bytes.
        size = int.from_bytes(self.read(8), "little")
        raw = self.read(size)
        if len(raw) != size:
            raise pickle.UnpicklingError("bytes of an array are missing")
        self.append(bytearray(raw))
        self._note_place()

    def _framed(self) -> None:
        self.inherited[pickle.FRAME[0]](self)
        self._frame = self.source.tell() - len(self._unframer.current_frame.getbuffer())

    def _bytes(self) -> None:
        self.inherited[pickle.BINBYTES[0]](self)
        self._note_place()

    def _short_bytes(self) -> None:
        self.inherited[pickle.SHORT_BINBYTES[0]](self)
        self._note_place()

    def _long_bytes(self) -> None:
        self.inherited[pickle.BINBYTES8[0]](self)
        self._note_place()

    def _note_place(self) -> None:
        """Store the offset of the bytes that were just read."""
        if self.places is None:
            return
        frame, held = self._unframer.current_frame, self.stack[-1]
        end = self.source.tell() if frame is None else self._frame + frame.tell()
        self.places.note(held, end - len(held))

    def _setitem(self) -> None:
        _check_keys(self.stack[-2:-1])
        self.inherited[pickle.SETITEM[0]](self)

    def _setitems(self) -> None:
        _check_keys(self.stack[::2])
        self.inherited[pickle.SETITEMS[0]](self)

    def _dict(self) -> None:
        _check_keys(self.stack[::2])
        self.inherited[pickle.DICT[0]](self)

    dispatch[pickle.SETITEM[0]] = _setitem
    dispatch[pickle.SETITEMS[0]] = _setitems
    dispatch[pickle.DICT[0]] = _dict
    dispatch[pickle.BUILD[0]] = _build
    dispatch[pickle.BYTEARRAY8[0]] = _bytearray
    dispatch[pickle.FRAME[0]] = _framed
    dispatch[pickle.BINBYTES[0]] = _bytes
    dispatch[pickle.SHORT_BINBYTES[0]] = _short_bytes
    dispatch[pickle.BINBYTES8[0]] = _long_bytes


def read_pickle(data: bytes) -> Any:
    """Return the dicts, lists, tuples, strings, numbers and arrays in a pickle or joblib file.

    Arrays of objects become lists, an array of objects without dimensions becomes its object, and
    any other object becomes :class:`Unreadable`. Raises ValueError if the pickle is incomplete.
    """
    return read_pickle_places(data)[0]


def read_pickle_places(data: bytes) -> tuple[Any, Places]:
    """Return the contents of a pickle, and the offsets of its arrays' bytes."""
    places = Places()
    try:
        return _plain(_Reader(io.BytesIO(data), places).load()), places
    except Exception as error:  # damaged pickles can raise almost anything
        raise ValueError(f"the pickle is incomplete or damaged ({type(error).__name__})") from None


def _plain(found: Any) -> Any:
    """Return the contents, with placeholders in dicts and lists replaced by their arrays."""
    seen: dict[int, Any] = {}
    todo: list[tuple[Any, Any, Any]] = []

    def one(item: Any) -> Any:
        if isinstance(item, _Array):
            return one(item.value) if not isinstance(item.value, np.ndarray) else item.value
        if isinstance(item, dict | list | tuple):
            if id(item) not in seen:
                made: Any = dict.fromkeys(item) if isinstance(item, dict) else [None] * len(item)
                seen[id(item)] = made
                pairs = item.items() if isinstance(item, dict) else enumerate(item)
                todo.extend((made, key, value) for key, value in pairs)
            return seen[id(item)]
        return item

    out = one(found)
    while todo:
        holder, key, value = todo.pop()
        holder[key] = one(value)
    return out
