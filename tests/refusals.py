"""What tests ask of an error: its class, its fields, names and numbers in it; never its wording."""

from contextlib import contextmanager

import pytest


@contextmanager
def refused(kind, *facts, **fields):
    """An error of that class in one line, which names the facts and has these values of fields."""
    with pytest.raises(kind) as caught:
        yield caught
    assert names_in_one_line(str(caught.value), *facts)
    assert {name: getattr(caught.value, name) for name in fields} == fields


def names_in_one_line(message, *facts):
    """True if all facts, such as names and numbers, are in a message of one line."""
    missing = [fact for fact in facts if fact not in message]
    assert missing == [], f"not in {message!r}"
    return message.count("\n") <= message.endswith("\n")
