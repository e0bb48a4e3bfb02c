"""How far long work is: it tells so now and then, and whoever listens may end it there."""

from __future__ import annotations

from collections.abc import Callable

Tell = Callable[[float], None]  # called with the share that is done, 0…1; what it raises ends it


class Cancelled(BaseException):
    """Raised by a :data:`Tell` to end the work that called it.

    No error, and so not an Exception: nothing that deals with errors on the way takes it for one.
    """


def nobody(_share: float) -> None:
    """Tells nobody how far it is."""


def part(tell: Tell, start: float, stop: float) -> Tell:
    """For a stage of the work: its shares 0…1 are told as `start`…`stop` of the whole."""
    return lambda share: tell(start + share * (stop - start))
