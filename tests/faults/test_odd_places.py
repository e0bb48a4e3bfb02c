"""FIFOs, loops of links, links astray and folders in the places of files: told, never waited for.

To open a FIFO would wait for good: each command has a time limit far beyond what it takes.
"""

import errno
import os
import shutil
import signal
import sys

import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.cli import main
from twistcore.files.lock import is_file_locked
from twistcore.files.marks import sha256_of
from twistcore.files.ordinary import open_to_read, read_file, real_path
from twistcore.formats.clip_files import clip_paths_in_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such files there")

SUFFIXES = ("bvh", "npz", "amc", "asf")
ODD = ("fifo", "loop", "astray", "folder", "to_fifo", "device")
FOREVER_S = 100


def put(path, kind):
    """Something that is no file under this name."""
    match kind:
        case "fifo":
            os.mkfifo(path)
        case "loop":
            path.symlink_to(path.name)
        case "astray":
            path.symlink_to("nowhere")
        case "folder":
            path.mkdir()
        case "to_fifo":
            os.mkfifo(path.with_name(f"{path.name}.fifo"))
            path.symlink_to(f"{path.name}.fifo")
        case "device":
            path.symlink_to("/dev/zero")  # which has no end


@pytest.fixture
def odd(tmp_path):
    """A folder with everything odd under names of clips, and one clip."""
    folder = tmp_path / "odd"
    folder.mkdir()
    for kind in ODD:
        for suffix in SUFFIXES:
            put(folder / f"{kind}.{suffix}", kind)
    shutil.copy(ASSETS / "walk_injected.bvh", folder / "walk.bvh")
    return folder


class WaitedError(BaseException):
    """What was to be over in a moment was not."""


@pytest.fixture
def ran(capsys):
    """Runs a command of twistcore in this process; its exit code, and everything it said."""

    def late(*_):
        raise WaitedError

    def run(*words):
        signal.alarm(FOREVER_S)
        try:
            code = main([str(word) for word in words])
        finally:
            signal.alarm(0)
        said = capsys.readouterr()
        return code, said.err + said.out

    before = signal.signal(signal.SIGALRM, late)
    yield run
    signal.signal(signal.SIGALRM, before)


def of(folder, suffixes=("bvh", "npz", "amc")):
    return [folder / f"{kind}.{suffix}" for kind in ODD for suffix in suffixes]


@pytest.mark.parametrize("kind", ODD)
def test_what_is_no_file_is_not_read(tmp_path, kind):
    path = tmp_path / "x"
    put(path, kind)
    for work in (read_file, sha256_of, open_to_read):
        with pytest.raises(OSError, match=r".") as caught:
            work(path)
        assert caught.value.errno in (errno.EINVAL, errno.ELOOP, errno.ENOENT, errno.EISDIR)
        assert caught.value.filename == str(path)
    assert not is_file_locked(path)


def test_what_a_shell_gives_open_is_read(tmp_path):
    """`<(…)` and a standard input by its path."""
    reader, writer = os.pipe()
    os.write(writer, b"given")
    os.close(writer)
    try:
        assert read_file(f"/dev/fd/{reader}") == b"given"
    finally:
        os.close(reader)
    for name in ("a", "link"):
        (tmp_path / "a").write_bytes(b"a")
        (tmp_path / "link").unlink(missing_ok=True)
        (tmp_path / "link").symlink_to("a")
        assert read_file(tmp_path / name) == b"a"


def test_a_loop_is_its_own_end(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    assert real_path(tmp_path / "a").parent == real_path(tmp_path)
    (tmp_path / "c").symlink_to("folder/d")
    assert real_path(tmp_path / "c") == (tmp_path / "c").resolve()


def test_every_clip_that_is_none_is_one_sentence(odd, ran):
    code, said = ran("info", *of(odd), odd / "walk.bvh")
    assert code == 1
    for path in of(odd):
        (line,) = [line for line in said.splitlines() if line.startswith(f"{path}:")]
        assert line.endswith(")") or "expected" in line


@parametrize(
    "words",
    [
        ("detect", "{odd}/fifo.bvh"),
        ("refine", "{odd}/to_fifo.npz", "-o", "{out}/x.npz"),
        ("diff", "{odd}/walk.bvh", "{odd}/device.bvh"),
        ("apply", "{odd}/fifo.amc", "{odd}/walk.bvh", "-o", "{out}/x.bvh"),
        ("apply", "{odd}", "{odd}", "-o", "{out}"),
        ("report", "{odd}/fifo.bvh", "-o", "{out}"),
        ("detect", "{odd}/walk.bvh", "--profile", "{odd}/fifo.bvh"),
        ("detect", "{odd}/walk.bvh", "--rig", "{odd}/to_fifo.bvh"),
        (
            "evaluate",
            "--clean",
            "{odd}/walk.bvh",
            "--refined",
            "{odd}/walk.bvh",
            "--truth",
            "{odd}/fifo.bvh",
        ),
        ("batch", "@{odd}/fifo.bvh", "-o", "{out}"),
    ],
    ids=lambda words: " ".join(words),
    quick=2,
)
def test_no_command_waits_for_a_writer(odd, tmp_path, ran, words):
    out = tmp_path / "out"
    (odd / "mine.twist.json").symlink_to("fifo.bvh")
    code, said = ran(*(word.format(odd=odd, out=out) for word in words))
    assert code in (1, 2), said
    assert not (out / "x.bvh").exists()


@pytest.mark.thorough
def test_a_folder_with_all_of_them_is_a_batch_of_what_can_be_read(odd, tmp_path, ran):
    code, said = ran("batch", odd, "-o", tmp_path / "out", "--workers", "1")
    assert code == 1
    assert "1 clip done" in said
    for kind in ("fifo", "loop", "astray", "to_fifo"):
        for suffix in ("bvh", "npz", "amc"):
            lines = [s for s in said.splitlines() if s.startswith(f"{odd}/{kind}.{suffix}:")]
            assert len(lines) == 1, (kind, suffix)


def test_in_a_folder_only_files_and_links_astray_are_clips(odd):
    names = [path.name for path in clip_paths_in_folder(odd)]
    astray = [f"{kind}.{end}" for kind in ("astray", "loop") for end in ("amc", "bvh", "npz")]
    assert names == sorted([*astray, "walk.bvh"])
