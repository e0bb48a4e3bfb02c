"""Outputs of the commands: '-', links, FIFOs and devices, in processes of their own."""

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.formats.bvh import parse_bvh

ROOT = Path(__file__).parents[2]
WALK, DIRTY = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh"
TRUTH = ASSETS / "walk_injected.truth.json"
posix = pytest.mark.skipif(os.name != "posix", reason="no FIFOs, devices or /dev/fd")


def run(folder, *words, **more):
    """The command in a folder: its code, bytes on standard output, text on standard error."""
    command = [sys.executable, "-m", "twistcore", *map(str, words)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"}
    more = {"stdout": subprocess.PIPE, **more}
    done = subprocess.run(
        command, cwd=folder, env=environment, stderr=subprocess.PIPE, check=False, **more
    )
    return done.returncode, done.stdout, done.stderr.decode()


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """A folder with one short clip, and what refine makes of it."""
    folder = tmp_path_factory.mktemp("clips")
    lines = DIRTY.read_bytes().splitlines(keepends=True)
    (folder / "c.bvh").write_bytes(b"".join(lines[:-250]))
    assert run(folder, "refine", "c.bvh", "-o", "r.bvh", "--method", "paper")[0] == 0
    return folder


@parametrize("name", ["-", "/dev/stdout"])
def test_refined_bytes_alone_come_out_and_words_beside(clips, tmp_path, name):
    code, out, err = run(tmp_path, "refine", clips / "c.bvh", "-o", name, "--method", "paper")
    assert code == 0
    assert out == (clips / "r.bvh").read_bytes()
    assert "intervals corrected" in err
    assert list(tmp_path.iterdir()) == []


@parametrize(
    ("words", "parse"),
    [
        (("signals", DIRTY, "--csv", "-"), lambda out: out.startswith(b"chain,frame") or 1 / 0),
        (("inject", WALK, "-o", "-", "--truth", "t", "--seed", "1"), parse_bvh),
        (("inject", WALK, "-o", "o", "--truth", "-", "--seed", "1"), json.loads),
        (("quamo", "refine", WALK, "-o", "-"), parse_bvh),
        (("quamo", "noise", WALK, "-o", "-"), parse_bvh),
    ],
)
def test_every_output_may_be_standard_output(tmp_path, words, parse):
    code, out, err = run(tmp_path, *words)
    assert (code, "Traceback" in err) == (0, False)
    parse(out)


@pytest.mark.thorough
def test_of_a_benchmark_too(clips, tmp_path):
    words = ("benchmark", clips, "--methods", "paper", "--seeds", "1", "--workers", "1")
    code, out, err = run(tmp_path, *words, "--json", "-")
    assert (code, json.loads(out)["clips"]) == (0, 2)
    assert "P0" in err
    assert list(tmp_path.iterdir()) == []
    code, out, _ = run(tmp_path, *words, "--csv", "-")
    assert (code, out.split(b",")[0]) == (0, b"protocol")


@pytest.mark.thorough
def test_a_profile_too(clips, tmp_path):
    words = ("tune", clips / "c.bvh", "-o", "-", "--method", "paper", "--seeds", "1")
    code, out, err = run(tmp_path, *words, "--workers", "1")
    assert code == 0
    assert out.startswith(b"# \xcf\x84 per joint")
    assert "false alarms/min" in err


@parametrize(
    "words",
    [
        ("inject", WALK, "-o", "-", "--truth", "-", "--seed", "1"),
        ("benchmark", ASSETS, "--json", "-", "--csv", "-"),
        ("quamo", "noise", WALK, "-o", "-", "--json"),
        ("refine", DIRTY, "-o", "-", "--report", "-"),
        ("quamo", "train", ASSETS, "-o", "-"),
    ],
)
def test_standard_output_takes_one_thing(tmp_path, words):
    code, out, err = run(tmp_path, *words)
    assert (code, out, err.count("\n")) == (2, b"", 1)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_file_called_minus(clips, tmp_path):
    words = ("refine", clips / "c.bvh", "-o", "./-", "--method", "paper")
    code, out, _ = run(tmp_path, *words)
    assert (code, b"corrected" in out) == (0, True)
    assert (tmp_path / "-").read_bytes() == (clips / "r.bvh").read_bytes()


@pytest.mark.thorough
def test_a_reader_that_leaves_is_no_error(tmp_path):
    command = [sys.executable, "-m", "twistcore", "refine", str(DIRTY), "-o", "-"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, env=environment) as process:
        assert process.stdout.read(9) == b"HIERARCHY"
        process.stdout.close()
        assert b"Traceback" not in process.stderr.read()
        assert process.wait() == 0


@pytest.mark.thorough
def test_what_is_appended_to_keeps_what_it_had(clips, tmp_path):
    with (tmp_path / "log").open("ab") as log:
        log.write(b"before\n")
        log.flush()
        words = ("refine", clips / "c.bvh", "-o", "-", "--method", "paper")
        assert run(tmp_path, *words, stdout=log)[0] == 0
    assert (tmp_path / "log").read_bytes() == b"before\n" + (clips / "r.bvh").read_bytes()


@pytest.mark.thorough
def test_a_link_is_followed_and_one_to_an_input_refused(clips, tmp_path):
    clip, link, out = (tmp_path / n for n in ("c.bvh", "link.bvh", "out.bvh"))
    clip.write_bytes((clips / "c.bvh").read_bytes())
    link.symlink_to("c.bvh")
    code, _, err = run(tmp_path, "refine", "c.bvh", "-o", "link.bvh", "--method", "paper")
    assert (code, "an input of this command" in err) == (2, True)
    assert clip.read_bytes() == (clips / "c.bvh").read_bytes()
    link.unlink()
    link.symlink_to("out.bvh")
    assert run(tmp_path, "refine", "c.bvh", "-o", "link.bvh", "--method", "paper")[0] == 0
    assert link.is_symlink()
    assert out.read_bytes() == (clips / "r.bvh").read_bytes()
    code, _, err = run(
        tmp_path, "inject", "c.bvh", "-o", "link.bvh", "--truth", "out.bvh", "--seed", "1"
    )
    assert (code, "different files" in err) == (2, True)


@parametrize(
    "words",
    [
        ("tune", "c.bvh", "-o", "c.bvh"),
        ("benchmark", ".", "--csv", "c.bvh"),
        ("refine", "c.bvh", "-o", "p.toml", "--profile", "p.toml"),
        ("refine", "c.bvh", "-o", "loop"),
        ("refine", "c.bvh", "-o", "astray"),
    ],
)
def test_what_may_not_be_written_is_one_sentence(clips, tmp_path, words):
    (tmp_path / "c.bvh").write_bytes((clips / "c.bvh").read_bytes())
    (tmp_path / "p.toml").write_text("[LeftArm]\ntau_deg = 5.0\n")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "astray").symlink_to("nowhere/x")
    before = {p.name: p.is_symlink() or p.read_bytes() for p in tmp_path.iterdir()}
    code, _, err = run(tmp_path, *words)
    assert (code, err.count("\n")) == (2, 1)
    assert {p.name: p.is_symlink() or p.read_bytes() for p in tmp_path.iterdir()} == before


