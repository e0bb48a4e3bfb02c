"""Names in bytes that are no UTF-8 survive every file that carries them."""

import csv
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from twistcore.cli import main
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.files.encoding import (
    encode_utf8,
    escape_invalid_utf8,
    json_bytes,
    unescape_invalid_utf8,
)
from twistcore.formats.bvh import read_bvh
from twistcore.review import Review, read_session, start_review, write_session
from twistcore.review.journal import Journal, replay_journal
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import read_truth
from twistcore.tuning import read_profile

NAME = "Unterarm \udcfc"
any_name = st.binary(max_size=12).map(lambda b: b.decode("utf-8", "surrogateescape"))


@given(any_name)
def test_json_is_utf_8_and_gives_the_same_name_again(name):
    data = json_bytes({name: [name]})
    data.decode("utf-8")  # strictly
    assert json.loads(data) == {name: [name]}


@given(any_name)
def test_text_is_utf_8_and_an_escape_is_undone(name):
    assert encode_utf8(name).decode("utf-8") == escape_invalid_utf8(name)
    if "\\udc" not in name:
        assert unescape_invalid_utf8(escape_invalid_utf8(name)) == name


def test_what_is_no_number_is_no_json():
    with pytest.raises(ValueError, match="JSON"):
        json_bytes({"x": float("nan")})


@pytest.fixture
def latin(tmp_path):
    """A walk whose left forearm is named in latin-1, in a folder named so too."""
    folder = tmp_path / os.fsdecode(b"\xfcbung")
    folder.mkdir()
    path = folder / os.fsdecode(b"w\xe4lk.bvh")
    data = (ASSETS / "walk_injected.bvh").read_bytes()
    path.write_bytes(data.replace(b"LeftForeArm", b"Unterarm \xfc"))
    return path


@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_session_and_journal_carry_it(latin):
    clip = read_bvh(latin)
    chains = find_chains(clip.motion)
    found = [new_constant_offset_interval(NAME, 10, 20, 0.5)]
    state = start_review("consistency", {c.name: 0.1 for c in chains}, found, [NAME])
    session = latin.with_suffix(".twist.json")
    write_session(clip, state, session)
    back = read_session(session)
    assert back.clip == str(latin)
    assert back.state.intervals[0].interval.chain == NAME
    journal = Journal(latin.with_suffix(".journal"), clip, state)
    journal.close()
    assert replay_journal(journal.path).review.state.intervals[0].interval.chain == NAME
    assert Review(back.state).state.tau[NAME] == pytest.approx(0.1)


@pytest.mark.thorough
@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_every_command_carries_it(latin, capfd):
    folder = latin.parent
    out, table, truth, profile = (folder / n for n in ("o.bvh", "s.csv", "t.json", "p.toml"))
    assert main(["refine", str(latin), "-o", str(out), "--report", str(folder)]) == 0
    assert b"JOINT Unterarm \xfc" in out.read_bytes()
    assert main(["signals", str(latin), "--csv", str(table), "--chain", NAME]) == 0
    rows = list(csv.reader(table.read_text(encoding="utf-8").splitlines()))
    assert {row[0] for row in rows} == {"chain", escape_invalid_utf8(NAME)}
    words = ["inject", str(latin), "-o", str(folder / "i.bvh"), "--truth", str(truth)]
    assert main([*words, "--seed", "3"]) == 0
    assert read_truth(truth).clip == latin.name
    assert main(["tune", str(latin), "-o", str(profile), "--seeds", "1"]) == 0
    assert NAME in read_profile(profile).tau
    capfd.readouterr()
    assert main(["detect", str(latin), "--json"]) == 0
    chains = {i["chain"] for i in json.loads(capfd.readouterr().out)["intervals"]}
    assert NAME in chains
    for file in folder.iterdir():
        if file.suffix in (".json", ".csv", ".html", ".py"):
            file.read_text(encoding="utf-8")
    report = json.loads(next(folder.glob("*.report.json")).read_bytes())
    assert report["clip"] == latin.name
