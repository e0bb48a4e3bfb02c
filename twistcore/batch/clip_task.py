"""Process one clip as a task that can run in any process and on any machine.

The code that processes a clip is imported only when a task runs, so a process that only sends tasks
does not load numpy.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import field
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from twistcore.batch.parameters import Parameters
from twistcore.errors import TwistError
from twistcore.files.marks import sha256_of
from twistcore.formats.suffixes import known_formats
from twistcore.work.frozen import dataclass
from twistcore.work.memory import SPARE, limited_memory, peak_memory, reset_peak_memory

Bytes: TypeAlias = bytes  # Outcome has a field called `bytes`

_RACY_NS = 2_000_000_000  # a file changed this recently may change again with the same timestamp


@dataclass(frozen=True)
class ClipTask:
    """A clip to process, with everything that is needed to process it.

    Attributes
    ----------
    source
        Absolute path or URL of the clip.
    name
        The clip's name in the manifest.
    size
        Size of the file in bytes, 0 if unknown.
    parameters
        The processing parameters.
    memory
        Bytes of memory allowed in addition to the usual need of a clip of this size.
    data
        The contents of the file, if the process that runs the task cannot read the file. If None,
        the task reads the file.
    """

    source: str
    name: str
    size: int
    parameters: Parameters
    memory: int = SPARE
    data: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Outcome:
    """The outcome of processing a clip.

    Attributes
    ----------
    result
        The document 'twistcore.batch_clip/1' without the clip's name, or None if the task failed.
    reason
        A sentence that describes the failure, or an empty string.
    again
        True if the task may succeed when repeated.
    sha256, bytes, signature
        Hash, size and signature (:func:`file_change_signature`) of the file that was read. The
        signature is '' if it is not reliable.
    seconds, peak_bytes
        Time and memory used for processing.
    corrected
        The bytes of the corrected clip, or None.
    companions
        Files that the corrected clip needs in its folder, keyed by name.
    unseen
        True if the file does not exist on the machine that ran the task.
    """

    result: dict[str, Any] | None = None
    reason: str = ""
    again: bool = False
    sha256: str = ""
    bytes: int = 0
    signature: str = ""
    seconds: float = 0.0
    peak_bytes: int = 0
    corrected: Bytes | None = field(default=None, repr=False)
    companions: Mapping[str, Bytes] = field(default_factory=dict, repr=False)
    unseen: bool = False


def run_task(task: ClipTask) -> Outcome:
    """Run a task and return its outcome. Errors are described in the outcome and never raised."""
    begin = time.perf_counter()
    reset_peak_memory()
    found: dict[str, Any] = {}
    try:
        with limited_memory(task.size, task.memory):
            found |= _carried_out(task)
    except FileNotFoundError:
        found |= {
            "reason": f"{task.source}: the file does not exist",
            "again": True,
            "unseen": True,
        }
    except OSError as error:
        found |= {"reason": f"{task.source}: cannot be read ({error.strerror})", "again": True}
    except MemoryError:
        why = f"{task.name} needs more memory than is usual for its size"
        found |= {"reason": why, "again": True}
    except TwistError as error:
        found |= {"reason": " ".join(str(error).splitlines())}
    except Exception as error:  # a bug in this program must not stop the other clips
        why = " ".join(f"{task.name}: {type(error).__name__}: {error}".splitlines())
        found |= {"reason": why}
    return Outcome(**found, seconds=time.perf_counter() - begin, peak_bytes=peak_memory())


def file_change_signature(path: Path | str) -> tuple[str, bool]:
    """Return a file's signature, and whether it is reliable.

    The signature is a string that contains the file's size, modification time and inode. As long as
    a reliable signature does not change, the file has not changed. The signature of an AMC file
    also depends on the skeleton files in its folder, because the clip needs one of them. Raises
    OSError.
    """
    states = [Path(path).stat()]
    if companion := companion_file_suffix(path):
        with os.scandir(Path(path).parent) as entries:
            companions = sorted((e.name, e) for e in entries if e.name.lower().endswith(companion))
        for _, entry in companions:
            with suppress(OSError):  # ignore broken links
                states.append(entry.stat())
    texts = [f"{s.st_size} {s.st_mtime_ns} {s.st_ino}" for s in states]
    if texts[1:]:
        texts[1:] = [hashlib.sha256(" ".join(texts).encode()).hexdigest()[:16]]
    latest = max(status.st_mtime_ns for status in states)
    return " ".join(texts), time.time_ns() - latest > _RACY_NS


def needs_companion_files(path: Path | str) -> bool:
    """Return True if a clip needs other files, such as the skeleton file of an AMC clip."""
    return bool(companion_file_suffix(path))


def companion_file_suffix(path: Path | str) -> str:
    """Return the suffix of additional files that a clip needs, such as '.asf', or '' if none."""
    known = known_formats().get(Path(path).suffix.lower())
    return known.companion if known else ""


def _carried_out(task: ClipTask) -> dict[str, Any]:
    from twistcore.batch.clip_result import process_clip  # numpy, scipy

    with _on_this_disk(task) as path:
        before, settled = file_change_signature(path)
        if not path.is_file():  # opening a FIFO would wait for its writer
            raise TwistError(f"{path}: expected a regular file")
        try:
            clip, result, corrected = process_clip(path, task.parameters)
        except TwistError as error:
            path.open("rb").close()  # raises OSError if the file cannot be read
            known: dict[str, Any] = {"reason": " ".join(str(error).splitlines())}
            known |= {"bytes": path.stat().st_size, "sha256": sha256_of(path)}
        else:
            known = {"result": result, "corrected": corrected}
            known |= {} if corrected is None else {"companions": clip.companions}
            known |= {"bytes": len(clip.data), "sha256": clip.sha256}
        same = file_change_signature(path)[0] == before
    if "reason" in known and not same:  # the file was still being written and may now be complete
        known["again"] = True
    if same and settled and str(path) == task.source:
        known["signature"] = before
    return known


@contextmanager
def _on_this_disk(task: ClipTask) -> Iterator[Path]:
    """Yield the path of a task's clip, or of a temporary copy if the clip is not on this disk."""
    data = task.data
    if data is None and "://" in task.source:
        from twistcore.files.remote_files import read_remote_file

        data = read_remote_file(task.source)
    if data is None:
        yield Path(task.source)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder, PurePosixPath(task.name).name)
        path.write_bytes(data)
        yield path
