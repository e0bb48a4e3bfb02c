"""Frozen dataclasses of our own decorator are as those of the standard library."""

import copy
import dataclasses
import inspect
import pickle
from dataclasses import FrozenInstanceError, asdict, field, fields, replace
from typing import ClassVar

import pytest

from twistcore.work import frozen


def three_of(decorated):
    """The same three classes by a decorator."""

    @decorated(frozen=True)
    class Point:
        unit: ClassVar[str] = "cm"

        x: float
        y: float = 0.0
        tags: list[str] = field(default_factory=list, compare=False)
        seen: dict[str, int] = field(default_factory=dict, repr=False, hash=False)

    @decorated(frozen=True, kw_only=True)
    class Place(Point):
        name: str
        height: float = 1.0

    @decorated(frozen=True, eq=False, repr=False)
    class Single:
        value: object = None

        def __repr__(self) -> str:
            return "<single>"

    return Point, Place, Single


BOTH = tuple(zip(three_of(frozen.dataclass), three_of(dataclasses.dataclass), strict=True))


@frozen.dataclass(frozen=True)
class Kept:
    """At the module's level, so that it can be pickled."""

    name: str
    parts: tuple[int, ...] = ()


@pytest.mark.parametrize(("ours", "usual"), BOTH)
def test_the_class_is_the_same_to_see(ours, usual):
    assert str(inspect.signature(ours)) == str(inspect.signature(usual))
    assert [(f.name, f.type, f.default) for f in fields(ours)] == [
        (f.name, f.type, f.default) for f in fields(usual)
    ]
    assert ours.__match_args__ == usual.__match_args__
    assert ours.__init__.__qualname__ == usual.__init__.__qualname__


@pytest.mark.parametrize("kind", [0, 1])
def test_objects_are_made_shown_and_compared_the_same(kind):
    point, place, single = (pair[kind] for pair in BOTH)
    one = place(1.0, name="hand")
    assert repr(one).endswith("Place(x=1.0, y=0.0, tags=[], name='hand', height=1.0)")
    assert one == place(1.0, 0.0, ["left"], name="hand")
    assert one != place(1.0, name="foot")
    assert hash(one) == hash(place(1.0, 0.0, ["left"], {"a": 1}, name="hand"))
    assert one != point(1.0)
    assert replace(one, y=2.0).y == 2.0
    assert asdict(point(1.0)) == {"x": 1.0, "y": 0.0, "tags": [], "seen": {}}
    assert point(1.0).tags is not point(1.0).tags
    assert repr(single(3)) == "<single>"
    assert single(3) != single(3)
    assert len({single(3), single(3)}) == 2
    with pytest.raises(TypeError):
        place(1.0)
    with pytest.raises(TypeError):
        point(1.0, colour="red")


@pytest.mark.parametrize("kind", [0, 1])
def test_nothing_is_changed_afterwards(kind):
    point = BOTH[0][kind]
    one = point(1.0)
    for change in (lambda: setattr(one, "x", 2.0), lambda: setattr(one, "new", 2.0)):
        with pytest.raises(FrozenInstanceError, match="cannot assign to field"):
            change()
    with pytest.raises(FrozenInstanceError, match="cannot delete field 'x'"):
        del one.x

    class Looser(point):
        """No dataclass itself."""

    other = Looser(1.0)
    other.new = 2.0
    with pytest.raises(FrozenInstanceError):
        other.x = 2.0


def test_copies_and_pickles_are_equal():
    one = Kept("hand", (1, 2))
    assert pickle.loads(pickle.dumps(one)) == copy.deepcopy(one) == one
    match one:
        case Kept("hand", parts):
            assert parts == (1, 2)


def test_only_frozen_classes_are_made():
    with pytest.raises(TypeError, match="expected frozen=True"):
        frozen.dataclass(frozen=False)
