"""Merge batch folders, such as the shards of a large batch, into one."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

from twistcore.batch.clip_task import companion_of
from twistcore.batch.corrected_files import write_corrected
from twistcore.batch.inputs import Source, with_stored_names
from twistcore.batch.manifest import DONE, FAILED, Manifest, ManifestRow
from twistcore.batch.run import locked
from twistcore.errors import TwistError
from twistcore.files.atomic import same_file
from twistcore.files.ordinary import read_file


@dataclass
class Merged:
    """What a merge found.

    Parameters
    ----------
    done
        Number of clips that have a result.
    waiting
        Number of clips that have not been processed.
    failed
        A sentence for each clip that could not be processed.
    problems
        A sentence for each corrected file that could not be copied.
    """

    done: int = 0
    waiting: int = 0
    failed: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def merge(folders: Sequence[Path], output: Path) -> Merged:
    """Add the clips, results, decisions and corrected files of batch folders to one folder.

    The folder is created if needed; its own clips are kept. If several folders have the same clip,
    the latest result counts. Clips of different folders that have the same name get new names. The
    given folders are not changed. Raises TwistError if a folder is not a batch folder, or if its
    manifest is damaged; the output folder then gets no results.
    """
    for folder in folders:
        if same_file(folder, output):
            raise TwistError(f"{folder}: expected another folder than the output folder")
    with ExitStack() as stack:
        others = [stack.enter_context(Manifest.open(folder)) for folder in folders]
        stack.enter_context(locked(output))
        manifest = stack.enter_context(Manifest.open(output, create=True))
        known, merged = manifest.rows(), Merged()
        with manifest.transaction():
            manifest.put_rows(
                _copied(output, folder, row, known.get(row.source), merged)
                for folder, row in _latest(others, known)
            )
            for other in others:
                manifest.take_over(other)
        for row in manifest.rows().values():
            merged.done += row.state == DONE
            if row.state == FAILED:
                merged.failed.append(row.reason)
        merged.waiting = len(manifest.rows()) - merged.done - len(merged.failed)
    return merged


def _latest(
    manifests: Sequence[Manifest], known: dict[str, ManifestRow]
) -> Iterator[tuple[Path, ManifestRow]]:
    """Yield the rows that are later than the known ones, with names that differ from each other."""
    latest: dict[str, tuple[Path, ManifestRow]] = {}
    for manifest in manifests:
        for source, row in manifest.rows().items():
            before = latest[source][1] if source in latest else known.get(source)
            if before is None or _rank(row) > _rank(before):
                latest[source] = manifest.folder, row
    names = {source: row.name for source, row in known.items()}
    found = [Source(row.source, row.name) for _, row in latest.values()]
    for named in with_stored_names(found, names):
        folder, row = latest[named.path]
        yield folder, replace(row, name=named.name)


def _rank(row: ManifestRow) -> tuple[bool, str]:
    """Return the order of rows of a clip: a processed clip counts more than a waiting one."""
    return row.state in (DONE, FAILED), row.finished_at


def _copied(
    output: Path, folder: Path, row: ManifestRow, known: ManifestRow | None, merged: Merged
) -> ManifestRow:
    """Copy the corrected file of a row into the output folder, and return the row for it."""
    earlier = known.corrected_sha256 if known is not None else ""
    plain = replace(row, corrected="", corrected_sha256=earlier, corrected_signature="")
    if not row.corrected:
        return plain
    path = folder / row.corrected
    try:
        data = read_file(path)
        if hashlib.sha256(data).hexdigest() == row.corrected_sha256:
            return write_corrected(output, plain, known, data, _companions(path))
        why = f"{path} has been changed since it was written"
    except TwistError as error:
        why = str(error)
    except OSError as error:
        why = f"{path} cannot be copied ({error.strerror})"
    merged.problems.append(f"{row.name}: {why}")
    return plain


def _companions(path: Path) -> dict[str, bytes]:
    """Return the files in a clip's folder that it may need, keyed by name."""
    ending = companion_of(path)
    if not ending:
        return {}
    near = (other for other in path.parent.iterdir() if other.suffix.lower() == ending)
    return {other.name: read_file(other) for other in near}
