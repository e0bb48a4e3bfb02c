"""How far long work is: it tells so now and then, and whoever listens may end it there."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

TellName = Callable[[str], None]  # called with the name of what is through
Counter = Callable[[int], AbstractContextManager[TellName]]  # of so many
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


@contextmanager
def clip_counter(total: int, done: int = 0) -> Iterator[TellName]:
    """To be called with the name of every clip that is through: a bar on standard error.

    Where that is no terminal, a line every twentieth of the way. done: clips before the first.
    """
    if sys.stderr.isatty():
        from tqdm import tqdm  # 20 ms that most commands need not wait

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
    """Counts for nobody."""
    yield lambda _name: None
