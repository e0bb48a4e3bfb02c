"""Recognise the corrected clips that this program has written next to the original clips.

This module examines every clip in a folder, even in programs that do not load numpy. Therefore, it
mostly uses file names and opens few files.
"""

from __future__ import annotations

import json
import os
import stat
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path, PurePath

from twistcore.files.kinds import PICKLE, detect_file_kind
from twistcore.files.wide_text import first_bytes_as_utf8

EXPORT_MARK = "_refined"  # by default, the end of a corrected clip's stem
REPLAY_SUFFIX = ".replay.json"  # suffix of a session that repeats an export
_REPORT_SUFFIX = ".report.json"
_DOCUMENTS = (REPLAY_SUFFIX, _REPORT_SUFFIX)
_HEAD = 200_000  # bytes to read from the start of a clip, more than any known skeleton needs


def find_exports_and_their_sources(clips: Iterable[Path]) -> dict[Path, str]:
    """Return the clips that this program exported, each with the file name of its source.

    The source is named in the session that replays the clip, or in the clip's report. A clip that
    has neither of these is an export if it has an export's default name and equals its source up to
    the motion data. A clip whose source is not in the same folder is not an export.
    """
    by_folder: dict[Path, list[str]] = defaultdict(list)
    for path in clips:
        by_folder[path.parent].append(path.name)
    return {
        folder / name: source
        for folder, names in by_folder.items()
        for name, source in find_exports_in_folder(folder, names).items()
    }


def exclude_previously_exported_clips(clips: Iterable[Path]) -> list[Path]:
    """Return the clips that are not exports, in the same order.

    See :func:`find_exports_and_their_sources`.
    """
    paths = list(clips)
    exported = find_exports_and_their_sources(paths)
    return [path for path in paths if path not in exported]


def find_exports_in_folder(folder: Path | str, clips: Collection[str]) -> dict[str, str]:
    """Return the sources of the exports among the clips of one folder, keyed by name.

    Only clips that have a session or report, or the name of an export, are examined (see
    :func:`find_exports_and_their_sources`).
    """
    names, found = frozenset(clips), {}
    try:
        with os.scandir(folder) as entries:
            documents = {e.name for e in entries if e.name.endswith(_DOCUMENTS)}
    except OSError:
        documents = set()
    for name in clips:
        stem, suffix = os.path.splitext(name)  # noqa: PTH122 of a million names
        source = stem.removesuffix(EXPORT_MARK) + suffix
        documented = ""
        for document in _documents_of(name, stem):
            if document in documents and not documented:
                documented = _documented_source(os.path.join(folder, document), name)  # noqa: PTH118
        if documented:
            if documented != name and documented in names:
                found[name] = documented
        elif source != name and source in names:
            head = _head(os.path.join(folder, name))  # noqa: PTH118
            if head == _head(os.path.join(folder, source)):  # noqa: PTH118
                found[name] = source
    return found


def clip_name_from_session_file(session: Path) -> str:
    """Return the file name of the clip that a session names, or ''."""
    with suppress(OSError):
        status = session.stat()
        if stat.S_ISREG(status.st_mode):
            return _read_clip(session, status.st_mtime_ns, status.st_size)
    return ""


@lru_cache(maxsize=10_000)
def _read_clip(session: Path, modified: int, size: int) -> str:
    del modified, size
    with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
        return PurePath(json.loads(session.read_bytes())["clip"]).name
    return ""


def _documents_of(name: str, stem: str) -> Iterator[str]:
    """Yield the names of the sessions and reports that may describe an export.

    `name` is the export's file name and `stem` is the name without suffix. Either may be the start
    of the document's name.
    """
    for suffix in _DOCUMENTS:
        yield name + suffix
        yield stem + suffix


def _documented_source(document: str, export: str) -> str:
    """Return the name of an export's source, as named in a session or report, or ''."""
    with suppress(OSError):
        status = os.stat(document)  # noqa: PTH116
        if stat.S_ISREG(status.st_mode):  # opening a FIFO would wait for its writer
            return _read_source(document, export, status.st_mtime_ns, status.st_size)
    return ""


@lru_cache(maxsize=10_000)
def _read_source(document: str, export: str, modified: int, size: int) -> str:
    del modified, size  # part of the cache key, so that a changed file is read again
    with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
        content = json.loads(Path(document).read_bytes())
        source = PurePath(content["clip"])
        if document.endswith(_REPORT_SUFFIX) and export not in content["files"]:
            return ""
        # An export has its source's format, so x.replay.json of x.bvh does not describe x.amc.
        same = source.suffix.lower() == PurePath(export).suffix.lower()
        return source.name if same else ""
    return ""


def _head(clip: str) -> bytes:
    """Return the part of a clip before its motion, or b'' if the clip cannot be read."""
    with suppress(OSError):
        status = os.stat(clip)  # noqa: PTH116
        if stat.S_ISREG(status.st_mode):
            return _read_head(clip, status.st_mtime_ns, status.st_size)
    return b""


@lru_cache(maxsize=10_000)
def _read_head(clip: str, modified: int, size: int) -> bytes:
    del modified
    import zipfile  # slow to load, and few calls need it

    with Path(clip).open("rb") as file:
        if not zipfile.is_zipfile(file):
            file.seek(0)
            head = first_bytes_as_utf8(file.read(_HEAD))
            if detect_file_kind(head) is PICKLE:  # an export has other arrays of equal size
                return str(size).encode() + head.partition(b"smpl_poses")[0]
            return head.partition(b"MOTION")[0]
        with suppress(zipfile.BadZipFile), zipfile.ZipFile(file) as archive:
            return repr([(i.filename, i.file_size) for i in archive.infolist()]).encode()
    return b""
