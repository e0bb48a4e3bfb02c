"""What a killed program left half written: removed by the next writing, and nothing else is."""

import fcntl
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from tests.twistcore.batch_folders import ROOT, environment
from twistcore.files.atomic import (
    open_temporary,
    temporary_file_path,
    write_atomically,
    writing_atomically,
)

pytestmark = pytest.mark.skipif(os.name != "posix", reason="of Windows, names alone are ours")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("name", ["walk.bvh", "w" * 230 + ".bvh", "w" * 251 + ".bvh", "ü" * 125])
def test_what_was_killed_in_the_middle_is_gone_after_the_next_writing(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"old")
    program = (
        "import os, sys\nfrom pathlib import Path\n"
        "from twistcore.files.atomic import writing_atomically\n"
        "with writing_atomically(Path(sys.argv[1])) as file:\n"
        "    file.write(b'half')\n    file.flush()\n    os.kill(os.getpid(), 9)\n"
    )
    command = [sys.executable, "-c", program, str(path)]
    subprocess.run(command, cwd=ROOT, env=environment(), check=False)
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == sorted([temporary_file_path(path).name, name])
    write_atomically(path, b"new")
    assert path.read_bytes() == b"new"
    assert names(tmp_path) == [name]


def test_who_writes_meanwhile_is_left_alone(tmp_path):
    path = tmp_path / "x"
    with writing_atomically(path) as one:
        one.write(b"one")
        one.flush()
        write_atomically(path, b"other")
        assert path.read_bytes() == b"other"
        assert temporary_file_path(path).read_bytes() == b"one"
    assert path.read_bytes() == b"one"
    assert names(tmp_path) == ["x"]


@pytest.mark.parametrize("kind", ["link", "astray", "folder", "fifo", "hard link", "another's"])
def test_what_is_not_ours_under_that_name_stays(tmp_path, kind):
    path = tmp_path / "x"
    part = temporary_file_path(path)
    (tmp_path / "precious").write_bytes(b"precious")
    match kind:
        case "link":
            part.symlink_to("precious")
        case "astray":
            part.symlink_to("nowhere")
        case "folder":
            part.mkdir()
        case "fifo":
            os.mkfifo(part)
        case "hard link":
            part.hardlink_to(tmp_path / "precious")
        case "another's":
            part.write_bytes(b"theirs")
            if os.geteuid():
                pytest.skip("only root gives files away")
            os.chown(part, 12345, 12345)
    before = part.lstat()
    write_atomically(path, b"new")
    assert path.read_bytes() == b"new"
    assert (tmp_path / "precious").read_bytes() == b"precious"
    assert (part.lstat().st_ino, part.lstat().st_mode) == (before.st_ino, before.st_mode)
    assert names(tmp_path) == sorted([part.name, "precious", "x"])


def test_a_file_system_without_locks_keeps_what_may_be_somebody_s(tmp_path, monkeypatch):
    path = tmp_path / "x"
    temporary_file_path(path).write_bytes(b"perhaps being written")

    def refuse(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(fcntl, "flock", refuse)
    write_atomically(path, b"new")
    assert path.read_bytes() == b"new"
    assert temporary_file_path(path).read_bytes() == b"perhaps being written"
    assert len(names(tmp_path)) == 2


def test_many_writers_of_one_file_at_once_leave_it_whole_and_alone(tmp_path):
    path = tmp_path / "x"
    wanted = [bytes([k]) * 5000 for k in range(8)]
    troubles = []

    def write(data):
        try:
            for _ in range(40):
                write_atomically(path, data)
        except BaseException as error:
            troubles.append(error)

    threads = [threading.Thread(target=write, args=(data,)) for data in wanted]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not troubles
    assert path.read_bytes() in wanted
    assert names(tmp_path) == ["x"]


def test_a_part_s_name_fits_where_its_file_s_does():
    for name in ("x", "x" * 255, "ü" * 127, "x" * 234, "x" * 235):
        part = temporary_file_path(Path(name), ".mp4")
        assert len(os.fsencode(part.name)) <= 245  # and a number in between
        assert part.name.endswith(".twist.part.mp4")


def test_the_folder_of_a_part_that_is_gone_is_told(tmp_path):
    with pytest.raises(FileNotFoundError):
        open_temporary(tmp_path / "no" / ".x.twist.part")
