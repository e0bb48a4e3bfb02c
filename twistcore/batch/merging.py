"""Merge batch folders into one folder.

A large batch can be divided into parts, called shards, that are processed on several machines. The
resulting batch folders are then merged.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

from twistcore.batch.clip_task import companion_file_suffix
from twistcore.batch.corrected_files import write_corrected
from twistcore.batch.inputs import Source, assign_batch_names
from twistcore.batch.manifest import DONE, FAILED, Manifest, ManifestRow
from twistcore.batch.run import lock_batch_folder
from twistcore.errors import TwistError
from twistcore.files.atomic import same_file
from twistcore.files.ordinary import read_file


@dataclass
class Merged:
    """The result of merging batch folders: clip counts and problems.

    Parameters
    ----------
    done
        Number of clips in the output folder that have a result.
    waiting
        Number of clips in the output folder that have not been processed.
    failed
        A sentence for each clip that could not be processed.
    problems
        A sentence for each corrected file that could not be copied.
    """

    done: int = 0
    waiting: int = 0
    failed: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def merge_batch_folders(folders: Sequence[Path], output: Path) -> Merged:
    """Add the clips, results, decisions and corrected files of batch folders to one folder.

    If several folders have the same clip, the latest result is used. If different clips have the
    same name, all but one get new names.

    Parameters
    ----------
    folders
        The batch folders to merge, which are not changed.
    output
        The output folder. If it does not exist, it is created; if it is a batch folder, its clips
        are kept.

    Returns
    -------
    Merged
        The clip counts of the output folder, and the problems.

    Raises
    ------
    TwistError
        If one of `folders` is the output folder or is not a batch folder, or if its manifest is
        damaged. No results are then added to the output folder.
    """
    for folder in folders:
        if same_file(folder, output):
            raise TwistError(f"{folder}: expected a folder other than the output folder")
    with ExitStack() as stack:
        others = [stack.enter_context(Manifest.open(folder)) for folder in folders]
        stack.enter_context(lock_batch_folder(output))
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
    """Yield the folder and the latest row of each clip that is missing or older in `known`.

    Parameters
    ----------
    manifests
        The manifests of the folders to merge.
    known
        The rows of the output folder, keyed by source. These clips keep their names. Other clips
        are renamed if their names are already in use.
    """
    latest: dict[str, tuple[Path, ManifestRow]] = {}
    for manifest in manifests:
        for source, row in manifest.rows().items():
            before = latest[source][1] if source in latest else known.get(source)
            if before is None or _rank(row) > _rank(before):
                latest[source] = manifest.folder, row
    names = {source: row.name for source, row in known.items()}
    found = [Source(row.source, row.name) for _, row in latest.values()]
    for named in assign_batch_names(found, names):
        folder, row = latest[named.path]
        yield folder, replace(row, name=named.name)


def _rank(row: ManifestRow) -> tuple[bool, str]:
    """Return a key that ranks the rows of the same clip in several folders.

    The row with the largest key is used. A row of a processed clip ranks above a row of a waiting
    clip. Of two rows of the same kind, the later one ranks higher.
    """
    return row.state in (DONE, FAILED), row.finished_at


def _copied(
    output: Path, folder: Path, row: ManifestRow, known: ManifestRow | None, merged: Merged
) -> ManifestRow:
    """Copy a clip's corrected file, and return the clip's row for the output folder.

    If the file cannot be copied, a sentence is added to `merged.problems`.

    Parameters
    ----------
    output
        The output folder.
    folder
        The batch folder from which to copy.
    row
        The row of the clip in that folder.
    known
        The row of the clip in the output folder, or None.
    merged
        The result of the merge.
    """
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
    """Return the contents of the additional files that a clip may need, keyed by file name.

    These are all files in the clip's folder with the suffix that its format needs, such as .asf.
    """
    ending = companion_file_suffix(path)
    if not ending:
        return {}
    near = (other for other in path.parent.iterdir() if other.suffix.lower() == ending)
    return {other.name: read_file(other) for other in near}
