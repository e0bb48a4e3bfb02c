"""Writing: what is replaced, what is written into, what is refused."""

import errno
import os
import socket
import stat
import threading
from pathlib import Path

import pytest

from twistcore.files.atomic import (
    STANDARD_OUTPUT,
    is_standard_output,
    is_stream,
    move_into_place,
    resolve_write_path,
    write_atomically,
)

posix = pytest.mark.skipif(os.name != "posix", reason="Windows has neither FIFOs nor devices here")


def device(path, kind, major, minor):
    try:
        os.mknod(path, kind | 0o666, os.makedev(major, minor))
    except PermissionError:
        pytest.skip("only root makes devices")
    return path


def only(folder, *names):
    assert sorted(p.name for p in folder.iterdir()) == sorted(names)


def test_a_new_file_is_as_readable_as_any_and_an_old_one_stays_so(tmp_path):
    plain, kept = tmp_path / "plain", tmp_path / "kept"
    plain.touch()
    write_atomically(tmp_path / "new", b"new")
    assert (tmp_path / "new").stat().st_mode == plain.stat().st_mode
    kept.write_bytes(b"old")
    kept.chmod(0o640)
    write_atomically(kept, b"new")
    assert (kept.read_bytes(), stat.S_IMODE(kept.stat().st_mode)) == (b"new", 0o640)
    only(tmp_path, "kept", "new", "plain")


@posix
def test_the_owner_stays_where_files_may_be_given_away(tmp_path):
    path = tmp_path / "theirs"
    path.write_bytes(b"old")
    try:
        os.chown(path, 12345, 12346)
    except PermissionError:
        pytest.skip("only root gives files away")
    write_atomically(path, b"new")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 12346)


def test_another_hard_link_keeps_the_old_bytes(tmp_path):
    path, backup = tmp_path / "clip", tmp_path / "backup"
    path.write_bytes(b"old")
    backup.hardlink_to(path)
    write_atomically(path, b"new")
    assert (path.read_bytes(), backup.read_bytes()) == (b"new", b"old")


@pytest.mark.parametrize("there", [True, False])
@pytest.mark.parametrize("absolute", [True, False])
def test_links_are_followed_and_stay(tmp_path, there, absolute):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (tmp_path / "folder").symlink_to("elsewhere")
    end, second, first = folder / "end", tmp_path / "second", tmp_path / "first"
    second.symlink_to(end if absolute else "folder/../elsewhere/end")
    first.symlink_to("second")
    if there:
        end.write_bytes(b"old")
    write_atomically(first, b"new")
    assert first.is_symlink()
    assert second.is_symlink()
    assert not end.is_symlink()
    assert end.read_bytes() == b"new"
    only(folder, "end")
    only(tmp_path, "elsewhere", "first", "folder", "second")


def test_a_loop_of_links_is_one_sentence(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match="loop of symbolic links") as caught:
        write_atomically(tmp_path / "a", b"x")
    assert caught.value.errno == errno.ELOOP
    assert caught.value.filename == str(tmp_path / "a")
    only(tmp_path, "a", "b")


def test_a_link_into_no_folder_is_named_by_its_own_name(tmp_path):
    link = tmp_path / "link"
    link.symlink_to("nowhere/end")
    with pytest.raises(FileNotFoundError) as caught:
        write_atomically(link, b"x")
    assert caught.value.filename == str(link)


@posix
@pytest.mark.parametrize("linked", [False, True])
def test_a_fifo_is_written_into(tmp_path, linked):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    path = tmp_path / "link" if linked else fifo
    if linked:
        path.symlink_to("fifo")
    got = []
    reader = threading.Thread(target=lambda: got.append(fifo.read_bytes()))
    reader.start()
    data = bytes(range(256)) * 4096  # more than a pipe holds at once
    write_atomically(path, data)
    reader.join()
    assert got == [data]
    assert stat.S_ISFIFO(fifo.stat().st_mode)
    assert path.is_symlink() == linked


