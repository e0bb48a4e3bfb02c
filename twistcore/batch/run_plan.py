"""What of all clips is to be done: what is new, or may end otherwise than last time."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from twistcore.batch.clip_task import has_companions
from twistcore.batch.inputs import Source
from twistcore.batch.manifest import DONE, FAILED, Manifest, ManifestRow, now
from twistcore.batch.parameters import Parameters
from twistcore.files.marks import sha256_of


@dataclass
class Plan:
    """todo: clips to process; known: how many need nothing; failed: rows of failures that stay.

    rows: those of all clips that the manifest had; notes: rows to put down as they are by now.
    """

    rows: Mapping[str, ManifestRow]
    todo: list[Source] = field(default_factory=list)
    known: int = 0
    failed: list[ManifestRow] = field(default_factory=list)
    notes: list[ManifestRow] = field(default_factory=list)


def make_plan(
    manifest: Manifest,
    sources: Sequence[Source],
    parameters: Parameters,
    intact: Callable[[ManifestRow], bool],
) -> Plan:
    """Look every clip up, by its signature or, where that says nothing, by the hash of its bytes.

    intact: whether what was written of a clip is still there. A clip of other bytes, another
    version or other parameters is new; bytes that are known under another name are not. A failure
    that lay in the clip itself stays; one of time, memory or the disk is tried again.
    """
    plan = Plan(manifest.rows())
    mark, sizes = parameters.mark, manifest.sizes(parameters.mark)
    for source in sources:
        row = plan.rows.get(source.path)
        if row is None:
            row = ManifestRow(source.path, source.name)
            plan.notes.append(row)
        found = _same_bytes(row, source) if row.mark == mark else None
        if found is None or (row.state == DONE and parameters.refine and not intact(row)):
            found = None
        elif row.state == FAILED and not row.again:
            plan.failed.append(found)
        elif row.state != DONE:
            found = None
        if found is None and not parameters.refine:
            found = _of_other_name(manifest, row, source, mark, sizes)
        if found is None:
            plan.todo.append(source)
            continue
        plan.known += found.state == DONE
        if found != row:
            plan.notes.append(found)
    # The longest first: a long clip that starts last would keep one core busy and the rest idle.
    plan.todo.sort(key=lambda source: (-source.size, source.name))
    return plan


def shard_sources(sources: Iterable[Source], index: int, count: int) -> list[Source]:
    """The clips of one of so many shards, 1…count, by their names alone."""

    def of(source: Source) -> int:
        return int.from_bytes(hashlib.sha256(source.name.encode("utf-8", "surrogatepass")).digest())

    return [source for source in sources if of(source) % count == index - 1]


def _same_bytes(row: ManifestRow, source: Source) -> ManifestRow | None:
    """The row, with the file's signature, if it tells of the bytes that the file has by now."""
    if source.signature and source.signature == row.signature:
        return row
    if not source.signature:  # gone, or at a URL
        return row if "://" in source.path and source.size == row.bytes else None
    if has_companions(source.path) or source.size != row.bytes or _sha256(source) != row.sha256:
        return None
    return replace(row, signature=source.signature if source.settled else "")


def _of_other_name(
    manifest: Manifest, row: ManifestRow, source: Source, mark: str, sizes: frozenset[int]
) -> ManifestRow | None:
    """The row as done, where the same bytes have a result under whatever name."""
    if not source.signature or has_companions(source.path) or source.size not in sizes:
        return None
    sha256 = _sha256(source)
    if not sha256 or not manifest.has_result(sha256, mark):
        return None
    signature = source.signature if source.settled else ""
    new = ManifestRow(row.source, row.name, DONE, mark=mark, sha256=sha256, bytes=source.size)
    return replace(new, signature=signature, finished_at=now())


def _sha256(source: Source) -> str:
    path = Path(source.path)
    try:
        return sha256_of(path) if path.is_file() else ""  # to open a FIFO would wait
    except OSError:  # who processes it says so
        return ""
