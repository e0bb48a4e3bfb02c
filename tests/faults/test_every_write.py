"""Each write x each fault: one clear error, the old bytes or the new, and nothing beside them."""

import ast
import contextlib
import errno
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults.writes import WRITES
from twistcore.errors import TwistError

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits and modes of POSIX")

ROOT = Path(__file__).parents[2]


@pytest.fixture(params=WRITES)
def write(request, tmp_path):
    """Does one write into a folder, which has one file of each name that it writes already."""
    folder = tmp_path / "folder"
    folder.mkdir()

    def make(into=folder):
        return WRITES[request.param](into)

    make.folder, make.name = folder, request.param
    return make


def content(folder):
    """Bytes of every file, what links lead to, and the names of folders."""
    return {
        path.relative_to(folder).as_posix(): (
            path.readlink()
            if path.is_symlink()
            else path.read_bytes()
            if path.is_file()
            else path.lstat().st_mode
        )
        for path in folder.rglob("*")
        if path.name != "corrected"
    }


def refused(write):
    """The one sentence in which it is refused."""
    with pytest.raises((OSError, TwistError)) as caught:
        write()
    said = str(caught.value)
    assert said
    assert "\n" not in said
    return caught.value


@pytest.fixture
def small(request):
    """No file of this process may be larger than so many bytes: the disk is full from there on."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    heard = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    def limit(size):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))

    yield limit
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, heard)


@pytest.mark.parametrize(("there", "room"), [(False, 0), (False, 16), (True, 16)])
def test_without_room_nothing_is_changed_and_nothing_left(write, small, there, room):
    if there:
        write()
    before = content(write.folder)
    small(room)
    if there and write.name == "corrected/x.bvh":
        write()  # the bytes are there: there is nothing to write
    else:
        refused(write)
    small(-1)
    assert content(write.folder) == before
    write()
    assert write.name in content(write.folder)


@pytest.mark.parametrize("call", ["os.fsync", "pathlib.Path.replace", "pathlib.Path.chmod"])
def test_an_error_at_the_end_leaves_nothing(write, monkeypatch, call):
    def fail(*_, **__):
        raise OSError(errno.EIO, "Input/output error")

    with monkeypatch.context() as patch:
        patch.setattr(call, fail)
        refused(write)
    assert content(write.folder) == {}
    write()


def test_a_folder_that_is_gone_is_told_or_made_again(write):
    shutil.rmtree(write.folder)
    with contextlib.suppress(OSError, TwistError):
        write()
    assert not write.folder.exists() or write.name in content(write.folder)


@pytest.mark.parametrize("kind", ["folder", "loop", "socketless link"])
def test_what_is_no_file_in_its_place_stays(write, kind):
    target = write.folder / write.name
    target.parent.mkdir(exist_ok=True)
    if kind == "folder":
        target.mkdir()
    else:
        target.symlink_to(target.name if kind == "loop" else "no/where")
    before = content(write.folder)
    refused(write)
    after = content(write.folder)
    assert after[write.name] == before[write.name]
    assert not [name for name in after if name.endswith(".part")]


def test_a_read_only_disk_is_told(write):
    words = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(write.folder)]
    if not shutil.which("mount") or subprocess.run(words, capture_output=True).returncode:
        pytest.skip("needs leave to mount")
    try:
        again = ["mount", "-o", "remount,ro", str(write.folder)]
        subprocess.run(again, check=True, capture_output=True)
        refused(write)
        assert content(write.folder) == {}
    finally:
        subprocess.run(["umount", str(write.folder)], check=True)


# -- there are no others ------------------------------------------------------------------------

# Modules that open files to write otherwise than by `atomic`, and why no half of one is taken for
# a whole.
OTHERS = {
    "twistcore/files/atomic.py": "the home of it",
    "twistcore/review/journal.py": "a line at a time, fsynced; one cut short is left out",
    "twistcore/batch/run.py": "the lock, which is empty",
    "inspector/session/review_lock.py": "the lock; empty, it is nobody's",
    "twistcore/batch/clip_task.py": "a copy in a temporary folder",
    "twistcore/formats/blender/process.py": "words for Blender in a temporary folder",
    "twistcore/report/picture_job.py": "words for the drawing process in a temporary folder",
    "inspector/recording/report_pictures.py": "pictures in that folder, all or none are taken",
    "twistcore/export/folder_replay.py": "a line at a time; one cut short is passed over",
    "twistcore/study/benchmark/runner.py": "a line at a time; one cut short is passed over",
    "twistcore/cli/command_line.py": "the null device",
    "twistcore/skeleton/known_words_file.py": "a source file, written by a developer's command",
    "twistcore/work/memory.py": "the system's own, by which a peak is forgotten",
    "inspector/shots.py": "pictures of these pages, by whoever makes them",
    "inspector/window/demo.py": "pictures of a demonstration, drawn again each time",
}


_NAMES = ("write_text", "write_bytes", "savez", "mkstemp")


def _writes(tree):
    """Lines of calls that open a file to write, by what they are called and with which words."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name = getattr(call.func, "attr", getattr(call.func, "id", ""))
        words = [str(a.value) for a in call.args if isinstance(a, ast.Constant)]
        mode = any(set(w) & set("wax+") and set(w) <= set("wxabrt+") for w in words)
        into = name == "open" and (mode or re.search("O_WRONLY|O_RDWR", ast.unparse(call)))
        saved = name == "save" and re.search("path", ast.unparse(call))
        saved = saved and "keeper" not in ast.unparse(call.func)
        if into or saved or name in _NAMES:
            yield call.lineno


@pytest.mark.thorough
def test_every_other_write_goes_through_the_one_home():
    found = {}
    for house in ("twistcore", "inspector"):
        for module in sorted((ROOT / house).rglob("*.py")):
            if lines := list(_writes(ast.parse(module.read_text("utf-8")))):
                found[module.relative_to(ROOT).as_posix()] = lines
    assert found.keys() - OTHERS.keys() == set(), "written otherwise than by twistcore.files.atomic"
