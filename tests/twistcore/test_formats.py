"""docs/formats.md shows what the programs really write."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.reviews import CARRIED, CLIP, LIMBS, flip, flipped, fresh, spun
from tests.twistcore.test_report_difference import written
from twistcore.cli import main
from twistcore.detection import Interval, Kind
from twistcore.export.folder_compare import compare_folders, folder_difference_to_json
from twistcore.export.folder_replay import (
    WRITTEN,
    read_recorded_hashes_of_exports,
    record_hash_of_exported_clip,
)
from twistcore.formats.clip import write_clip
from twistcore.report.report_difference import compare_report_files
from twistcore.review import Command, Decide, Decision, Judged
from twistcore.review.journal import REDO, SCHEMA, UNDO, command_from_json, review_command_to_json
from twistcore.study.class_exercise import (
    ClassExercise,
    StudentAnswer,
    write_student_answer,
    write_student_exercise,
)

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "formats.md").read_text(encoding="utf-8")
FILES = [DOCS / link for link in re.findall(r"\((examples/[\w.-]+)\)", PAGE)]


def blocks(kind):
    """The examples of the page, and those in files that the page links to."""
    within = re.findall(rf"```{kind}\n(.*?)```", PAGE, re.S)
    return within + [f.read_text("utf-8") for f in FILES if f.suffix == f".{kind}"]


EXAMPLES = {(document := json.loads(block))["schema"]: document for block in blocks("json")}
LINES = blocks("jsonl")
[JOURNAL] = [block for block in LINES if "twistcore.journal/1" in block]
[APPLIED] = [block for block in LINES if "twistcore.applied/1" in block]
DOTS = "…"
BY_NAME = {
    "tau_deg",
    "off_axis",
    "files",
    "numbers",
    "renamed",
}  # objects whose keys are not the format's


def shape(value, key=""):
    """The keys of a document, lists by their first entry or one of each kind, leaves by type.

    A document within a list goes by its schema: the page shows it once. DOTS are parts that
    another example shows.
    """
    if value == DOTS:
        return DOTS
    if isinstance(value, dict):
        return "by name" if key in BY_NAME else {k: shape(v, k) for k, v in sorted(value.items())}
    if isinstance(value, list):
        if value == [DOTS]:
            return DOTS
        entries = [entry for entry in value if entry != DOTS]  # the first, and others
        if entries and isinstance(entries[0], dict) and "schema" in entries[0]:
            return [entries[0]["schema"]]
        if entries and isinstance(entries[0], dict) and entries[0].get("kind") in list(Kind):
            others = {DOTS: DOTS} if DOTS in value else {}
            return others | {entry["kind"]: shape(entry) for entry in entries}
        return [shape(value[0])] if value and not isinstance(value[0], str) else []
    if value is None or isinstance(value, bool):
        return type(value).__name__
    return "number" if isinstance(value, int | float) else "text"


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    folder = tmp_path_factory.mktemp("formats")
    walk, dirty = str(ASSETS / "walk.bvh"), str(ASSETS / "walk_injected.bvh")
    truth, out = str(ASSETS / "walk_injected.truth.json"), str(folder / "walk.bvh")
    import contextlib
    import io

    def printed(*words, code=0):
        said = io.StringIO()  # what could not be processed, beside the document
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(said):
            assert main([str(word) for word in words]) == code
        return json.loads(out.getvalue())

    refined = printed("refine", dirty, "-o", out, "--method", "paper", "--json")
    bad = folder / "flipped.bvh"
    write_clip(CLIP, flipped(CLIP.motion, flip()), bad)
    worse = folder / "worse.bvh"
    motion = flipped(CLIP.motion, flip(degrees=-160.0))
    write_clip(CLIP, spun("LeftFoot", 60, 70, 140.0, motion), worse)
    low = folder / "low.toml"  # a limb's own motion passes it
    low.write_text('["LeftUpLeg-LeftFoot"]\ntau_deg = 0.3\n')
    asked = ("--explain", "--method", "paper", "--profile", str(low))
    documents = [
        printed("detect", str(worse), "--json", *asked),
        printed("info", walk, "--json"),
        json.loads(Path(truth).read_text()),
        printed("evaluate", "--truth", truth, "--clean", walk, "--refined", out, "--json"),
        printed("diff", dirty, str(bad), "--json"),
        folder_difference(folder, dirty, bad),
        *session_documents(dirty, folder),
        refined,
        *documents_of_many(folder, printed),
        *documents_of_sessions(folder, printed),
        *documents_of_tuning(folder, printed),
        report_differences(folder),
        *exercise_documents(folder),
        *benchmark_documents(folder),
        *quamo_documents(folder, printed),
    ]
    return {d["schema"]: d for d in documents}


def report_differences(folder):
    state = fresh().state
    said = Decide((2,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(state)
    reports = [written(folder / name, of) for name, of in (("before", state), ("after", said))]
    return compare_report_files(*map(Path, reports))


def documents_of_many(folder, printed):
    one, none = ASSETS / "walk_injected.bvh", folder / "none.bvh"
    only = ("--chain", "LeftForeArm", "--json")
    made = ("-o", folder / "made.bvh", "--truth", folder / "made.json", "--seed", "1")
    return (
        printed("info", one, none, "--json", code=1),
        printed("detect", one, none, "--method", "paper", *only, code=1),
        printed("signals", one, none, *only, code=1),
        printed("inject", ASSETS / "walk.bvh", *made, "--json"),
        printed("clean", one, "-o", folder / "clean.bvh", "--order", "Neck=XYZ", "--json"),
    )


def documents_of_sessions(folder, printed):
    import shutil

    from twistcore.analysis.clip_analysis import detect
    from twistcore.formats.bvh import read_bvh
    from twistcore.review import Review, write_session

    captures = folder / "captures"
    captures.mkdir()
    for name in ("05_01", "05_02"):  # accepted by a person: enough to learn τ from
        path = shutil.copy(ASSETS / "walk_injected.bvh", captures / f"{name}.bvh")
        clip = read_bvh(path)
        state = Review.of(detect(clip)).state
        said = {"decision": Decision.ACCEPTED, "decided_at": "2026-01-01T00:00:00+00:00"}
        judged = [replace(one, **said) for one in state.intervals]
        write_session(clip, state.with_intervals(judged), captures / f"{name}.twist.json")
    opposite = [replace(judged[0], decision=Decision.REJECTED), *judged[1:]]
    write_session(clip, state.with_intervals(opposite), folder / "second.twist.json")
    both = captures / "05_02.twist.json", folder / "second.twist.json"
    shutil.copy(ASSETS / "walk.bvh", captures / "alone.bvh")
    first = captures / "05_01.twist.json", captures / "05_01.bvh"
    every = ("apply", captures, captures, "-o", folder / "applied", "--workers", "1", "--json")
    return (
        printed("apply", *first, "-o", folder / "applied.bvh", "--json"),
        printed(*every),
        printed("diff", *both, "--merge", folder / "both.twist.json", "--json"),
    )


def documents_of_tuning(folder, printed):
    walk, out = ASSETS / "walk.bvh", ("-o", folder / "rig.toml", "--workers", "1", "--json")
    return (
        printed("tune", walk, "--method", "paper", "--seeds", "1", *out),
        printed("tune", folder / "captures", "--verdicts", *out),
    )


def folder_difference(folder, dirty, bad):
    import shutil

    for name, clip in (("a", dirty), ("b", bad)):
        (folder / name).mkdir()
        for same in ("same.bvh", f"only_{name}.bvh"):
            shutil.copy(dirty, folder / name / same)
        shutil.copy(clip, folder / name / "other.bvh")
        (folder / name / "bad.bvh").write_text(name)
    compared = compare_folders(folder / "a", folder / "b")
    return folder_difference_to_json(compared, "a", "b")


def exercise_documents(folder):
    own, handed = folder / "exercise.json", folder / "student.json"
    listed = (Interval("LeftArm", 4, 6, np.array([0.2, 0.2])),)
    write_student_exercise(own, ClassExercise("exercise.bvh", "9f2c", "judge", listed))
    verdicts = (Judged(1, listed[0], Decision.REJECTED),)
    write_student_answer(
        handed, StudentAnswer("A. Student", 312.4, "exercise.bvh", "9f2c", verdicts)
    )
    return [json.loads(path.read_text(encoding="utf-8")) for path in (own, handed)]


def benchmark_documents(folder):
    import contextlib
    import io
    import shutil

    clips, out = folder / "clips", folder / "benchmark.json"
    clips.mkdir()
    shutil.copy(ASSETS / "walk_injected.bvh", clips)
    (clips / "broken.bvh").write_text("HIERARCHY")
    words = ["--methods", "paper", "--seeds", "1", "--workers", "1", "--json", str(out)]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert main(["benchmark", str(clips), *words]) == 1
    with out.with_name("benchmark.json.partial.jsonl").open(encoding="utf-8") as partial:
        return json.loads(out.read_text(encoding="utf-8")), json.loads(next(partial))


def quamo_documents(folder, printed):
    import contextlib
    import io
    import shutil

    clips = folder / "subjects"
    clips.mkdir()
    shutil.copy(ASSETS / "dance.bvh", clips / "05_03.bvh")
    dance, words = str(ASSETS / "dance.bvh"), ("--seeds", "1", "--json", "--weights", str(clips))
    with contextlib.redirect_stderr(io.StringIO()):
        return (
            printed("quamo", "noise", dance, "-o", str(folder / "noisy.bvh"), "--json"),
            printed("quamo", "evaluate", str(clips), *words),
            printed("quamo", "ablation", str(clips), *words),
        )


def session_documents(path, folder):
    from twistcore.analysis.clip_analysis import detect
    from twistcore.formats.bvh import read_bvh
    from twistcore.report.clip_report import write_clip_report
    from twistcore.report.document import Report
    from twistcore.review import (
        Decide,
        Decision,
        Insert,
        Review,
        Track,
        Tracking,
        session_bytes,
        start_review,
    )
    from twistcore.review.replay import accepted_motion
    from twistcore.skeleton.chain import find_chains

    clip = read_bvh(path)
    chains = find_chains(clip.motion)
    found = [i for i in detect(clip.motion, chains, "paper") if len(set(i.offset)) == 1]
    tau = {c.name: 0.1 for c in chains}
    review = Review(start_review("paper", tau, found, [c.name for c in chains]))
    plain = session_bytes(clip, review.state)
    review.do(Track(Tracking(("LeftForeArm",))))
    tracked = session_bytes(clip, review.state)
    chains = (*chains, *LIMBS)
    review = Review(replace(review.state, tau={c.name: 0.1 for c in chains}, tracking=None))
    for number, interval in enumerate((flip(), CARRIED), review.state.next_id):
        review.do(Insert(interval))
        review.do(Decide((number,), Decision.ACCEPTED, "Kim", "2026-01-01T00:00:00+00:00"))
    flips = session_bytes(clip, review.state)
    review.do(Track(Tracking(("LeftForeArm",))))
    refined = accepted_motion(clip, chains, review.state)
    *_, report = write_clip_report(folder, Report(clip, chains, review.state, refined))
    documents = plain, tracked, flips, report.read_bytes()
    return tuple(map(json.loads, documents))


def shown(real, example):
    """The parts of a real document's shape that an example's shape does not leave out."""
    if example == DOTS:
        return DOTS
    if isinstance(real, dict) and isinstance(example, dict):
        if DOTS in example:
            real = {DOTS: DOTS} | {key: real[key] for key in real if key in example}
        return {key: shown(value, example.get(key)) for key, value in real.items()}
    if isinstance(real, list) and isinstance(example, list):
        return [shown(*pair) for pair in zip(real, example, strict=False)]
    return real


@pytest.mark.parametrize("schema", EXAMPLES)
def test_the_example_has_the_shape_of_real_output(schema, real):
    example = shape(EXAMPLES[schema])
    assert shown(shape(real[schema]), example) == example


def test_only_dots_leave_something_out():
    real = shape({"a": 1, "b": [{"kind": "limb flip", "c": 1}, {"kind": "lone jump"}]})
    flip = {"kind": "limb flip", "c": 2}
    for right in (["…"], [flip, "…"], [flip, {"kind": "lone jump"}]):
        example = shape({"a": 1, "b": right})
        assert shown(real, example) == example
    assert shown(real, example := shape({"a": 1, "…": "…"})) == example
    assert shown(real, example := shape({"z": 1, "…": "…"})) != example
    for wrong in ([flip], [{"kind": "limb flip"}, "…"], [{**flip, "d": 1}, "…"]):
        example = shape({"a": 1, "b": wrong})
        assert shown(real, example) != example


def test_no_document_is_missing_from_the_page(real):
    assert set(EXAMPLES) == set(real)
    others = {DOCS / "examples" / "batch_clip.json"}  # docs/batch.md
    assert set(FILES) == set((DOCS / "examples").iterdir()) - others


def test_the_journal_s_lines_are_those_that_are_written():
    lines = [json.loads(line) for line in JOURNAL.splitlines()]
    commands = [line for line in lines if "do" in line]
    kinds = {kind.__name__ for kind in Command.__subclasses__()}
    assert {line["do"] for line in commands} == kinds | {
        "TrackBothWays",
        "Smooth",
        "ChangeFirstChain",
    }
    for line in commands:
        assert review_command_to_json(command_from_json(line)) == line
    head, *others = (line for line in lines if "do" not in line)
    assert others == [UNDO, REDO, {"session": head["session"]}]
    assert head == {"schema": SCHEMA, "steps": 0, "session": head["session"]}


def test_the_lines_about_what_apply_wrote_are_those_that_are_written(tmp_path):
    (tmp_path / WRITTEN).write_text(APPLIED, "utf-8")
    hashes = read_recorded_hashes_of_exports(tmp_path)
    assert list(hashes) == ["takes/walk.bvh", "run.bvh"]
    (tmp_path / WRITTEN).unlink()
    for name, sha256 in hashes.items():
        record_hash_of_exported_clip(tmp_path, name, sha256)
    assert (tmp_path / WRITTEN).read_text("utf-8") == APPLIED