@pytest.mark.thorough
@posix
def test_a_device_is_written_into(clips, tmp_path):
    null, full, disk = (tmp_path / name for name in ("null", "full", "disk"))
    try:
        os.mknod(null, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        os.mknod(full, stat.S_IFCHR | 0o666, os.makedev(1, 7))
        os.mknod(disk, stat.S_IFBLK | 0o666, os.makedev(7, 200))
    except PermissionError:
        pytest.skip("only root makes devices")
    kinds = [p.stat().st_mode for p in (null, full, disk)]
    words = ("refine", clips / "c.bvh", "--method", "paper", "-o")
    assert run(tmp_path, *words, null)[0] == 0
    code, _, err = run(tmp_path, *words, full)
    assert (code, "No space" in err) == (2, True)
    code, _, err = run(tmp_path, *words, disk)
    assert (code, "found a block device" in err) == (2, True)
    assert [p.stat().st_mode for p in (null, full, disk)] == kinds


@pytest.mark.thorough
@posix
def test_a_fifo_and_a_process_get_the_bytes(clips, tmp_path):
    os.mkfifo(tmp_path / "fifo")
    words = ("refine", clips / "c.bvh", "--method", "paper", "-o")
    with subprocess.Popen(["cat", "fifo"], cwd=tmp_path, stdout=subprocess.PIPE) as cat:
        code, out, _ = run(tmp_path, *words, "fifo")
        assert cat.stdout.read() == (clips / "r.bvh").read_bytes()
    assert (code, b"corrected" in out) == (0, True)
    assert (tmp_path / "fifo").is_fifo()
    reader, writer = os.pipe()  # as a shell hands over >(command)
    with subprocess.Popen(["cat"], stdin=reader, stdout=subprocess.PIPE) as cat:
        os.close(reader)
        code, _, _ = run(tmp_path, *words, f"/dev/fd/{writer}", pass_fds=[writer])
        os.close(writer)
        assert cat.stdout.read() == (clips / "r.bvh").read_bytes()
    assert code == 0
