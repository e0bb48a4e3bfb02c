"""What a document holds is looked at before anything is made of it."""

import json

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.messages import refused
from tests.tiers import parametrize
from tests.twistcore.reviews import CLIP, fresh
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.errors import FormatError, TwistError
from twistcore.files import document_values as values
from twistcore.review import read_session, replay_journal
from twistcore.review.left_out import joined_spans, uncovered_parts
from twistcore.review.replay import check_session_fits_clip
from twistcore.review.session import session_bytes, session_from_document
from twistcore.skeleton.rig import read_rig
from twistcore.synthesis.truth import read_truth
from twistcore.tuning.profile import read_profile

ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)
LOOKS = [
    values.check_string,
    values.check_path_string,
    values.check_bool,
    values.check_number,
    values.check_positive_number,
    values.check_integer,
    values.check_list,
    values.check_string_list,
    lambda value, what: values.check_choice(value, what, ("a", "b")),
    lambda value, what: values.check_keys(value, "a", what=what),
    lambda value, what: values.read_each(value, what, lambda one: values.check_integer(one, "one")),
    lambda value, what: values.read_frame_span({what: value, "start": value, "stop": 5}),
]


@parametrize("look", LOOKS, quick=4)
@given(value=ANYTHING)
@example(value=[[None] * 4, *[dict.fromkeys(("\U0002fa1e" * 9, "1" * 50), -(10**30))] * 3])
def test_anything_is_what_was_expected_or_told_in_a_short_sentence(look, value):
    told = ""
    try:
        look(value, "here")
    except FormatError as error:
        told = str(error)
    assert not told or told.isprintable()
    assert len(told) < 400


@pytest.mark.parametrize("value", [True, "1", None, float("nan"), float("inf"), 10**400, [1.0]])
def test_what_is_no_finite_number_is_none(value):
    for look in (values.check_number, values.check_positive_number):
        with refused(FormatError, "fps"):
            look(value, "fps")


@pytest.mark.parametrize("value", [True, 1.0, "1", None, -1, 2**60, 10**400])
def test_what_is_no_whole_number_is_none(value):
    with refused(FormatError, "next_id"):
        values.check_integer(value, "next_id")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("NaN", "NaN"),
        ("[1, -2e999]", "-2e999"),
        ("[1, -Infinity]", "-Infinity"),
        ("9" * 5000, "5000"),
        ("[" * 100_000, "nested"),
        ('{"a":' * 100_000, "nested"),
        ("{", "JSON"),
        ("\0", "JSON"),
    ],
)
def test_text_that_is_no_json_of_ours(text, told):
    with pytest.raises(FormatError, match=told):
        values.parsed_json(text)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a = " + "[" * 100_000, "nested"),
        ("a" + ".a" * 100_000 + " = 1", "keys"),
        ("[" + "a." * 100_000 + "a]", "keys"),
        ("a = " + "9" * 5000, "TOML"),
        ("#" * 2_000_000, "1 MB"),
        ("a = 9999-99-99", "TOML"),
        ("a = 'b\x1b[31m'", "TOML"),
    ],
)
def test_text_that_is_no_toml_of_ours(text, told):
    with pytest.raises(FormatError, match=told) as caught:
        values.parsed_toml(text.encode())
    assert str(caught.value).isprintable()


def test_dots_in_names_and_comments_are_no_keys():
    text = "# a.b.c" + ".d" * 50 + '\n["' + "a." * 50 + '"]\ntau_deg = 2.5\n'
    assert values.parsed_toml(text.encode()) == {"a." * 50: {"tau_deg": 2.5}}


@pytest.mark.parametrize("read", [read_session, read_profile, read_rig, read_truth, replay_journal])
@pytest.mark.parametrize("data", [b"[" * 100_000, b"\xff\xfe", b"\0" * 9, b"a = 1", b"null"])
def test_every_reader_says_what_is_wrong_in_a_sentence(tmp_path, read, data):
    path = tmp_path / "document"
    path.write_bytes(data)
    with pytest.raises(TwistError) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def far(document, start, stop):
    """A session whose every interval reaches that far; each is said in some 300 bytes."""
    for entry in document["intervals"]:
        entry |= {"start": start, "stop": stop, "offset_deg": 5.0}
    return document


def test_a_frame_far_behind_the_clip_takes_no_memory(tmp_path):
    document = far(json.loads(session_bytes(CLIP, fresh().state)), 0, values.MOST_FRAMES)
    path = tmp_path / "s.twist.json"
    path.write_text(json.dumps(document))
    session = read_session(path)
    assert all(j.interval.offset.strides == (0,) for j in session.state.intervals)
    with pytest.raises(TwistError):
        check_session_fits_clip(session, CLIP, [*_chains(session)])
    for stop in (values.MOST_FRAMES + 1, 2**63, 10**29):
        with refused(FormatError, "stop"):
            session_from_document(far(document, 0, stop))


def _chains(session):
    from twistcore.skeleton.chain import find_chains

    return [c for c in find_chains(CLIP.motion) if c.name in session.state.tau]


def test_a_constant_offset_is_written_alike_however_it_is_held():
    held = new_constant_offset_interval("a", 3, 9, 0.123456789012)
    light = type(held)("a", 3, 9, np.broadcast_to(held.offset[:1], (6,))).as_written
    assert light.offset.strides == (0,)
    np.testing.assert_array_equal(light.offset, held.as_written.offset)


SPANS = st.lists(
    st.tuples(st.integers(0, 30), st.integers(1, 9)).map(lambda s: (s[0], s[0] + s[1])), max_size=6
)


@given(SPANS, SPANS)
def test_what_is_missing_from_spans_is_so_frame_by_frame(some, others):
    def frames(spans):
        return {t for start, stop in spans for t in range(start, stop)}

    left = uncovered_parts(some, others)
    assert frames(left) == frames(some) - frames(others)
    assert joined_spans(left) == left
