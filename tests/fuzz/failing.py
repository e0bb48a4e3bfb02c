"""Kinds that fail, each in its way, so that a trial is known to see it."""

from __future__ import annotations

import ctypes
import random
import time
from collections.abc import Callable
from pathlib import Path

from tests.fuzz.trial import Kind
from twistcore.errors import TwistError


def _make(rng: random.Random) -> dict[str, bytes]:
    return {"a": bytes([rng.randrange(256)])}


def _every_third(fail: Callable[[], object]) -> Callable[[Path], object]:
    """Case 1 of 0, 1, 2 fails; the folder's name is the number of the case."""
    return lambda folder: fail() if int(folder.name) % 3 == 1 else (folder / "a").read_bytes()


def _raise(error: Exception) -> None:
    raise error


def _unclosed() -> None:
    Path(__file__).open("rb")  # noqa: SIM115


KINDS = (
    Kind("failing-refused", _make, _every_third(lambda: _raise(TwistError("a: expected b")))),
    Kind("failing-traceback", _make, _every_third(lambda: {}["x"])),
    Kind("failing-unclosed", _make, _every_third(_unclosed)),
    Kind("failing-unworded", _make, _every_third(lambda: _raise(TwistError("a\nb")))),
    Kind("failing-large", _make, _every_third(lambda: (b"x" * (200 << 20)).count(b"y"))),
    Kind("failing-no-memory", _make, _every_third(lambda: bytearray(8 << 30))),
    Kind("failing-hung", _make, _every_third(lambda: time.sleep(60))),
    Kind("failing-ended", _make, _every_third(lambda: ctypes.string_at(0))),
)
