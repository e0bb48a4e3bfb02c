"""Read arrays, lists, dicts, strings and numbers from a pickle without executing anything.

A pickle can name any function to be called, but this module never looks up a name. The few names
that numpy and joblib write for arrays are mapped to classes of this module, and all other names to
an object that ignores all operations. Bytes are converted to arrays without numpy's own unpickling,
which trusts the sizes in the file. The offset of an array's bytes in the file is kept, so that the
array can be replaced by one of the same size.

Because a pickle may refer to a value many times, a few bytes can describe a structure that would
fill any memory or take forever. Therefore, the number of instructions, the depth, and the size of
the contents are limited (:class:`LimitError`). The size includes every use of a value.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.npz.archive import check_array_shape_fits_file

_KINDS = "biuf"  # kinds of dtypes that are plain numbers
_KEY = 1 << 60  # the hash of an integer up to this size is the integer
# Maximum number of characters of a key, because equal keys are compared letter by letter.
_LONGEST_KEY = 4096
_MEMO = 1 << 32  # maximum index in the pickle's memo
_ARGUMENTS = 64  # maximum number of arguments of a call
_AXES = 32
_DTYPE = 16  # maximum number of characters of a type code
_DEEPEST = 100  # maximum depth of nested dicts and lists
_CLASSES = 1000  # maximum number of unsupported classes
# Maximum number of instructions, and of bytes if no value were shared. Each is a constant plus a
# share or a multiple of the pickle's size. Poses of estimators have at least five bytes per
# instruction.
_INSTRUCTIONS, _BYTES_OF_ONE = 2_000_000, 8
_UNSHARED, _TIMES = 1 << 24, 4


class LimitError(ValueError):
    """Raised if a pickle's contents exceed a limit. The message does not include the file name."""


def _too_much(what: str) -> LimitError:
    return LimitError(f"{what}; save its arrays by name with numpy.savez")


class Unreadable:
    """An object of an unsupported class. All operations on it are ignored."""

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

    def __repr__(self) -> str:
        return f"({self.kind})"


_SET = Unreadable()  # replaces all sets, because no known file layout has sets


class _Dtype(Unreadable):
    """A replacement for numpy.dtype that stores a type code and a byte order."""

    def __init__(self, letters: object = "", *_: object) -> None:
        plain = isinstance(letters, str) and len(letters) <= _DTYPE
        self.letters, self.order = str(letters) if plain else "", "="

    def set_state(self, state: Any) -> None:
        self.order = state[1]

    def plain(self) -> np.dtype[Any]:
        """Return the numpy dtype. Raises ValueError if it is not a dtype of plain numbers."""
        found = np.dtype(self.letters)
        if self.order in ("<", ">"):
            found = np.dtype(self.order + found.str[1:])
        if found.kind not in _KINDS or found.subdtype or found.names:
            raise ValueError("an array does not contain plain numbers")
        return found


class _Array(Unreadable):
    """A replacement for numpy.ndarray, which is created empty and filled from the pickled state."""

    value: Any = None

    def set_state(self, state: Any) -> None:
        _, shape, dtype, by_column, data = state
        if isinstance(data, list):  # an array of objects
            self.value = _objects(data, shape)
            return
        self.value = _shaped(data, dtype, shape, "F" if by_column else "C")


class _Inline(Unreadable):
    """joblib's placeholder for an array whose bytes follow in the stream."""

    state: Any = None

    def set_state(self, state: Any) -> None:
        self.state = state

    def read(self, source: io.BytesIO, methods: _Counted) -> Any:
        """Return the array that follows in the stream."""
        shape, dtype = tuple(self.state["shape"]), self.state["dtype"]
        if dtype.letters.startswith("O"):
            return _Reader(source, methods).load()
        if self.state.get("numpy_array_alignment_bytes") is not None:
            source.read(source.read(1)[0])
        count = _count(shape) * dtype.plain().itemsize
        return _shaped(source.read(count), dtype, shape, self.state["order"])


