"""Read and write files at URLs with fsspec: object stores, web servers and other services."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any

from twistcore.errors import TwistError


def list_remote_files(url: str, *, may_be_none: bool = False) -> Iterator[tuple[str, str, int]]:
    """Yield the URL, relative name (with '/') and size in bytes of each file at or below a URL.

    Set `may_be_none` to True if a URL without files is not an error. Raises TwistError if fsspec is
    not installed or the URL cannot be reached.
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
    except Exception as error:  # each service has its own exceptions
        raise _refused(url, error) from None


def read_remote_file(url: str) -> bytes:
    """Return the bytes of the file at a URL. Raises TwistError if it cannot be read."""
    files, path = _opened(url)
    try:
        data: bytes = files.cat_file(path)
    except FileNotFoundError:
        raise TwistError(f"{url}: the file does not exist") from None
    except Exception as error:
        raise _refused(url, error) from None
    return data


def write_remote_file(url: str, data: bytes) -> None:
    """Write bytes to a URL, atomically if possible. Raises TwistError if they cannot be written."""
    files, path = _opened(url)
    try:
        files.makedirs(str(PurePosixPath(path).parent), exist_ok=True)
        files.pipe_file(path, data)
    except Exception as error:
        raise _refused(url, error) from None


def _opened(url: str) -> tuple[Any, str]:
    """Return the fsspec file system of a URL, and the path within it.

    Raises TwistError if fsspec is not installed or does not support the URL.
    """
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise TwistError(
            'a URL needs fsspec: install it with pip install "twist-inspector[remote]"'
        ) from None
    try:
        files, path = url_to_fs(url)
    except Exception as error:  # an unknown protocol, or its library is not installed
        raise _refused(url, error) from None
    return files, str(path)


def _refused(url: str, error: Exception) -> TwistError:
    why = " ".join(str(error).splitlines()) or type(error).__name__
    return TwistError(f"{url}: cannot be reached ({why})")
