"""What tests ask of a message: names and numbers in it, fields of an error; never its wording."""

import re
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
    missing = [fact for fact in facts if str(fact) not in message]
    assert missing == [], f"not in {message!r}"
    return message.count("\n") <= message.endswith("\n")


def numbers(message):
    """All numbers of a message in their order, except those in paths."""
    without_paths = re.sub(r"(?<!\S)/\S+", "", message)
    return [float(found) for found in re.findall(r"\d+(?:\.\d+)?", without_paths)]
