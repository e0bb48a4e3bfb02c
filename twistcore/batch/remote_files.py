"""Clips at URLs, by fsspec: on object stores, web servers and whatever else it has a name for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any

from twistcore.errors import TwistError


def find_remote(url: str, *, may_be_none: bool = False) -> Iterator[tuple[str, str, int]]:
    """The files at a URL, or below it: their URL, name below it with '/', and bytes.

    may_be_none: whether nothing at all may be there. TwistError where fsspec is not installed or
    nothing can be reached.
    """
    files, root = _opened(url)
    try:
        if files.isfile(root):
            yield url, PurePosixPath(root).name, int(files.size(root) or 0)
            return
        for path, about in sorted(files.find(root, detail=True).items()):
            name = PurePosixPath(path).relative_to(root).as_posix()
            if not any(part.startswith(".") for part in PurePosixPath(name).parts):
                yield files.unstrip_protocol(path), name, int(about.get("size") or 0)
    except FileNotFoundError as error:
        if not may_be_none:
            raise _refused(url, error) from None
    except Exception as error:  # as many kinds as there are services
        raise _refused(url, error) from None


def read_remote(url: str) -> bytes:
    """The bytes of a file; TwistError."""
    files, path = _opened(url)
    try:
        data: bytes = files.cat_file(path)
    except FileNotFoundError:
        raise TwistError(f"{url}: there is no such file") from None
    except Exception as error:
        raise _refused(url, error) from None
    return data


def write_remote(url: str, data: bytes) -> None:
    """Put bytes at a URL, whole or not at all as far as the service keeps that; TwistError."""
    files, path = _opened(url)
    try:
        files.makedirs(str(PurePosixPath(path).parent), exist_ok=True)
        files.pipe_file(path, data)
    except Exception as error:
        raise _refused(url, error) from None


def _opened(url: str) -> tuple[Any, str]:
    """A file system of fsspec and the path in it."""
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise TwistError(
            'a URL needs fsspec: expected pip install "twist-inspector[remote]"'
        ) from None
    try:
        files, path = url_to_fs(url)
    except Exception as error:  # a protocol that is unknown, or whose library is not installed
        raise _refused(url, error) from None
    return files, str(path)


def _refused(url: str, error: Exception) -> TwistError:
    said = " ".join(str(error).splitlines()) or type(error).__name__
    return TwistError(f"{url}: cannot be reached ({said})")
