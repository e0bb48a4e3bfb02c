"""The report replaces its own files and nobody else's."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.tiers import parametrize
from tests.twistcore.reviews import CARRIED, CHAINS, CLIP, LIMBS, flip, flipped
from twistcore.analysis.clip_analysis import detect
from twistcore.cli import main
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.errors import TwistError
from twistcore.export.compare import compare_motions
from twistcore.files.atomic import write_atomically
from twistcore.files.version import __version__
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.report import clip_report
from twistcore.report.changes import check_fidelity_of_written_clip, joint_changes
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review import Decide, Decision, Review, Tracking, start_review
from twistcore.review.replay import accepted_motion

STATE = start_review("consistency", {c.name: 0.1 for c in CHAINS}, [], [])
ENDINGS = ("report.html", "intervals.csv", "markers.py", "report.json")


def write(folder, **more):
    return write_clip_report(folder, Report(CLIP, CHAINS, STATE, CLIP.motion, **more))


def test_its_own_files_are_replaced(tmp_path):
    first = write(tmp_path)
    assert [p.name for p in first] == [f"walk_injected.{e}" for e in ENDINGS]
    first[0].unlink()
    assert write(tmp_path) == first
    assert first[0].exists()


@parametrize("again", [False, True])
@parametrize("count", range(5))
def test_what_a_killed_program_left_of_it_is_replaced(tmp_path, monkeypatch, count, again):
    class Killed(BaseException):
        pass

    def write_so_many(path, data):
        done.append(path)
        if len(done) > count:
            raise Killed
        write_atomically(path, data)

    first = write(tmp_path) if again else ()
    before = [path.read_bytes() for path in first]
    done = []
    with monkeypatch.context() as patch:
        patch.setattr(clip_report, "write_atomically", write_so_many)
        with pytest.raises(Killed):
            write(tmp_path, by="Lee")  # other bytes
    assert len(done) == count + 1
    assert ([p.read_bytes() for p in first] != before) == (again and count > 0)
    last = write(tmp_path)
    assert "replaced" not in json.loads(last[-1].read_bytes())
    last[1].write_text("mine")
    with pytest.raises(TwistError, match=last[1].name):
        write(tmp_path)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("after", [False, True])
def test_a_file_of_somebody_else_is_not(tmp_path, ending, after):
    """There before, or changed since by whoever makes notes in the table."""
    if after:
        write(tmp_path)
    path = tmp_path / f"walk_injected.{ending}"
    path.write_bytes(b"my own notes")
    before = {p: p.read_bytes() for p in tmp_path.iterdir()}
    with pytest.raises(TwistError, match="walk_injected"):
        write(tmp_path)
    assert {p: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_it_says_which_joints_moved_and_why(tmp_path):
    """The knee of a flip, the toe of one that carried the foot, what tracking moves, no other."""
    write_clip(CLIP, flipped(CLIP.motion, flip(), CARRIED), tmp_path / "flipped.bvh")
    clip = read_bvh(tmp_path / "flipped.bvh")
    chains = (*CHAINS, *LIMBS)
    tau = {c.name: 0.1 for c in chains}
    names = [c.name for c in chains]
    twist = new_constant_offset_interval("LeftForeArm", 10, 20, 0.5)
    state = start_review("consistency", tau, [twist, flip(), CARRIED], names)
    state = Decide((1, 2, 3), Decision.ACCEPTED).apply(state)

    def document(**more):
        own = replace(state, **more)
        report = Report(clip, chains, own, accepted_motion(clip, chains, own))
        *_, listing = write_clip_report(tmp_path, report)
        return json.loads(listing.read_bytes())

    changed = document()["changed"]
    assert {m["joint"]: m["why"] for m in changed["moved"]} == {
        "LeftLeg": "limb flip", "LeftToeBase": "limb flip", "RightLeg": "limb flip"
    }  # fmt: skip
    assert max(m["max_of_height"] for m in changed["moved"]) == changed["max_position_of_height"]
    assert changed["rest_of_height"] < 1e-9
    assert changed["max_position_of_height"] > 0.01
    tracked = document(tracking=Tracking(("RightLeg",), kp=3000.0, kd=33.0))
    why = {m["joint"]: m["why"] for m in tracked["changed"]["moved"]}
    assert (why["RightFoot"], why["RightLeg"]) == ("tracking", "limb flip")
    assert (why["RightToeBase"], why["LeftToeBase"]) == ("tracking", "limb flip")


def test_kind_and_end_stand_in_the_tables(tmp_path):
    chains = (*CHAINS, *LIMBS)
    tau = {c.name: 0.1 for c in CHAINS} | {"RightUpLeg-RightFoot": 0.5}
    found = [
        new_constant_offset_interval("LeftForeArm", 10, 20, 0.5),
        flip(),
        flip(start=120, stop=125, carried=True),
    ]
    state = start_review("consistency", tau, found, [c.name for c in chains])
    page, table, _, listing = write_clip_report(tmp_path, Report(CLIP, chains, state, CLIP.motion))
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    ends = [(row["kind"], row["end"]) for row in rows]
    assert ends == [("counter-twist", ""), ("limb flip", "kept"), ("limb flip", "carried")]
    document = json.loads(listing.read_bytes())
    assert [i["end"] for i in document["intervals"]] == ["", "kept", "carried"]
    limb = document["chains"][-1]
    assert (len(document["chains"]), limb["label"]) == (11, "Right leg")  # those that have a τ
    assert (limb["kind"], limb["intervals"]) == ("limb flip", 2)
    assert limb["tau_deg"] == pytest.approx(np.degrees(0.5))
    text = page.read_text("utf-8")
    assert "<td>counter-twist</td>" in text
    assert "0.0e+00" in text


def test_a_report_without_flips_says_nothing_of_limbs(tmp_path):
    page = write(tmp_path)[0].read_text("utf-8")
    assert "limb" not in page


def test_refine_says_so_before_it_writes_anything(tmp_path, capsys):
    (tmp_path / "walk_injected.intervals.csv").write_text("mine")
    out = tmp_path / "out.bvh"
    words = ["refine", str(CLIP.path), "-o", str(out), "--report", str(tmp_path)]
    assert main(words) == 2
    assert "walk_injected.intervals.csv" in capsys.readouterr().err
    assert not out.exists()


def test_it_says_who_when_and_what_nobody_saw(tmp_path):
    tau = {c.name: 0.1 for c in CHAINS}
    found = [new_constant_offset_interval("LeftForeArm", 20 * k, 20 * k + 9, 0.5) for k in range(4)]
    state = start_review("consistency", tau, found, [c.name for c in CHAINS])
    state = Decide((1,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(state)
    state = Decide((2,), Decision.REJECTED, "Kim", "2026-01-02T10:05:00+00:00").apply(state)
    state = Decide((3,), Decision.ACCEPTED).apply(state)  # as `refine` does, and an export
    report = Report(CLIP, CHAINS, state, CLIP.motion, name="out", files={"out.bvh": "1"}, by="Lee")
    page, table, markers, listing = write_clip_report(tmp_path, report)
    assert page.name == "out.report.html"
    document = json.loads(listing.read_bytes())
    verdicts = ["accepted", "rejected", "applied automatically", "undecided"]
    assert [i["decision"] for i in document["intervals"]] == verdicts
    assert document["decisions"] == {**dict.fromkeys(verdicts, 1), "seen": 0, "not correctable": 0}
    times = {"first": "2026-01-02T10:00:00+00:00", "last": "2026-01-02T10:05:00+00:00"}
    assert document["reviewers"] == [{"reviewer": "Kim", "decisions": 2, **times}]
    assert document["program"] == f"twistcore {__version__}"
    assert (document["written_by"], document["written_at"]) == ("Lee", report.at)
    assert (len(document["files"]), document["files"]["out.bvh"]) == (4, "1")
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    assert [row["decision"] for row in rows] == verdicts
    assert "applied automatically" in markers.read_text("utf-8")
    text = page.read_text("utf-8")
    assert " Lee" in text
    assert re.search(r"2 decisions .*Kim, 2026-01-02 10:00.*2026-01-02 10:05", text)
    assert text.count('<td class="applied">applied automatically<') == 1


def test_a_report_of_refine_names_nobody(tmp_path, capsys):
    words = ["refine", str(CLIP.path), "-o", str(tmp_path / "out.bvh"), "--report", str(tmp_path)]
    assert main(words) == 0
    capsys.readouterr()
    _, table, *_, listing = (tmp_path / f"walk_injected.{e}" for e in ENDINGS)
    decisions = json.loads(listing.read_bytes())["decisions"]
    assert decisions["applied automatically"] > 0
    assert decisions["accepted"] == 0
    assert ",accepted," not in table.read_text("utf-8")


def corrected_clip(folder, name="out.bvh"):
    """A clip with one error, its review that accepts it, what was written, and the report."""
    write_clip(CLIP, CLIP.motion, folder / "source.bvh")
    clip = read_clip(folder / "source.bvh")
    found = new_constant_offset_interval("LeftForeArm", 10, 20, 0.5)
    state = start_review("consistency", {c.name: 0.1 for c in CHAINS}, [found], [])
    state = Decide((1,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(state)
    refined = accepted_motion(clip, CHAINS, state)
    write_clip(clip, refined, folder / name)
    return clip, refined, Report(clip, CHAINS, state, refined, written=folder / name)


def test_what_was_left_alone_is_measured_on_the_file(tmp_path):
    clip, refined, report = corrected_clip(tmp_path)
    kept = check_fidelity_of_written_clip(clip, refined, tmp_path / "out.bvh")
    assert (kept.what, kept.total, kept.outside, kept.head) == ("columns", clip.columns, 0, True)
    assert kept.total - kept.same == 6  # P's and C's three
    page = write_clip_report(tmp_path, report)[0].read_text("utf-8")
    assert f"{kept.same} of {kept.total} columns" in page


@pytest.mark.parametrize("where", ["number", "decimals", "head"])
def test_what_was_not_left_alone_is_found(tmp_path, where):
    """Another number where nothing was corrected, the same with other letters, another header."""
    clip, refined, report = corrected_clip(tmp_path)
    lines = (tmp_path / "out.bvh").read_bytes().splitlines(keepends=True)
    first, rest = lines[-1].split(maxsplit=1)
    if where == "head":
        lines[0] = b"HIERARCHY \n"
    else:
        lines[-1] = b"%b %b" % (b"1.5" if where == "number" else first + b"0", rest)
    (tmp_path / "out.bvh").write_bytes(b"".join(lines))
    kept = check_fidelity_of_written_clip(clip, refined, tmp_path / "out.bvh")
    assert (kept.outside, kept.head) == ((0, False) if where == "head" else (1, True))
    assert write_clip_report(tmp_path, report)[0].read_text("utf-8")


def test_changes_are_told_by_joint_with_the_root_of_the_mean_square(tmp_path):
    clip, refined, _ = corrected_clip(tmp_path)
    changes = joint_changes(clip.motion, refined, compare_motions(clip.motion, refined))
    assert [c.joint for c in changes] == ["LeftForeArm", "LeftHand"]
    assert {c.frames for c in changes} == {10}
    assert changes[0].max_deg == pytest.approx(np.degrees(0.5), abs=1e-6)
    assert changes[0].rms_deg == pytest.approx(np.degrees(0.5), abs=1e-6)


def test_the_page_says_what_is_found_again(tmp_path):
    """What is "taken out" where nothing was wrong is put in; where nothing is, nothing is said."""
    _, refined, report = corrected_clip(tmp_path)
    page = write_clip_report(tmp_path, report)[0].read_text("utf-8")
    again = detect(refined, [c.name for c in CHAINS], tau_degrees=float(np.degrees(0.1)))
    assert any((i.chain, i.start) == ("LeftForeArm", 10) for i in again)
    row = r'<td>counter-twist</td><td class="n">(\d+–\d+)</td>.*>([\w ]+)</td></tr>'
    rows = re.findall(row, page)
    left = {(i.start, i.stop) for i in again}
    assert dict(rows)["10–20"] == "accepted"
    assert {where for where, what in rows if what == "new"} == {
        f"{a}–{b}" for a, b in left if b <= 10 or a >= 20
    }
    nothing = write(tmp_path)[0].read_text("utf-8")
    assert not re.findall(row, nothing)


def test_a_name_from_a_file_is_no_part_of_the_page(tmp_path):
    text = CLIP.data.replace(b"LeftForeArm", b"<script>x</script>")
    (tmp_path / "<b>.bvh").write_bytes(text)
    clip = read_clip(tmp_path / "<b>.bvh")
    found = detect(clip, tau_degrees=0.1)
    state = Review.of(found).state
    report = Report(clip, found.chains_and_limbs, state, clip.motion)
    page = write_clip_report(tmp_path, report)[0].read_text("utf-8")
    assert "<script>" not in page
    assert "&lt;script&gt;" in page
    assert "<b>.bvh" not in page