@posix
def test_a_reader_that_has_gone_is_a_broken_pipe(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        with pytest.raises(BrokenPipeError):
            write_atomically(STANDARD_OUTPUT.parent / "fd" / str(writer), b"x" * 1_000_000)
    finally:
        os.close(writer)


@posix
def test_a_device_is_written_into_and_stays(tmp_path):
    null = device(tmp_path / "null", stat.S_IFCHR, 1, 3)
    full = device(tmp_path / "full", stat.S_IFCHR, 1, 7)
    link = tmp_path / "link"
    link.symlink_to("null")
    for path in (null, link):
        assert is_stream(path)
        write_atomically(path, b"x")
    with pytest.raises(OSError, match="No space") as caught:
        write_atomically(full, b"x")
    assert caught.value.filename == str(full)
    assert stat.S_ISCHR(null.lstat().st_mode)
    assert link.is_symlink()
    only(tmp_path, "full", "link", "null")


@posix
def test_what_is_neither_is_refused_and_stays(tmp_path, monkeypatch):
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)  # a socket's address is short
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
    for name, what in (("folder", "a folder"), ("socket", "a socket")):
        kind = (tmp_path / name).stat().st_mode
        with pytest.raises(OSError, match=f"expected a file.*, found {what}"):
            write_atomically(tmp_path / name, b"x")
        assert (tmp_path / name).stat().st_mode == kind


@posix
def test_a_block_device_is_refused(tmp_path):
    path = device(tmp_path / "disk", stat.S_IFBLK, 7, 200)
    with pytest.raises(OSError, match="found a block device"):
        write_atomically(path, b"x")
    assert stat.S_ISBLK(path.stat().st_mode)


@posix
def test_an_open_descriptor_goes_on_where_it_is(tmp_path):
    with (tmp_path / "log").open("w+b", buffering=0) as file:
        file.write(b"first ")
        write_atomically(STANDARD_OUTPUT.parent / "fd" / str(file.fileno()), b"second ")
        file.write(b"third")
    assert (tmp_path / "log").read_bytes() == b"first second third"
    only(tmp_path, "log")


@posix
def test_standard_output_has_many_names(tmp_path):
    link = tmp_path / "link"
    link.symlink_to("/dev/stdout")
    for name in (STANDARD_OUTPUT, "/dev/fd/1", "/proc/self/fd/1", link):
        if Path(name).exists():
            assert is_standard_output(Path(name))
    for name in ("-", "/dev/fd/2", tmp_path / "1"):
        assert not is_standard_output(Path(name))


def test_a_minus_is_a_file_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_atomically(Path("-"), b"x")
    assert (tmp_path / "-").read_bytes() == b"x"


def test_a_finished_file_takes_its_place(tmp_path):
    end, link = tmp_path / "end.mp4", tmp_path / "link.mp4"
    end.write_bytes(b"old")
    end.chmod(0o600)
    link.symlink_to("end.mp4")
    part = resolve_write_path(link).with_name("part")
    part.write_bytes(b"film")
    move_into_place(part, resolve_write_path(link))
    assert link.is_symlink()
    assert (end.read_bytes(), stat.S_IMODE(end.stat().st_mode)) == (b"film", 0o600)
    only(tmp_path, "end.mp4", "link.mp4")


@posix
def test_the_folder_reaches_the_disk_behind_the_file(tmp_path, monkeypatch):
    order = []
    monkeypatch.setattr(
        "os.fsync", lambda handle: order.append(stat.S_IFMT(os.fstat(handle).st_mode))
    )
    write_atomically(tmp_path / "x", b"x")
    assert order == [stat.S_IFREG, stat.S_IFDIR]


@posix
def test_a_file_system_that_does_not_sync_folders_is_no_failure(tmp_path, monkeypatch):
    def refuse(handle):
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr("os.fsync", refuse)
    write_atomically(tmp_path / "x", b"x")
    assert (tmp_path / "x").read_bytes() == b"x"


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "x"
    path.write_bytes(b"old")

    def fail(handle):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="Input/output") as caught:
        write_atomically(path, b"new")
    assert caught.value.filename == str(path)
    assert path.read_bytes() == b"old"
    only(tmp_path, "x")