def _as_key(key: Any) -> Any:
    """Return a key if it is a short string or a number, or else a placeholder.

    Tuples are replaced because hashing one takes as long as hashing all of its items, and because a
    file can choose their hashes. Raises UnpicklingError for large integers, because their hashes
    may all be equal, too.
    """
    if isinstance(key, int) and abs(key) > _KEY:
        raise pickle.UnpicklingError("a key is too large")
    short = isinstance(key, str | bytes) and len(key) <= _LONGEST_KEY
    return key if short or isinstance(key, int | float | np.generic | None) else Unreadable()


def _check_arguments(arguments: list[Any]) -> None:
    """Raise UnpicklingError if a call has too many arguments, because they would be copied."""
    if any(len(one) > _ARGUMENTS for one in arguments):
        raise pickle.UnpicklingError("a call has too many arguments")


def _count(shape: tuple[Any, ...]) -> int:
    """Return the number of elements of an array, computed without overflow.

    Raises ValueError if the shape is impossible.
    """
    if len(shape) > _AXES:
        raise ValueError("an array has too many axes")
    out = 1
    for n in shape:
        if not isinstance(n, int) or n < 0:
            raise ValueError("the shape of an array is not a tuple of whole numbers")
        out *= n
    return out


def _shaped(raw: Any, dtype: Any, shape: Any, order: object) -> NDArray[Any]:
    if not isinstance(dtype, _Dtype):
        raise TypeError("an array has no dtype")
    if not isinstance(raw, bytes | bytearray):
        raise TypeError("an array has no bytes")
    shape = tuple(shape)
    plain, count = dtype.plain(), _count(shape)
    check_array_shape_fits_file(shape, len(raw))
    if len(raw) != count * plain.itemsize:
        raise ValueError("the size of an array does not match its shape")
    return np.frombuffer(raw, dtype=plain).reshape(shape, order="F" if order == "F" else "C")


def _objects(items: list[Any], shape: Any) -> Any:
    """Return the items of an array of objects as a list, or the only item if `shape` is empty."""
    return items[0] if not shape and len(items) == 1 else items


def _reconstruct(*_: object) -> _Array:
    return _Array()


def _from_buffer(raw: Any, dtype: Any, shape: Any, order: Any) -> NDArray[Any]:
    return _shaped(raw, dtype, shape, order)


def _scalar(dtype: Any, raw: Any = b"") -> Any:
    short = isinstance(raw, str) and len(raw) <= _DTYPE
    return _shaped(raw.encode("latin1") if short else raw, dtype, (1,), "C")[0]


def _mapping(*_: object) -> dict[Any, Any]:
    return {}


def _empty(*_: object) -> bytes:
    return b""


_CORE = ("numpy.core", "numpy._core")
_NAMES: dict[tuple[str, str], Any] = {
    ("numpy", "dtype"): _Dtype,
    ("joblib.numpy_pickle", "NumpyArrayWrapper"): _Inline,
    ("collections", "defaultdict"): _mapping,
    ("collections", "OrderedDict"): _mapping,
    ("__builtin__", "bytes"): _empty,
    **{(f"{c}.multiarray", "_reconstruct"): _reconstruct for c in _CORE},
    **{(f"{c}.multiarray", "scalar"): _scalar for c in _CORE},
    **{(f"{c}.numeric", "_frombuffer"): _from_buffer for c in _CORE},
}


class Places:
    """Offsets of arrays' bytes in the pickle from which they were read."""

    def __init__(self) -> None:
        # Keyed by the id() of the object that has the bytes.
        self._starts: dict[int, tuple[Any, int]] = {}

    def note(self, held: Any, start: int) -> None:
        """Store `start`, the offset in the pickle of the bytes in the object `held`.

        A reference to `held` is kept, so that its id() stays unique.
        """
        self._starts[id(held)] = held, start

    def of(self, array: NDArray[Any]) -> int | None:
        """Return the offset of an array's first byte, or None if its bytes are not in the file."""
        held: Any = array
        while isinstance(held, np.ndarray):
            held = held.base
        held = held.obj if isinstance(held, memoryview) else held
        found = self._starts.get(id(held))
        return None if found is None else found[1]


