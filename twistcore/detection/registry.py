"""The registry of detectors: built-in, from installed packages, from a file, or from Python code.

The names of detectors come from lists of files and of entry points, so the command line can show
them without loading a detector or numpy. Everything that a table, a menu or a plot shows about a
detector is in its :class:`DetectorInfo`.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from twistcore.detection.guarded import GuardedDetector, exceptions_as_twist_error
from twistcore.detection.protocol import Detector, DetectorInfo
from twistcore.errors import TwistError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

DEFAULT_METHOD = "consistency"
GROUP = "twistcore.detectors"  # the group of entry points for packages that add a detector
# The environment variable with the detector file given to a command with --detector, so that the
# processes that the command starts load the file as well.
FILE_VARIABLE = "TWISTCORE_DETECTOR_FILE"
_FOLDER = "twistcore.detection.detectors"  # one file per detector
_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")


class Detectors(Mapping[str, Detector]):
    """A mapping from names to detectors: first the default, then built-in, then external ones.

    A detector is loaded on first use. Access by name raises KeyError if there is no such detector,
    and TwistError if it cannot be loaded.
    """

    def __init__(self) -> None:
        self._given: dict[str, GuardedDetector] = {}  # registered by a program, or from a file
        self._loaded: dict[tuple[str, str], Detector] = {}  # by name and source

    def __getitem__(self, name: str) -> Detector:
        if name in self._given:
            return self._given[name]
        if name in built_in_detector_names():
            return self._load_once(name, _FOLDER, lambda: _own(name))
        if (point := _entry_points().get(name)) is not None:
            return self._load_once(name, point.value, lambda: _of_package(point))
        if name in self._of_file():
            return self._given[name]
        raise KeyError(name)

    def __contains__(self, name: object) -> bool:
        if name in self._given or name in built_in_detector_names():
            return True
        return isinstance(name, str) and (name in _entry_points() or name in self._of_file())

    def __iter__(self) -> Iterator[str]:
        return iter(
            dict.fromkeys((*built_in_detector_names(), *self._of_file(), *sorted(_entry_points())))
        )

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def named(self, name: str) -> Detector:
        """Return the detector with the given name.

        Raises TwistError with a list of all names if there is no such detector.
        """
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self)
            raise TwistError(f"there is no detector {name!r}; expected one of {known}") from None

    def register(self, detector: Detector, place: str = "") -> Detector:
        """Add a detector, or replace an earlier detector with the same name.

        Returns the guarded detector, which reports failures as a TwistError. `place` is the file
        and class from which the detector was loaded, or ''. Raises TwistError if `detector` is not
        a detector or has the name of a built-in one.
        """
        if isinstance(detector, GuardedDetector):
            return detector
        made = _checked(detector, getattr(detector, "__name__", type(detector).__name__))
        name = made.info.name
        if name in built_in_detector_names():
            if type(made) is type(own := self[name]):
                return own
            raise TwistError(f"{name!r} is the name of a built-in detector")
        kept = self._given.get(name)
        if kept is None or kept.detector is not made:
            kept = self._given[name] = GuardedDetector(made, place)
        return kept

    def load(self, place: str) -> Detector:
        """Load a detector from 'FILE.py:Class', register it, and return the guarded detector.

        Raises TwistError if the detector cannot be loaded.
        """
        path, _, name = place.rpartition(":")
        return self.register(_of_file(place, path, name), f"{Path(path).resolve()}:{name}")

    def place(self, name: str) -> str:
        """Return the file and class from which a detector was loaded, as 'FILE.py:Class'.

        The result is '' if the detector was not loaded from a file.
        """
        return self._given[name].place if name in self._of_file() else ""

    def info(self, name: str) -> DetectorInfo:
        """Return the description of a detector.

        If the detector does not exist or cannot be loaded, the description has only its name.
        """
        try:
            return self[name].info
        except (KeyError, TwistError):
            return DetectorInfo(name, f"the detector {name!r}", "", name)

    def infos(self) -> tuple[DetectorInfo, ...]:
        """Return the descriptions of all detectors that can be loaded."""
        return tuple(self[name].info for name in self.ready())

    def ready(self) -> tuple[str, ...]:
        """Return the names of all detectors that can be loaded."""
        return tuple(name for name in self if self.usable(name) == name)

    def usable(self, name: str) -> str:
        """Return `name` if a detector of that name can be loaded, or the name of the default."""
        try:
            return self[name].info.name
        except (KeyError, TwistError):
            return DEFAULT_METHOD

    def version(self, name: str) -> str:
        """Return a string that changes whenever an external detector changes; '' if built in."""
        if name in built_in_detector_names():
            return ""
        if name in self._of_file():
            path = self.place(name).rpartition(":")[0]
            return _mark_of_file(Path(path)) if path else ""
        point = _entry_points().get(name)
        return "" if point is None or point.dist is None else f"{point.value} {point.dist.version}"

    def _load_once(self, name: str, place: str, load: Callable[[], Detector]) -> Detector:
        if (name, place) not in self._loaded:
            self._loaded[name, place] = load()
        return self._loaded[name, place]

    def _of_file(self) -> dict[str, GuardedDetector]:
        """Return all registered detectors.

        If the environment variable FILE_VARIABLE names a detector, it is loaded first.
        """
        place = os.environ.get(FILE_VARIABLE, "")
        if place and all(d.place != place for d in self._given.values()):
            self.load(place)
        return self._given


DETECTORS = Detectors()


def register(detector: Detector) -> Detector:
    """Register a detector under its name in this process.

    Parameters
    ----------
    detector : Detector
        An object with an attribute `info` and a method `analyse`. An earlier detector with the
        same name is replaced, unless it is built in.

    Returns
    -------
    Detector
        The guarded detector, which the program uses instead of the given object.

    Raises
    ------
    TwistError
        If the object is not a detector, or has the name of a built-in one.
    """
    return DETECTORS.register(detector)


@contextmanager
def register_detector_file(place: str) -> Iterator[str]:
    """Register a detector from 'FILE.py:Class' for a `with` statement, and yield its name.

    Processes that are started within the statement load the detector as well. Raises TwistError if
    the detector cannot be loaded.
    """
    name = DETECTORS.load(place).info.name
    os.environ[FILE_VARIABLE] = DETECTORS.place(name)
    try:
        yield name
    finally:
        del os.environ[FILE_VARIABLE]


@cache
def built_in_detector_names() -> tuple[str, ...]:
    """Return the names of the built-in detectors (their file names), the default first."""
    from pkgutil import iter_modules

    folder = [
        str(Path(place) / "detectors") for place in sys.modules["twistcore.detection"].__path__
    ]
    names = sorted(module.name for module in iter_modules(folder))
    return tuple(sorted(names, key=lambda name: name != DEFAULT_METHOD))


def _own(name: str) -> Detector:
    from importlib import import_module

    detector: Detector = import_module(f"{_FOLDER}.{name}").DETECTOR
    return detector


def _entry_points() -> Mapping[str, EntryPoint]:
    return _entry_points_on(tuple(sys.path))


@lru_cache(4)
def _entry_points_on(_path: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    """Return the entry points of detectors in installed packages, keyed by name.

    The argument is `sys.path`, which is the cache key. No detector is loaded.
    """
    from importlib.metadata import entry_points  # takes 20 ms, and few commands need it

    return {p.name: p for p in entry_points(group=GROUP) if p.name not in built_in_detector_names()}


def _of_package(point: EntryPoint) -> Detector:
    package = point.dist.name if point.dist is not None else point.module
    where = f"the detector {point.name!r} of the package {package}"
    with exceptions_as_twist_error(f"{where} cannot be loaded"):
        found = point.load()
    made = _checked(found, where)
    if made.info.name != point.name:
        raise TwistError(
            f"{where}: expected the detector's info to contain the same name, "
            f"found {made.info.name!r}"
        )
    return GuardedDetector(made)


def _of_file(place: str, path: str, name: str) -> Detector:
    if not (path.endswith(".py") and name.isidentifier()):
        raise TwistError(f"{place}: expected a detector as FILE.py:Class")
    if not Path(path).is_file():
        raise TwistError(
            f"{path}: expected a Python file with a detector, but the file does not exist"
        )
    with exceptions_as_twist_error(f"{path}: the detector cannot be loaded"):
        found = getattr(_module(Path(path).resolve()), name, None)
    if found is None:
        raise TwistError(f"{path}: expected a class {name}, but the file has none")
    return _checked(found, f"{path}: {name}")


def _module(path: Path) -> ModuleType:
    """Load a Python file and return its module."""
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location(f"detector_file_{_mark_of_file(path)[:16]}", path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses need to find their module
    spec.loader.exec_module(module)
    return module


def _mark_of_file(path: Path) -> str:
    from hashlib import sha256  # slow to load; few commands need it

    return sha256(path.read_bytes()).hexdigest()


def _checked(found: Any, where: str) -> Detector:
    """Check a detector and return it. If a class is given, return an instance of the class.

    `where` describes the detector in error messages. Raises TwistError if the object is not a
    detector; the message names the missing part.
    """
    if isinstance(found, type):
        with exceptions_as_twist_error(f"{where} cannot be created"):
            found = found()
    info = getattr(found, "info", None)
    if not isinstance(info, DetectorInfo):
        raise TwistError(f"{where} is not a detector: expected `info`, a DetectorInfo")
    if not callable(getattr(found, "analyse", None)):
        raise TwistError(
            f"{where} is not a detector: expected a method analyse(motion, chains, tell)"
        )
    if not _NAME.fullmatch(info.name):
        raise TwistError(
            f"{where}: expected a name of lower-case letters, digits, '-' and '_', found "
            f"{info.name!r}"
        )
    detector: Detector = found
    return detector
