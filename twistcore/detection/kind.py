"""The kinds of error. Each kind is declared in a file in `kinds/` that loads without numpy."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, ClassVar

from twistcore.work.frozen import dataclass

KIND_GROUP = "twistcore.kinds"  # the group of entry points for packages that add a kind
_FOLDER = "twistcore.detection.kinds"


@dataclass(frozen=True)
class KindInfo:
    """The description of a kind of error: how it is found, shown and corrected.

    Parameters
    ----------
    name : str
        The name of the kind in files, in tables and for ``--kinds``.
    label : str
        The plural for filters, such as "Lone jumps".
    place : int
        The position of the kind in lists, which are sorted from common to rare kinds.
    repair : str
        The rotation that a correction removes, such as "twist"; "" for a kind that no detector
        corrects.
    automatic : bool
        True if errors of the kind may be corrected without a person's decision.
    sure : float
        The confidence below which a person must decide even if `automatic` is True.
    doubt : str
        The reason for the limit `sure`, as a clause.
    of_capture : bool
        True for a capture fault, which is not a twist error. Rules that make a batch fail count
        such faults only on request.
    whole_body : bool
        True for an error of the whole body, which is shown without the name of a chain.
    sign : str
        How an angle is written: "+" with its sign, "±" without a direction, "" for a kind without
        an angle.
    size : str
        The field in the output of `detect --json` that contains the size of an error.
    weight : float or None
        The weight of the kind in the severity; None for the weight of the segment.
    lasting : bool
        True if all frames of an interval contribute to the severity, even though the interval
        cannot be corrected.
    repairer : str
        The correction of a single joint that only a person can accept: the name of a
        `twistcore.analysis.correction.joint_repairs.JointRepair` as 'package.module:NAME', loaded
        on first use. "" for all other kinds.
    turns : bool
        True if `repairer` rotates the joint by the interval's offset, which a person can then edit.
    below : bool
        True if a person can choose whether the joints below rotated with the error.
    find : str
        The function that finds errors of the kind, as 'package.module:function', loaded on first
        use. It takes a `twistcore.detection.finding.KindSearch` and returns intervals keyed by
        chain name. "" for a kind that the detectors find.
    corrected : bool
        True if errors of the kind are searched for after all automatic corrections.
    quantity : str
        The function that returns the curve that shows why an interval is listed, as
        'package.module:function'. It takes a `KindSearch` and an interval, and returns a
        `twistcore.detection.quantity.Quantity`, or None if the interval has no curve. "" for a kind
        whose errors are visible in the angles of the chain or limb.
    colour : str
        The theme colour of the kind's name in the list of intervals; "" for the text colour.
    counted : str
        The singular for counts; `name` if not given.
    here : str
        The text about an interval while one of its frames is displayed. Placeholders in this and
        the following texts are {frames}, {span}, {size}, {joint} and {angle}.
    named : str
        The text about an interval near the displayed frame.
    legend : str
        The text for the 3D view.
    tip : str
        The tooltip in the list of intervals.
    why : str
        A sentence about the error, which may contain only {joint} and {size}.
    happens : str
        A clause for the name of an error group, such as "{part} jumps". By default, the body part
        and the name of the kind are used.
    offer : str
        A sentence about the effect of accepting the interval, which may contain only {joint} and
        {size}.
    """

    name: str
    label: str
    place: int
    repair: str = ""
    automatic: bool = False
    sure: float = 0.0
    doubt: str = ""
    of_capture: bool = False
    whole_body: bool = False
    sign: str = "+"
    size: str = "delta_deg"
    weight: float | None = None
    lasting: bool = False
    repairer: str = ""
    turns: bool = False
    below: bool = False
    find: str = ""
    corrected: bool = False
    quantity: str = ""
    colour: str = ""
    counted: str = ""
    here: str = ""
    named: str = ""
    legend: str = ""
    tip: str = ""
    why: str = ""
    happens: str = ""
    offer: str = ""


def plural_kind_name(word: str) -> str:
    """Return the plural of a kind's name, such as 'limb flips', 'stretches' and 'frozen frames'."""
    if word.endswith("frames"):
        return word
    return word + ("es" if word.endswith(("ch", "s", "x")) else "s")


class _Kinds(type):
    """The metaclass of Kind, which supports `Kind.LONE_JUMP` and `for kind in Kind`."""

    def __iter__(cls) -> Iterator[Kind]:
        return iter(_known().values())

    def __len__(cls) -> int:
        return len(_known())

    def __getattr__(cls, name: str) -> Any:
        if name.isupper() and name in _known():
            setattr(cls, name, kind := _known()[name])  # cached as an attribute
            return kind
        raise AttributeError(f"type object 'Kind' has no attribute {name!r}")