class _Counted(dict[int, Any]):
    """A mapping of opcodes to methods that limits the number of look-ups."""

    def __init__(self, methods: Mapping[int, Any], most: int) -> None:
        super().__init__(methods)
        self._left = most

    def __getitem__(self, code: int) -> Any:
        self._left -= 1
        if self._left < 0:
            raise _too_much("the pickle has more objects than a file of its size needs")
        return super().__getitem__(code)


# The base class is the version in Python, because joblib puts bytes between opcodes.
class _Reader(pickle._Unpickler):
    """An unpickler that never looks up names.

    `source` is in memory, so a false length cannot cause large allocations.
    """

    inherited: ClassVar[dict[int, Callable[[Any], None]]] = pickle._Unpickler.dispatch
    dispatch: ClassVar[dict[int, Callable[[Any], None]]] = dict(inherited)
    stack: list[Any]  # load() sets this attribute and the next three
    read: Callable[[int], bytes]
    readline: Callable[[], bytes]
    append: Callable[[Any], None]
    pop_mark: Callable[[], list[Any]]
    memo: dict[int, Any]
    _unframer: Any

    def __init__(self, source: io.BytesIO, methods: _Counted, places: Places | None = None) -> None:
        super().__init__(source)
        self.source, self.places = source, places
        self.dispatch = self._methods = methods  # type: ignore[misc]  # load() uses this attribute
        self._frame = 0  # offset of the current frame
        self._classes: dict[tuple[str, str], type[Unreadable]] = {}
        self._latin: dict[int, tuple[str, bytes]] = {}

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("_codecs", "encode"):  # the first protocols write bytes like this
            return self._encoded
        if known := _NAMES.get((module, name)):
            return known
        if (module, name) not in self._classes:
            if len(self._classes) >= _CLASSES or len(module) + len(name) > _LONGEST_KEY:
                raise _too_much("the pickle refers to too many classes")
            made = type("Unread", (Unreadable,), {"kind": f"{module}.{name}"})
            self._classes[module, name] = made
        return self._classes[module, name]

    def _encoded(self, text: Any, *_: object) -> bytes:
        """Return a string as bytes in Latin-1. Each string is encoded only once."""
        if not isinstance(text, str):
            raise pickle.UnpicklingError("a string is missing")
        if id(text) not in self._latin:
            self._latin[id(text)] = text, text.encode("latin1")
        return self._latin[id(text)][1]

    def _build(self) -> None:
        # The inherited method would set attributes of any object, even of classes.
        state = self.stack.pop()
        made = self.stack[-1]
        if not isinstance(made, Unreadable):
            raise pickle.UnpicklingError("the pickle sets the state of an object that has none")
        if isinstance(made, _Array) and isinstance(state[-1], str):  # written by Python 2
            state = (*state[:4], self._encoded(state[4]))
        made.set_state(state)
        if isinstance(made, _Inline):
            self.stack[-1] = made.read(self.source, self._methods)

    def _bytearray(self) -> None:
        # The inherited method would allocate memory before checking that there are enough bytes.
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
        value = self.stack.pop()
        self._store([self.stack.pop(), value])

    def _setitems(self) -> None:
        self._store(self.pop_mark())

    def _dict(self) -> None:
        items = self.pop_mark()
        self.append({})
        self._store(items)

    def _store(self, items: list[Any]) -> None:
        # The inherited methods would also store in arrays, and could fill a whole array each time.
        held = self.stack[-1]
        if isinstance(held, dict):
            for key, value in zip(items[::2], items[1::2], strict=True):
                held[_as_key(key)] = value
        elif not isinstance(held, Unreadable):
            raise pickle.UnpicklingError("the pickle adds items to an object that has none")

    def _put(self) -> None:
        number = int(self.readline()[:-1])
        if not 0 <= number <= _MEMO:
            raise pickle.UnpicklingError("a memo index is too large")
        self.memo[number] = self.stack[-1]

    def _empty_set(self) -> None:
        self.append(_SET)

    def _frozenset(self) -> None:
        self.pop_mark()
        self.append(_SET)

    def _reduce(self) -> None:
        _check_arguments(self.stack[-1:])
        self.inherited[pickle.REDUCE[0]](self)

    def _newobj(self) -> None:
        _check_arguments(self.stack[-1:])
        self.inherited[pickle.NEWOBJ[0]](self)

    def _newobj_ex(self) -> None:
        _check_arguments(self.stack[-2:])
        self.inherited[pickle.NEWOBJ_EX[0]](self)

    dispatch[pickle.SETITEM[0]] = _setitem
    dispatch[pickle.SETITEMS[0]] = _setitems
    dispatch[pickle.DICT[0]] = _dict
    dispatch[pickle.PUT[0]] = _put
    dispatch[pickle.EMPTY_SET[0]] = _empty_set
    dispatch[pickle.FROZENSET[0]] = _frozenset
    dispatch[pickle.REDUCE[0]] = _reduce
    dispatch[pickle.NEWOBJ[0]] = _newobj
    dispatch[pickle.NEWOBJ_EX[0]] = _newobj_ex
    dispatch[pickle.BUILD[0]] = _build
    dispatch[pickle.BYTEARRAY8[0]] = _bytearray
    dispatch[pickle.FRAME[0]] = _framed
    dispatch[pickle.BINBYTES[0]] = _bytes
    dispatch[pickle.SHORT_BINBYTES[0]] = _short_bytes
    dispatch[pickle.BINBYTES8[0]] = _long_bytes


