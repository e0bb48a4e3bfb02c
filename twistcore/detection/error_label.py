"""The label of an error: the label of its chain, or 'Whole body'."""

from __future__ import annotations

from twistcore.detection.interval import Interval
from twistcore.skeleton.chain import Chain

WHOLE_BODY = "Whole body"


def error_label(interval: Interval, chain: Chain, *, listed: bool = False) -> str:
    """Return the label that tells a person where an error is.

    Files name the chain in which an error was found. For an error of the whole body, this is the
    first chain, so the label is 'Whole body' instead.

    Parameters
    ----------
    interval
        The error.
    chain
        The chain in which it was found.
    listed
        True for a list that contains chains and limbs.
    """
    if interval.kind.info.whole_body:
        return f"{chain.person} · {WHOLE_BODY}" if chain.person else WHOLE_BODY
    return chain.list_label if listed else chain.label
