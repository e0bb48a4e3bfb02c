"""The processor time of one call: the clock is shared with whatever else runs."""

import time

from twistcore.errors import TwistError

SLOW = 2.0  # seconds: nothing a stranger gives may take longer


def spent(work):
    """What it gave, or its error, and the seconds of processor time."""
    begun = time.process_time()
    try:
        found = work()
    except TwistError as error:
        found = error
    return found, time.process_time() - begun