def read_pickle(data: bytes) -> Any:
    """Return the dicts, lists, strings, numbers and arrays of a pickle or joblib file.

    Tuples and arrays of objects become lists. A zero-dimensional array of objects becomes its only
    item, and an object of any other class becomes :class:`Unreadable`.

    Raises ValueError if the pickle is incomplete, and LimitError if it exceeds a limit.
    """
    return read_pickle_with_offsets(data)[0]


def read_pickle_with_offsets(data: bytes) -> tuple[Any, Places]:
    """Return the contents of a pickle, and the offsets of its arrays' bytes.

    The contents and errors are those of :func:`read_pickle`.
    """
    places = Places()
    methods = _Counted(_Reader.dispatch, _INSTRUCTIONS + len(data) // _BYTES_OF_ONE)
    try:
        found = _Reader(io.BytesIO(data), methods, places).load()
        return _plain(found, _UNSHARED + _TIMES * len(data)), places
    except LimitError:
        raise
    except Exception as error:  # damaged pickles can raise almost anything
        raise ValueError(f"the pickle is incomplete or damaged ({type(error).__name__})") from None


def _plain(found: Any, most: int) -> Any:
    """Return the contents with placeholders replaced by arrays, and tuples by lists.

    Raises LimitError if the contents are nested too deeply, or if the sum of their items and array
    bytes exceeds `most`. The sum includes every use of a value, so a list that contains itself is
    too large.
    """
    # Keyed by id(), with the old object so that its id() stays in use.
    known: dict[int, tuple[Any, Any, int]] = {}

    def one(item: Any, depth: int) -> tuple[Any, int]:
        if isinstance(item, _Array):
            item = item.value
        if isinstance(item, np.ndarray):
            return item, item.nbytes
        if not isinstance(item, dict | list | tuple | _Array):
            return item, 1
        if depth > _DEEPEST:
            raise _too_much("the pickle's dicts and lists are nested too deeply")
        if isinstance(item, _Array):  # an array that contains one array
            return one(item, depth + 1)
        if not item:
            return (item if isinstance(item, dict | list) else []), 1
        if id(item) not in known:
            known[id(item)] = item, item, most + 1  # until its size is known
            made: Any = list(item) if isinstance(item, tuple) else item
            pairs = item.items() if isinstance(item, dict) else enumerate(item)
            size = 1
            for key, value in pairs:
                made[key], more = one(value, depth + 1)
                size += more
                if size > most:
                    raise _too_much("the pickle repeats its values too often or contains itself")
            known[id(item)] = item, made, size
        return known[id(item)][1:]

    return one(found, 0)[0]
