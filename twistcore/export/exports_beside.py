"""Corrected clips that this program wrote beside their sources, told from clips of their own.

What starts without numpy asks this for every clip of a folder, so names decide as far as they can.
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

from twistcore.files.kinds import PICKLE, kind_of
from twistcore.files.wide_text import narrow_head

EXPORT_MARK = "_refined"  # behind a clip's name, where a person gives no other
REPLAY_SUFFIX = ".replay.json"  # what an export did: never a review that goes on
_REPORT_SUFFIX = ".report.json"
_DOCUMENTS = (REPLAY_SUFFIX, _REPORT_SUFFIX)
_HEAD = 200_000  # bytes: more than the skeletons that there are need


def exports_among(clips: Iterable[Path]) -> dict[Path, str]:
    """Those of the clips that this program wrote, and the file name of what each is from.

    The session that replays it, or its report, tells; else the name that exports get by default,
    where all before the motion is the source's. One whose source is not among those clips that lie
    in its folder is a clip.
    """
    by_folder: dict[Path, list[str]] = defaultdict(list)
    for path in clips:
        by_folder[path.parent].append(path.name)
    return {
        folder / name: source
        for folder, names in by_folder.items()
        for name, source in exports_in(folder, names).items()
    }


def without_exports(clips: Iterable[Path]) -> list[Path]:
    """The clips less what :func:`exports_among` tells, in their order."""
    paths = list(clips)
    exported = exports_among(paths)
    return [path for path in paths if path not in exported]


def exports_in(folder: Path | str, clips: Collection[str]) -> dict[str, str]:
    """As :func:`exports_among`, of clips in one folder by their names.

    Only clips with such a document beside them, or with such a name, are looked at.
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
        told = ""
        for document in _documents_of(name, stem):
            if document in documents and not told:
                told = _told_source(os.path.join(folder, document), name)  # noqa: PTH118
        if told:
            if told != name and told in names:
                found[name] = told
        elif source != name and source in names:
            head = _head(os.path.join(folder, name))  # noqa: PTH118
            if head == _head(os.path.join(folder, source)):  # noqa: PTH118
                found[name] = source
    return found


def clip_of_session(session: Path) -> str:
    """The file name of the clip that a session says it is of, '' where it says none."""
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
    """Names of what may tell of an export.

    They begin with its whole name or, as those of every BVH do, with its stem.
    """
    for suffix in _DOCUMENTS:
        yield name + suffix
        yield stem + suffix


def _told_source(document: str, export: str) -> str:
    """The name of the clip that a document says an export beside it is from, '' for none."""
    with suppress(OSError):
        status = os.stat(document)  # noqa: PTH116
        if stat.S_ISREG(status.st_mode):  # to open a FIFO would wait for somebody
            return _read_source(document, export, status.st_mtime_ns, status.st_size)
    return ""


@lru_cache(maxsize=10_000)
def _read_source(document: str, export: str, modified: int, size: int) -> str:
    del modified, size  # by them it is read again when it was written again
    with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
        content = json.loads(Path(document).read_bytes())
        source = PurePath(content["clip"])
        if document.endswith(_REPORT_SUFFIX) and export not in content["files"]:
            return ""
        # An export is of its source's format: x.amc is not what lies in x.replay.json of x.bvh.
        same = source.suffix.lower() == PurePath(export).suffix.lower()
        return source.name if same else ""
    return ""


def _head(clip: str) -> bytes:
    """What a clip has before its motion, b'' where it cannot be told."""
    with suppress(OSError):
        status = os.stat(clip)  # noqa: PTH116
        if stat.S_ISREG(status.st_mode):
            return _read_head(clip, status.st_mtime_ns, status.st_size)
    return b""


@lru_cache(maxsize=10_000)
def _read_head(clip: str, modified: int, size: int) -> bytes:
    del modified
    import zipfile  # takes a while, and few need it

    with Path(clip).open("rb") as file:
        if not zipfile.is_zipfile(file):
            file.seek(0)
            head = narrow_head(file.read(_HEAD))
            if kind_of(head) is PICKLE:  # whose arrays are replaced by others of their size
                return str(size).encode() + head.partition(b"smpl_poses")[0]
            return head.partition(b"MOTION")[0]
        with suppress(zipfile.BadZipFile), zipfile.ZipFile(file) as archive:
            return repr([(i.filename, i.file_size) for i in archive.infolist()]).encode()
    return b""
