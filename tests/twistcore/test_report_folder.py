"""The report of a batch folder: what it counts, what it tells of clips gone, what it spares."""

import os
import re
from contextlib import contextmanager
from dataclasses import replace
from urllib.parse import unquote_to_bytes

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.made_records import failed, record_of, waiting
from tests.twistcore.two_people import two_people
from twistcore.analysis.clip_analysis import analyse
from twistcore.batch.clip_result import process_clip
from twistcore.batch.gates import Broken, parse_batch_rule
from twistcore.batch.parameters import Parameters
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.report import folder_report, picture_job
from twistcore.report.folder_report import clip_page_path, write_folder_report
from twistcore.report.picture_job import Drawn
from twistcore.report.recorded_clip import clip_report_from_batch_record
from twistcore.review import Decide, Decision, Review, write_session

KICK, WALK = ASSETS / "kick.bvh", ASSETS / "walk.bvh"


@pytest.fixture(scope="module")
def kick():
    return record_of(KICK, "shots/kick.bvh")


def written(folder, records, **more):
    more = {"pictures": False, **more}
    return write_folder_report(folder, folder / "report", records=records, **more)


def text(folder, page="index.html"):
    return (folder / "report" / page).read_text("utf-8")


def test_all_are_counted_and_the_worst_comes_first(tmp_path, kick):
    walk = record_of(WALK, "walk.bvh")
    done = written(tmp_path, [walk, failed("a<b>.bvh", "line 2: x"), kick, waiting("z.bvh")])
    assert (done.pages, done.problems) == (2, ())
    page = text(tmp_path)
    assert page.index(">shots/kick.bvh<") < page.index(">walk.bvh<")
    assert 'href="clips/shots/kick.bvh.html"' in page
    flips = kick.result["counts"]["limb flip"]
    assert f"<b>{flips}</b> limb flip" in page
    assert "a&lt;b&gt;.bvh" in page
    assert "<b>.bvh" not in page
    assert "line 2: x" in page
    assert ">1</b> waiting" in page
    assert 'href="../../index.html"' in text(tmp_path, "clips/shots/kick.bvh.html")


def test_a_run_of_which_nothing_was_processed_has_a_page(tmp_path):
    assert written(tmp_path, [failed("a.bvh", "no")]).pages == 0
    assert "No clip was processed" in text(tmp_path)
    assert written(tmp_path, []).pages == 0


def test_clips_that_are_gone_or_changed_have_what_the_run_noted(tmp_path, kick):
    (tmp_path / "changed.bvh").write_bytes(KICK.read_bytes() + b"\n")
    gone = replace(kick, name="gone.bvh", source=str(tmp_path / "gone.bvh"))
    changed = replace(kick, name="changed.bvh", source=str(tmp_path / "changed.bvh"))
    far = replace(kick, name="far.bvh", source="s3://bucket/far.bvh")
    done = written(tmp_path, [gone, changed, far])
    printed = {"gone": "does not exist", "changed": "changed after", "far": "on this computer"}
    assert len(done.problems) == 3
    for name, why in printed.items():
        assert sum(why in problem for problem in done.problems) == 1
        page = text(tmp_path, f"clips/{name}.bvh.html")
        assert why in page
        assert page.count("<td>limb flip") == kick.result["counts"]["limb flip"]


