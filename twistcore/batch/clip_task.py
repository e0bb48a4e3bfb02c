"""One clip as a task: sent to any process or machine, it comes back with the same outcome.

What carries it out is loaded there, so that who sends thousands loads no numpy.
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
from twistcore.work.memory import SPARE, forget_peak, limited_memory, peak_memory

Bytes: TypeAlias = bytes  # an outcome has a number of them by that name

_RACY_NS = 2_000_000_000  # a file written so lately may change again within its own time stamp


@dataclass(frozen=True)
class ClipTask:
    """source: absolute path or URL; name: the clip's in the manifest; size: bytes, 0 if unknown.

    memory: bytes beyond what a clip of its size should need; data: the file's bytes, for a process
    that does not see it, else None.
    """

    source: str
    name: str
    size: int
    parameters: Parameters
    memory: int = SPARE
    data: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Outcome:
    """What became of a clip.

    result: the document 'twistcore.batch_clip/1' without the clip's name, or None where there is a
    reason, one sentence; again: whether another try may end otherwise; sha256, bytes, signature: of
    the file that was read, '' where it may change unseen; corrected: the bytes of the corrected
    clip, or None; companions: what has to lie beside it, by name; unseen: the file is not to be
    seen from where the task was carried out.
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


def process(task: ClipTask) -> Outcome:
    """Carry a task out; raises nothing that has to do with the clip."""
    begin = time.perf_counter()
    forget_peak()
    found: dict[str, Any] = {}
    try:
        with limited_memory(task.size, task.memory):
            found |= _carried_out(task)
    except FileNotFoundError:
        found |= {"reason": f"{task.source}: there is no such file", "again": True, "unseen": True}
    except OSError as error:
        found |= {"reason": f"{task.source}: cannot be read ({error.strerror})", "again": True}
    except MemoryError:
        said = f"{task.name}: needs more memory than a clip of its size should"
        found |= {"reason": said, "again": True}
    except TwistError as error:
        found |= {"reason": " ".join(str(error).splitlines())}
    except Exception as error:  # a defect of ours must not stop the other clips
        said = " ".join(f"{task.name}: {type(error).__name__}: {error}".splitlines())
        found |= {"reason": said}
    return Outcome(**found, seconds=time.perf_counter() - begin, peak_bytes=peak_memory())


def signature_of(path: Path | str) -> tuple[str, bool]:
    """A file's size, time and number: while they stay, its bytes do; raises OSError.

    And whether it was written so long ago that a change would show in its time. Of an AMC with
    those of the skeletons in its folder, of which it needs one.
    """
    states = [Path(path).stat()]
    if companion := _companion(path):
        with os.scandir(Path(path).parent) as entries:
            beside = sorted((e.name, e) for e in entries if e.name.lower().endswith(companion))
        for _, entry in beside:
            with suppress(OSError):  # a link astray is no skeleton
                states.append(entry.stat())
    texts = [f"{s.st_size} {s.st_mtime_ns} {s.st_ino}" for s in states]
    if texts[1:]:
        texts[1:] = [hashlib.sha256(" ".join(texts).encode()).hexdigest()[:16]]
    latest = max(status.st_mtime_ns for status in states)
    return " ".join(texts), time.time_ns() - latest > _RACY_NS


def has_companions(path: Path | str) -> bool:
    """Whether a clip is more than the bytes of its file: an AMC, whose skeleton lies beside it."""
    return bool(_companion(path))


def _companion(path: Path | str) -> str:
    """Return the suffix of the files that a clip needs from its folder; '' for none."""
    known = known_formats().get(Path(path).suffix.lower())
    return known.companion if known else ""


def _carried_out(task: ClipTask) -> dict[str, Any]:
    from twistcore.batch.clip_result import processed  # numpy, scipy

    with _on_this_disk(task) as path:
        before, settled = signature_of(path)
        if not path.is_file():  # to open a FIFO would wait for its writer
            raise TwistError(f"{path}: expected a file")
        try:
            clip, result, corrected = processed(path, task.parameters)
        except TwistError as error:
            path.open("rb").close()  # what cannot be opened is no matter of its content
            known: dict[str, Any] = {"reason": " ".join(str(error).splitlines())}
            known |= {"bytes": path.stat().st_size, "sha256": sha256_of(path)}
        else:
            known = {"result": result, "corrected": corrected}
            known |= {} if corrected is None else {"companions": clip.companions}
            known |= {"bytes": len(clip.data), "sha256": clip.sha256}
        same = settled and signature_of(path)[0] == before
    if same and str(path) == task.source:
        known["signature"] = before
    return known


@contextmanager
def _on_this_disk(task: ClipTask) -> Iterator[Path]:
    """The clip's file, or one with its bytes for as long as it is read."""
    data = task.data
    if data is None and "://" in task.source:
        from twistcore.batch.remote_files import read_remote

        data = read_remote(task.source)
    if data is None:
        yield Path(task.source)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder, PurePosixPath(task.name).name)
        path.write_bytes(data)
        yield path
