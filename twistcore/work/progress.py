"""Report the progress of long computations to a function, which may also cancel them."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

TellName = Callable[[str], None]  # called with the name of a finished item
Counter = Callable[[int], AbstractContextManager[TellName]]  # called with the number of items
Tell = Callable[[float], None]  # called with the share done, 0…1; may raise to cancel the work


class Cancelled(BaseException):
    """Raised by a :data:`Tell` function to cancel the work that called it.

    The class is not a subclass of Exception, so that `except Exception` does not catch it.
    """


def ignore_progress(_share: float) -> None:
    """Ignore the progress. This function is the default for parameters of type :data:`Tell`."""


def stage_progress(tell: Tell, start: float, stop: float) -> Tell:
    """Return a :data:`Tell` function for one stage of the work.

    It maps the progress of the stage, 0…1, to `start`…`stop`, and passes it on to `tell`.
    """
    return lambda share: tell(start + share * (stop - start))


@contextmanager
def show_clip_progress_bar(total: int, done: int = 0) -> Iterator[TellName]:
    """Show a progress bar, and yield a function to call with the name of each finished clip.

    The bar is printed on standard error. If this is not a terminal, a line is printed after every
    5 % of the clips instead. `total` is the number of clips, and `done` is the number of clips that
    are already finished.
    """
    if sys.stderr.isatty():
        from tqdm import tqdm  # takes 20 ms to load, and most commands do not need it

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
def silent_clip_progress(_total: int) -> Iterator[TellName]:
    """Yield a function that ignores the names of finished clips."""
    yield lambda _name: None
