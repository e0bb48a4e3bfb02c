"""Plan a batch run: find new clips, and failed clips that should be processed again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from twistcore.batch.clip_task import needs_companion_files
from twistcore.batch.inputs import Source
from twistcore.batch.manifest import DONE, FAILED, Manifest, ManifestRow, manifest_timestamp
from twistcore.batch.parameters import Parameters
from twistcore.files.marks import sha256_of


@dataclass
class Plan:
    """The plan of a batch run: the clips to process, and the clips with known results.

    Attributes
    ----------
    rows
        The manifest's rows of all clips, keyed by source.
    todo
        Clips to process.
    known
        Number of clips that have a result.
    failed
        Rows of clips that failed permanently.
    notes
        Rows to store before the run.
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
    """Return a plan with the clips that must be processed.

    A clip is recognised by its signature or, if the signature is unknown, by the hash of its bytes.
    It must be processed if its bytes, the program version or the parameters have changed. A new
    name alone is no reason to process a clip. A failure caused by the clip itself is permanent. A
    clip that failed for lack of time, memory or disk space is processed again.

    Parameters
    ----------
    manifest
        The manifest of the batch folder.
    sources
        The clips.
    parameters
        The processing parameters.
    intact
        A function that returns True if the corrected file of a row is unchanged.
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
    # Start with the largest clips, since a long clip at the end would leave other cores idle.
    plan.todo.sort(key=lambda source: (-source.size, source.name))
    return plan


def shard_sources(sources: Iterable[Source], index: int, count: int) -> list[Source]:
    """Return the clips that belong to the shard `index`, counted from 1, of `count` shards.

    The hash of a clip's name determines its shard.
    """

    def of(source: Source) -> int:
        return int.from_bytes(hashlib.sha256(source.name.encode("utf-8", "surrogatepass")).digest())

    return [source for source in sources if of(source) % count == index - 1]


def _same_bytes(row: ManifestRow, source: Source) -> ManifestRow | None:
    """Return the row with the file's current signature, or None if the bytes have changed."""
    if source.signature and source.signature == row.signature:
        return row
    if not source.signature:  # missing, or at a URL
        return row if "://" in source.path and source.size == row.bytes else None
    if (
        needs_companion_files(source.path)
        or source.size != row.bytes
        or _sha256(source) != row.sha256
    ):
        return None
    return replace(row, signature=source.signature if source.settled else "")


def _of_other_name(
    manifest: Manifest, row: ManifestRow, source: Source, mark: str, sizes: frozenset[int]
) -> ManifestRow | None:
    """Return the row, marked as done, if a file with the same bytes has a result, and None if not.

    `mark` is the hash of the parameters, and `sizes` are the sizes of all files with a result.
    """
    if not source.signature or needs_companion_files(source.path) or source.size not in sizes:
        return None
    sha256 = _sha256(source)
    if not sha256 or not manifest.has_result(sha256, mark):
        return None
    signature = source.signature if source.settled else ""
    new = ManifestRow(row.source, row.name, DONE, mark=mark, sha256=sha256, bytes=source.size)
    return replace(new, signature=signature, finished_at=manifest_timestamp())


def _sha256(source: Source) -> str:
    path = Path(source.path)
    try:
        return sha256_of(path) if path.is_file() else ""  # opening a FIFO would wait
    except OSError:  # processing reports the error
        return ""
