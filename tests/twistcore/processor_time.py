"""Processor time compared with processor time: it does not matter how fast a machine is.

The clock is shared with all that runs; a number of seconds is right on one machine only.
"""

import gc
import time

from twistcore.errors import TwistError

_PARTS = 4  # a size is compared with a quarter of it
_GROWTH = 8.0  # half-way between growing with the size, 4 times, and with its square, 16 times
_TRIES = 3  # another program may have slowed one of two down
_LEAST = 0.01  # seconds that anything may take


def spent(work):
    """What it gave, or its error, and the seconds of processor time.

    Garbage is not collected meanwhile: behind thousands of tests that takes longer than the work.
    """
    gc.disable()
    begun = time.process_time()
    try:
        found = work()
    except TwistError as error:
        found = error
    finally:
        gc.enable()
    return found, time.process_time() - begun


def grown(make, work, size):
    """Work on what is made of this size; its result. It may take the time that its size allows.

    That is compared with the time for a quarter of the size.
    """
    whole, part = make(size), make(size // _PARTS)
    for _ in range(_TRIES):
        few = min(spent(lambda: work(part))[1] for _ in range(2))
        found, many = spent(lambda: work(whole))
        if many <= _GROWTH * max(few, _LEAST):
            return found
    raise AssertionError(f"{many:.2f} s for size {size}, {few:.2f} s for a quarter of it")


def compared(work, usual, most):
    """Work and return the result; it may take so many times as long as what is usual."""
    for _ in range(_TRIES):
        least = min(spent(usual)[1] for _ in range(3))
        found, seconds = spent(work)
        if seconds <= most * max(least, _LEAST):
            return found
    raise AssertionError(f"{seconds:.2f} s, and {least:.2f} s for what is usual")
