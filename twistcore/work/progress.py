"""Report the progress of long work to a function, which may cancel the work."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

TellName = Callable[[str], None]  # called with the name of a finished item
Counter = Callable[[int], AbstractContextManager[TellName]]  # called with the number of items
Tell = Callable[[float], None]  # called with the share done, 0…1; an exception in it ends the work


class Cancelled(BaseException):
    """Raised by a :data:`Tell` function to cancel the work that called it.

    The class is not an Exception, so that no error handler catches it.
    """


def nobody(_share: float) -> None:
    """Ignore the progress."""


def part(tell: Tell, start: float, stop: float) -> Tell:
    """Return a :data:`Tell` for a stage, which maps 0…1 to `start`…`stop` of the whole work."""
    return lambda share: tell(start + share * (stop - start))


@contextmanager
def clip_counter(total: int, done: int = 0) -> Iterator[TellName]:
    """Yield a function to call with the name of each finished clip, which draws a bar.

    The bar is on standard error. If that is not a terminal, a line is printed at every twentieth of
    the clips. `done` is the number of clips that were finished before.
    """
    if sys.stderr.isatty():
        from tqdm import tqdm  # takes 20 ms to load, which most commands can save

        with tqdm(total=total, initial=done, unit="clip", file=sys.stderr) as bar:

            def advance(name: str) -> None:
                bar.set_postfix_str(name, refresh=False)
                bar.update()

            yield advance
        return
    counts, every = itertools.count(done + 1), max(1, total // 20)

    def line(name: str) -> None:
        count = next(counts)
        if count % every == 0 or count == total:
            print(f"{count}/{total} {name}", file=sys.stderr, flush=True)

    yield line


@contextmanager
def uncounted(_total: int) -> Iterator[TellName]:
    """Yield a function that does nothing with the names."""
    yield lambda _name: None