def test_decisions_of_a_session_stand_in_the_page(tmp_path, kick):
    clip = read_clip(KICK)
    state = Review.of(analyse(clip).detect()).state
    first = next(j.id for j in state.intervals if j.interval.repairable)
    state = Decide((first,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(state)
    write_session(clip, state, tmp_path / "kick.session.json")
    decisions = {"accepted": 1, "rejected": 0, "undecided": len(state.intervals) - 1,
                 "reviewers": ["Kim"], "session": str(tmp_path / "kick.session.json")}  # fmt: skip
    assert written(tmp_path, [replace(kick, decisions=decisions)]).problems == ()
    assert f"1 of {len(state.intervals)}" in text(tmp_path)
    page = text(tmp_path, "clips/shots/kick.bvh.html")
    assert "1 decision by Kim" in page
    assert page.count('class="accepted">accepted') == 1


def test_a_damaged_session_costs_its_clip_only(tmp_path, kick):
    (tmp_path / "s.json").write_text("{")
    bad = replace(kick, name="bad.bvh", decisions={"session": str(tmp_path / "s.json")})
    done = written(tmp_path, [bad, kick])
    assert len(done.problems) == 1
    assert "s.json" in text(tmp_path, "clips/bad.bvh.html")
    assert "Curves" in text(tmp_path, "clips/shots/kick.bvh.html")


@pytest.mark.parametrize("page", ["index.html", "clips/shots/kick.bvh.html"])
def test_a_file_of_somebody_else_is_not_replaced(tmp_path, kick, page):
    written(tmp_path, [kick])
    assert written(tmp_path, [kick]).pages == 1  # its own are
    (tmp_path / "report" / page).write_text("my own notes")
    before = {p: p.read_bytes() for p in (tmp_path / "report").rglob("*.html")}
    with pytest.raises(TwistError, match="is not a report of this program"):
        written(tmp_path, [kick])
    assert {p: p.read_bytes() for p in (tmp_path / "report").rglob("*.html")} == before


@pytest.mark.parametrize("name", ["../../x.bvh", "/etc/x.bvh", "a/../../../x.bvh"])
def test_no_name_leads_out_of_the_report(tmp_path, kick, name):
    written(tmp_path, [replace(kick, name=name)])
    pages = [p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.html")]
    assert sorted(pages) == sorted(["report/index.html", f"report/{clip_page_path(name)}"])
    link = re.search(r'href="([^"]*)">← ', text(tmp_path, clip_page_path(name)))[1]
    assert (tmp_path / "report" / clip_page_path(name)).parent.joinpath(link).resolve() == (
        tmp_path / "report" / "index.html"
    )


@pytest.mark.skipif(os.name != "posix", reason="bytes in names")
def test_a_name_that_is_no_utf8_has_a_page_and_a_link_to_it(tmp_path, kick):
    name = os.fsdecode(b"caf\xe9/caf\xe9 1.bvh")
    assert written(tmp_path, [replace(kick, name=name), failed("f" + name, "no")]).pages == 1
    index = (tmp_path / "report" / "index.html").read_bytes()
    address = re.search(rb'href="(clips/[^"]*)"', index)[1]
    assert (tmp_path / "report" / os.fsdecode(unquote_to_bytes(address))).exists()
    assert b"caf\\udce9 1.bvh" in index


def test_only_the_worst_have_pages_where_so_many_are_asked_for(tmp_path, kick):
    walk = record_of(WALK, "walk.bvh")
    assert written(tmp_path, [walk, kick], most_pages=1).pages == 1
    assert not (tmp_path / "report" / "clips" / "walk.bvh.html").exists()
    assert ">walk.bvh<" in text(tmp_path)


def test_without_pictures_the_page_says_why_and_is_whole(tmp_path, kick, monkeypatch):
    monkeypatch.setattr(
        folder_report, "draw_figures", lambda f: [Drawn(problem="no driver")] * len(f)
    )
    done = written(tmp_path, [kick], pictures=True)
    [problem] = done.problems
    assert names_in_one_line(problem, "shots/kick.bvh: ", "no driver")
    page = text(tmp_path, "clips/shots/kick.bvh.html")
    assert "no driver" in page
    assert "<img" not in page


def test_broken_rules_are_told_of_clips_and_of_the_run(tmp_path, kick):
    rules = parse_batch_rule("severity>5"), parse_batch_rule("total.count>3")
    written(tmp_path, [kick], broken=[Broken(rules[0], kick.name, 9.0), Broken(rules[1], "", 8)])
    page = text(tmp_path)
    assert re.search("shots/kick.bvh: .* 9°.*&#39;severity&gt;5&#39;", page)
    assert "total.count&gt;3" in page


@pytest.mark.thorough
def test_many_processes_write_the_same_pages(tmp_path, kick, monkeypatch):
    monkeypatch.setattr(folder_report, "_TOGETHER", 1)
    records = [kick, replace(kick, name="again.bvh")]
    for workers in (1, 2):
        written(tmp_path / str(workers), records, workers=workers)
    stamp = re.compile(r"Written [^.]*")
    one, two = (
        {
            p.name: stamp.sub("", p.read_text("utf-8"))
            for p in (tmp_path / w).rglob("clips/**/*.html")
        }
        for w in "12"
    )
    assert one == two
    assert len(one) == 2


# -- pictures that do not come ---------------------------------------------------------------------


def figure():
    clip = read_clip(KICK)
    found = analyse(clip).detect()
    interval = next(i for i in found if i.repairable)
    wanted = [(interval.chain, interval.start)]
    return picture_job.make_clip_figure(clip.motion, clip.motion, found.chains_and_limbs, wanted)


def test_a_job_comes_back_as_it_was_put_down(tmp_path):
    put = figure()
    picture_job.write_report_picture_job(tmp_path, [put])
    size, (got,) = picture_job.read_picture_job(tmp_path)
    assert size == picture_job.SIZE
    assert got.pairs == put.pairs
    assert got.motion.skeleton.names == put.motion.skeleton.names
    assert (got.motion.rotations == put.motion.rotations).all()
    assert [type(c) for c in got.chains] == [type(c) for c in put.chains]
    assert [c.name for c in got.chains] == [c.name for c in put.chains]


@pytest.mark.skipif(os.name == "nt", reason="a shell is asked to fail")
@pytest.mark.parametrize(
    ("script", "told"),
    [
        ("echo one >&2; echo 'the last line' >&2; exit 3", "the last line"),
        ("kill -9 $$", ""),
        ("exit 0", ""),
        ("sleep 60", " s"),
    ],
)
def test_a_process_that_fails_is_told_in_one_line(monkeypatch, script, told):
    monkeypatch.setattr(picture_job, "_TO_START", 0.5)
    monkeypatch.setattr(picture_job, "_TO_DRAW", 0.0)
    (drawn,) = picture_job.draw_figures([figure()], python=["sh", "-c", script])
    assert drawn.pictures == ()
    assert told in drawn.problem
    assert "\n" not in drawn.problem


def test_a_chunk_that_dies_costs_its_own_pages(tmp_path, kick, monkeypatch):
    """Whatever goes wrong in one, each of its clips has a page, and the others have all."""
    monkeypatch.setattr(folder_report, "_TOGETHER", 1)
    real = folder_report.report_to_json

    def failing(report):
        if report.name == "bad.bvh":
            raise ValueError("a defect\nof ours")
        return real(report)

    monkeypatch.setattr(folder_report, "report_to_json", failing)
    counted = []

    @contextmanager
    def counter(total):
        assert total == 2
        yield counted.append

    done = written(tmp_path, [replace(kick, name="bad.bvh"), kick], counter=counter)
    assert sorted(counted) == ["bad.bvh", "shots/kick.bvh"]
    assert len(done.problems) == 1
    assert "\n" not in done.problems[0]
    assert "a defect of ours" in text(tmp_path, "clips/bad.bvh.html")
    assert text(tmp_path, "clips/shots/kick.bvh.html")


def test_a_full_disk_ends_it(tmp_path, kick, monkeypatch):
    def full(path, data):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(folder_report, "write_atomically", full)
    with pytest.raises(OSError, match="No space left"):
        written(tmp_path, [kick])


@pytest.mark.parametrize(
    "parameters",
    [
        Parameters(people=("A",)),
        Parameters(joint_names={"ours": {"other": ["ForeArm", "Arm", "Shoulder", "Hand"]}}),
    ],
)
def test_a_page_examines_the_same_chains_as_the_run(tmp_path, parameters):
    path = tmp_path / "pair.bvh"
    path.write_bytes(two_people())
    every = record_of(path, "pair.bvh")
    _, document, _ = process_clip(path, parameters)
    result = every.result | {key: document[key] for key in ("chains", "tau_deg")}
    record = replace(every, result=result, parameters=parameters.to_json())
    own, whole = (clip_report_from_batch_record(one, tmp_path).chains for one in (record, every))
    assert [chain.name for chain in own] == document["chains"]
    assert [chain.label for chain in own] != [chain.label for chain in whole]
