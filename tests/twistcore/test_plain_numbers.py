"""Plain numbers are read thousands at a time, exactly; what is not plain is left to others.

The reader falls back where this declines, so that it would not be seen if it always did.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from twistcore.formats.bvh.plain_numbers import parse_plain_numbers

plain = st.from_regex(r"-?[0-9]{1,4}(\.[0-9]{1,11})?|-?\.[0-9]{1,11}", fullmatch=True)
gaps = st.sampled_from([" ", "\n", "\r\n", "\t", "  ", "\v", "\f"])


def read(text):
    found = parse_plain_numbers(np.frombuffer(text.encode(), dtype=np.uint8))
    return found and (found[0].tolist(), found[1].tolist())


def expected(text):
    """Values by float(), and the last place of each number."""
    values, ends, at = [], [], 0
    for token in text.split():
        at = text.index(token, at) + len(token)
        values.append(float(token))
        ends.append(at - 1)
    return values, ends


@settings(max_examples=examples(200))
@given(st.lists(st.tuples(plain, gaps), min_size=1, max_size=40))
def test_plain_numbers_are_read_with_their_ends(tokens):
    text = "".join(t + gap for t, gap in tokens)
    assert read(text) == expected(text)
    assert read("\n " + text) == expected("\n " + text)


@pytest.mark.parametrize("decimals", range(12))
@pytest.mark.parametrize("whole", range(5))
def test_numbers_of_every_length_are_plain_alone_and_among_others(whole, decimals):
    if whole + decimals == 0:
        return
    digits = "".join(
        str(d) for d in np.random.default_rng(whole + 9 * decimals).integers(0, 10, 15)
    )
    token = digits[:whole] + ("." + digits[4 : 4 + decimals] if decimals else "")
    for text in (
        f"{token} ",
        f"-{token}\n",
        f"{token} -{token} {token} ",
        f"1.25 {token}\t-7 0.5\n",
    ):
        assert read(text) == expected(text)


@pytest.mark.parametrize(
    "token",
    ["12345", "-12345.5", "0.123456789012", "+1.5", "1e5", "1.5E3", "5.", "-5.", ".", "-", "-.",
     "1.2.3", "1-2", "--1", "1.-2", "1..2", "nan", "1_0", "1,5", "1\x002", "1\x0e2", "1\x08", "1/2",
     "1:2", "\xb2"],
)  # fmt: skip
@pytest.mark.parametrize("place", [0, 2, 4])
def test_what_is_not_plain_is_declined(token, place):
    tokens = ["1.25", "-7.50", "0.00", "99.75"]
    tokens.insert(place, token)
    assert read(" ".join(tokens) + " ") is None
    assert read("\n".join(["1", "-2.5", "3.125", token]) + "\n") is None


def test_places_of_numbers_are_those_of_the_block():
    block = np.frombuffer(b"  1.5\t-22.25\r\n3 ", dtype=np.uint8)
    values, ends = parse_plain_numbers(block)
    assert values.tolist() == [1.5, -22.25, 3.0]
    assert ends.tolist() == [4, 11, 14]
    assert values.dtype == np.float64
