"""Create frozen dataclasses in a third of the usual time.

For every frozen dataclass, the standard library generates and compiles five functions, which takes
half a millisecond. With a hundred classes, this added 40 ms to the start of a command. This module
compiles only `__init__`, and all classes share the functions that implement `repr` and prevent
changes. As with ordinary dataclasses, fields, `replace`, `asdict`, signatures, annotations and
pattern matching work. Subclasses must use this decorator, too.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

__all__ = ["dataclass"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, *, frozen, eq=True, repr=True, kw_only=False):
        """Make a class a frozen dataclass. See :func:`dataclasses.dataclass`."""
        if not frozen:
            raise TypeError("expected frozen=True; dataclasses.dataclass makes other classes")

        def made(cls):
            return _made(cls, eq=eq, shown=repr, kw_only=kw_only)

        return made if cls is None else made(cls)


class _Factory:
    """The default value shown in signatures for a field with a default factory."""

    def __repr__(self) -> str:
        return "<factory>"


_FACTORY = _Factory()


def _made(cls: type, *, eq: bool, shown: bool, kw_only: bool) -> type:
    if hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__}: expected no __post_init__; use dataclasses.dataclass")
    own = frozenset(vars(cls))  # methods that the class itself defines are kept
    dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)
    added: dict[str, Any] = {"__setattr__": _refuse_to_set, "__delattr__": _refuse_to_delete}
    added["__init__"] = _init(cls)
    if shown:
        added["__repr__"] = _repr
    if eq:
        compared = [f for f in dataclasses.fields(cls) if f.compare]
        added["__eq__"] = _eq(_values(tuple(f.name for f in compared)))
        hashed = tuple(f.name for f in compared if f.hash is not False)
        added["__hash__"] = _hash(_values(hashed))
    for name, value in added.items():
        explicit = name in own and not (name == "__hash__" and vars(cls)[name] is None)
        if not explicit:
            setattr(cls, name, value)
    return cls


def _init(cls: type) -> Callable[..., None]:
    """Compile `__init__` with the fields in order of definition, but keyword-only fields last."""
    scope: dict[str, Any] = {"_set": object.__setattr__, "_made": _FACTORY}
    places, lines = ["self"], []
    keywords: list[str] = []
    annotations: dict[str, Any] = {}
    for f in dataclasses.fields(cls):
        word, value = f.name, f.name
        if f.default is not dataclasses.MISSING:
            word += f"=_of_{f.name}"
            scope[f"_of_{f.name}"] = f.default
        elif f.default_factory is not dataclasses.MISSING:
            word += "=_made"
            value = f"_of_{f.name}() if {f.name} is _made else {f.name}"
            scope[f"_of_{f.name}"] = f.default_factory
        if f.init:
            (keywords if f.kw_only else places).append(word)
        else:
            value = f"_of_{f.name}()" if value != f.name else f"_of_{f.name}"
        lines.append(f" _set(self, {f.name!r}, {value})")
        if f.init:
            annotations[f.name] = f.type
    words = ", ".join([*places, *(["*", *keywords] if keywords else [])])
    exec("\n".join([f"def __init__({words}):", *lines, " return"]), scope)
    init: Callable[..., None] = scope["__init__"]
    init.__annotations__ = annotations | {"return": None}
    init.__qualname__ = f"{cls.__qualname__}.__init__"
    init.__module__ = cls.__module__
    return init


def _values(names: tuple[str, ...]) -> Callable[[object], tuple[object, ...]]:
    """Return a function that takes an object and returns the values of the named fields."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda one: tuple(getattr(one, name) for name in names)


def _eq(values: Callable[[object], tuple[object, ...]]) -> Callable[[object, object], bool]:
    def equal(self: object, other: object) -> bool:
        return values(self) == values(other) if type(other) is type(self) else NotImplemented

    return equal


def _hash(values: Callable[[object], tuple[object, ...]]) -> Callable[[object], int]:
    return lambda self: hash(values(self))


@recursive_repr()
def _repr(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _refuse_to_set(self: Any, name: str, value: object) -> None:
    if _is_frozen(self, name):
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
    object.__setattr__(self, name, value)


def _refuse_to_delete(self: Any, name: str) -> None:
    if _is_frozen(self, name):
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
    object.__delattr__(self, name)


def _is_frozen(self: Any, name: str) -> bool:
    """Return True if an attribute of an object cannot be set.

    In a dataclass, no attribute can be set. In a subclass that is not a dataclass, only the
    inherited fields cannot be set.
    """
    return "__dataclass_fields__" in vars(type(self)) or name in self.__dataclass_fields__
