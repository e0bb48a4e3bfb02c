"""Apply the sessions in a folder to their clips, and write the results into another folder."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Collection, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path, PurePath

from twistcore.errors import FormatError, TwistError
from twistcore.export.exported_clips import find_exports_and_their_sources
from twistcore.files.atomic import write_atomically, write_missing_companion_files
from twistcore.files.document_values import parsed_json, read_bytes_limited
from twistcore.files.encoding import json_text
from twistcore.files.marks import cached_sha256
from twistcore.files.ordinary import check_no_links, path_exists, real_path
from twistcore.formats.clip import ChannelJump, create_file_patch_for_motion
from twistcore.formats.clip_files import clips_by_name
from twistcore.review.folder_sessions import read_sessions_in_folder
from twistcore.review.replay import (
    replay_session,
    uncorrected_and_moved_joint_sentences,
    unknown_error_kind_sentences,
)
from twistcore.work.frozen import dataclass

WRITTEN = "applied.jsonl"  # a file in the output folder that lists the written clips
_SCHEMA = "twistcore.applied/1"


@dataclass(frozen=True)
class SessionClip:
    """A session and its clip.

    Parameters
    ----------
    session, clip
        Paths of the session and of the clip.
    name
        The clip's path relative to the folder of the clips, with '/' as separator.
    """

    session: Path
    clip: Path
    name: str


@dataclass(frozen=True)
class Pairs:
    """The sessions of a folder, paired with their clips.

    Parameters
    ----------
    pairs
        The pairs, sorted by the clip's name.
    problems
        A sentence for each session without a clip.
    older
        Sessions that are not used because their clip has a later session.
    alone
        Clips without a session. Exports of other clips are not listed.
    """

    pairs: tuple[SessionClip, ...]
    problems: tuple[str, ...]
    older: tuple[Path, ...]
    alone: tuple[str, ...]


@dataclass(frozen=True)
class Replayed:
    """The result of applying a session to a clip.

    Parameters
    ----------
    sha256
        SHA-256 of the corrected bytes.
    new
        True if the file was written, False if it already existed with these bytes.
    applied, repairable
        Number of intervals that were applied, and of intervals that can be corrected.
    jumps
        Jumps of channels that could not be avoided.
    left, beside
        Sentences returned by :func:`twistcore.review.replay.uncorrected_and_moved_joint_sentences`.
    """

    sha256: str
    new: bool
    applied: int
    repairable: int
    jumps: tuple[ChannelJump, ...]
    left: tuple[str, ...]
    beside: tuple[str, ...]


def pair_sessions_with_clips(sessions: Path, clips: Path, output: Path) -> Pairs:
    """Pair every session in a folder and its subfolders with its clip.

    A session belongs to the clip whose name and contents match those stored in the session or, if
    there is none, to a clip with the same contents and a different name. If several clips fit, the
    one in the matching subfolder is used. An export next to its source is used only if no other
    clip fits. If a clip has several sessions, the latest is used.

    Parameters
    ----------
    sessions, clips
        The folders with the sessions and with the clips.
    output
        The folder to write into. Clips in it are ignored.

    Raises
    ------
    TwistError
        If there is no clip or no session.
    """
    there = clips_by_name(clips)
    if (inside := real_path(output)).is_relative_to(real_path(clips)):
        there = {
            n: p for n, p in there.items() if not (real_path(clips) / n).is_relative_to(inside)
        }
    exported = find_exports_and_their_sources(there.values())
    exports = {name for name, path in there.items() if path in exported}
    files = _Clips(there, exports)
    problems: list[str] = []
    found: dict[str, list[Path]] = defaultdict(list)
    for path, session in read_sessions_in_folder(sessions, below=True):
        if isinstance(session, TwistError):
            problems.append(str(session))
            continue
        own = path.relative_to(sessions).parent
        try:
            found[files.of(path, PurePath(session.clip).name, session.sha256, own)].append(path)
        except TwistError as error:
            problems.append(str(error))
    if not (found or problems):
        raise TwistError(f"{sessions}: expected a folder with sessions, but it has none")
    ordered = {name: sorted(found[name], key=_written) for name in sorted(found)}
    return Pairs(
        tuple(SessionClip(of_clip[-1], there[name], name) for name, of_clip in ordered.items()),
        tuple(problems),
        tuple(path for of_clip in ordered.values() for path in of_clip[:-1]),
        tuple(name for name in there if name not in found and name not in exports),
    )


class _Clips:
    """An index of clips by name and by contents. A file is read only when it is compared."""

    def __init__(self, paths: Mapping[str, Path], exports: Collection[str]) -> None:
        self._paths, self._exports = paths, exports
        self._named: dict[str, list[str]] = defaultdict(list)
        for name, path in paths.items():
            self._named[path.name].append(name)

    def of(self, session: Path, clip: str, sha256: str, folder: PurePath) -> str:
        """Return the relative path of the clip that belongs to a session.

        `clip` and `sha256` are the name and the hash that the session stores. `folder` is the
        subfolder of the session. Raises TwistError unless exactly one clip fits.
        """
        named = self._named.get(clip, [])
        same = [name for name in named if self._mark(name) == sha256]
        same = same or self._by_bytes.get(sha256, [])
        same = [name for name in same if name not in self._exports] or same
        matching = [name for name in same if PurePath(name).parent == folder]
        if len(matching or same) == 1:
            return (matching or same)[0]
        if same:
            raise TwistError(
                f"{session}: several clips are identical to the clip of this session: "
                f"{' and '.join(same)}; keep only one of them"
            )
        if named:
            raise TwistError(
                f"{session}: the clip of this session is missing; {' and '.join(named)} is "
                "another version (its SHA-256 differs)"
            )
        raise TwistError(f"{session}: no clip has the name {clip!r} or the same content")

    @cached_property
    def _by_bytes(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = defaultdict(list)
        for name in self._paths:
            found[self._mark(name)].append(name)
        return found

    def _mark(self, name: str) -> str:
        with suppress(OSError):
            return cached_sha256(self._paths[name])
        return ""


def write_replayed_clip(output: Path, own: Mapping[str, str], pair: SessionClip) -> Replayed:
    """Write a clip, corrected by its session, into a folder.

    The bytes are the same as those written by `apply`.

    Parameters
    ----------
    output
        The folder.
    own
        The SHA-256 of the files that this command wrote into the folder earlier, keyed by name.
    pair
        The session and the clip.

    Raises
    ------
    TwistError
        If a different file with this name exists. Other errors are those of
        :func:`twistcore.review.replay.replay_session`.
    """
    replay = replay_session(pair.session, pair.clip)
    patch = create_file_patch_for_motion(replay.clip, replay.motion)
    path = output / pair.name
    check_no_links(output, path.parent)
    mark, before = hashlib.sha256(patch.data).hexdigest(), ""
    if path_exists(path) or path.is_symlink():
        before = cached_sha256(path)
        if before not in (mark, own.get(pair.name)):
            raise TwistError(
                f"{path} was not written by this command; move the file, or choose another folder"
            )
    if before != mark:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_missing_companion_files(replay.clip.companions, path.parent)
        write_atomically(path, patch.data)
    chosen, state = replay.session.state.chosen(), replay.session.state
    left, moved = uncorrected_and_moved_joint_sentences(replay.clip, replay.chains, chosen)
    left += unknown_error_kind_sentences(replay.clip, state)
    repairable = sum(judged.counts for judged in state.intervals)
    return Replayed(mark, before != mark, len(chosen), repairable, patch.jumps, left, moved)


def read_recorded_hashes_of_exports(output: Path) -> dict[str, str]:
    """Return the SHA-256 of the files that this command wrote into a folder, keyed by name.

    Raises TwistError if the list of these files cannot be read.
    """
    path, own = output / WRITTEN, dict[str, str]()
    check_no_links(output, path)
    if not path_exists(path):
        return own
    lines = read_bytes_limited(path).decode("utf-8", errors="replace").split("\n")
    for number, line in enumerate(lines):
        entry = None
        with suppress(FormatError):  # skip an incomplete line
            entry = parsed_json(line)
        if not number and not (isinstance(entry, dict) and entry.get("schema") == _SCHEMA):
            raise FormatError(f"{path}: expected a document with schema {_SCHEMA!r}")
        if isinstance(entry, dict) and {"clip", "sha256"} <= entry.keys():
            own[str(entry["clip"])] = str(entry["sha256"])
    return own


def record_hash_of_exported_clip(output: Path, name: str, sha256: str) -> None:
    """Add a clip to the list of files that this command wrote into a folder. Raises OSError."""
    path = output / WRITTEN
    new = not path_exists(path)
    head = json_text({"schema": _SCHEMA}, indent=None)
    line = json_text({"clip": name, "sha256": sha256}, indent=None)
    with path.open("a", encoding="utf-8") as file:
        file.write(f"{head}\n{line}\n" if new else f"\n{line}\n")  # the last line may be incomplete


def _written(path: Path) -> tuple[int, Path]:
    with suppress(OSError):
        return path.stat().st_mtime_ns, path
    return 0, path