class Kind(str, metaclass=_Kinds):
    """A kind of error, as a string: its name in files, in tables and for `--kinds`.

    Parameters
    ----------
    value : str
        The name, in upper or lower case, with ``-``, ``_`` or spaces between its words. An unknown
        name, for example in a session file from a later version, creates a kind that is reported
        but never corrected.

    Examples
    --------
    >>> import twistcore as tc
    >>> tc.Kind("Counter_Twist")
    <Kind.COUNTER_TWIST: 'counter-twist'>
    >>> [kind.value for kind in tc.Kind if kind.repairable]
    ['counter-twist', 'carried roll', 'limb flip', 'helper roll']
    >>> tc.Kind("melted wax").known
    False
    """

    COUNTER_TWIST: ClassVar[Kind]
    CARRIED_ROLL: ClassVar[Kind]
    LIMB_FLIP: ClassVar[Kind]
    HELPER_ROLL: ClassVar[Kind]
    LONE_JUMP: ClassVar[Kind]
    STRETCH: ClassVar[Kind]
    TURNED_END: ClassVar[Kind]
    SPIKE: ClassVar[Kind]
    BACKWARD_BEND: ClassVar[Kind]
    JOINT_JUMP: ClassVar[Kind]
    PLACE_JUMP: ClassVar[Kind]
    BODY_STEP: ClassVar[Kind]
    NOISE_BURST: ClassVar[Kind]
    FROZEN: ClassVar[Kind]

    name: str  # such as 'COUNTER_TWIST'; '' for a kind that this version does not know
    info: KindInfo

    def __new__(cls, value: object) -> Kind:
        """Return the kind with the given name. Calls with the same name return the same object."""
        if (kind := _by_word().get(_word(value))) is not None:
            return kind
        if not (isinstance(value, str) and value.strip()):
            raise ValueError(f"{value!r} is not a valid Kind")
        return _unknown(value)

    def __reduce__(self) -> tuple[Any, ...]:
        return Kind, (self.value,)

    def __repr__(self) -> str:
        return f"<Kind{'.' * self.known}{self.name}: {self.value!r}>"

    @property
    def value(self) -> str:
        """The name of the kind in files and tables."""
        return str.__str__(self)

    @property
    def known(self) -> bool:
        """True if this version of the program knows the kind."""
        return bool(self.name)

    @property
    def repairable(self) -> bool:
        """True for a kind of twist error that can be corrected. Summaries count only these."""
        return bool(self.info.repair)

    @property
    def correctable(self) -> bool:
        """True if a correction of this kind exists, even if it is never applied automatically."""
        return bool(self.info.repair or self.info.repairer)

    @property
    def by_angle(self) -> bool:
        """True if a correction rotates a joint by an offset that a person can edit."""
        return bool(self.info.repair) or self.info.turns

    @property
    def built_in(self) -> bool:
        """True if the kind is built in, False if another package provides it."""
        return self.info.find.startswith("twistcore.") or not self.info.find

    @property
    def of_capture(self) -> bool:
        """True for a capture fault, which is not a twist error.

        Rules that make a batch fail count such faults only on request.
        """
        return self.info.of_capture


def _made(name: str, info: KindInfo) -> Kind:
    kind = str.__new__(Kind, info.name)
    kind.name, kind.info = name, info
    return kind


@cache
def _known() -> Mapping[str, Kind]:
    """Return all kinds, keyed by file name in upper case, in the order of `place`."""
    from importlib import import_module
    from pkgutil import iter_modules

    folder = import_module(_FOLDER)
    infos = {
        module.name.upper(): import_module(f"{_FOLDER}.{module.name}").KIND
        for module in iter_modules(folder.__path__)
    }
    infos |= _of_packages({_word(info.name) for info in infos.values()})
    by_place = sorted(infos.items(), key=lambda item: item[1].place)
    return {name: _made(name, info) for name, info in by_place}


def _of_packages(taken: set[str]) -> dict[str, KindInfo]:
    """Return the kinds from installed packages, keyed by entry point name in upper case.

    `taken` contains the names in use. A kind that cannot be loaded, or whose name is in use, is
    skipped with a warning.
    """
    if not _announced():
        return {}
    import warnings
    from importlib.metadata import entry_points  # slow to load

    found: dict[str, KindInfo] = {}
    for point in sorted(entry_points(group=KIND_GROUP), key=lambda p: p.name):
        where = f"the error kind {point.name!r} from {point.value} is ignored"
        try:
            info = point.load()
        except Exception as error:  # an error in another package
            warnings.warn(f"{where}: {type(error).__name__}: {error}", stacklevel=2)
            continue
        name = point.name.upper().replace("-", "_")
        if not isinstance(info, KindInfo):
            warnings.warn(f"{where}: expected a KindInfo, found {info!r:.80}", stacklevel=2)
        elif _word(info.name) in taken or name in found:
            warnings.warn(f"{where}: there is already an error kind {info.name!r}", stacklevel=2)
        else:
            found[name] = info
            taken.add(_word(info.name))
    return found


def _announced() -> bool:
    """Return True if an installed package provides a kind of error.

    This is ten times as fast as a call to `entry_points`.
    """
    for folder in dict.fromkeys(sys.path):
        try:
            inside = [e.path for e in os.scandir(folder or ".") if e.name.endswith("-info")]
        except OSError:
            continue
        for place in inside:
            try:
                with open(os.path.join(place, "entry_points.txt"), "rb") as file:  # noqa: PTH118, PTH123
                    if f"[{KIND_GROUP}]".encode() in file.read():
                        return True
            except OSError:
                continue
    return False


@cache
def _by_word() -> Mapping[str, Kind]:
    return {_word(kind.value): kind for kind in _known().values()}


@cache
def _unknown(value: str) -> Kind:
    word = value.replace("{", "{{").replace("}", "}}")
    return _made("", KindInfo(value, value, 1000, here=word + " {frames}"))


def _word(value: object) -> str:
    return " ".join(str(value).casefold().replace("-", " ").replace("_", " ").split())
