"""Find the session files in a folder of clips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePath

from twistcore.errors import TwistError
from twistcore.files.document_values import parsed_json, read_bytes_limited
from twistcore.files.marks import cached_sha256
from twistcore.files.ordinary import is_file
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.formats.reading import companion_file_prefix
from twistcore.review import Session, read_session
from twistcore.work.frozen import dataclass

_SESSION = ".twist.json"  # the default suffix; the user may choose another name
_REPLAY = ".replay.json"  # the record of an export, whose review is also in the clip's session


@dataclass(frozen=True)
class Damaged:
    """A session file that cannot be read.

    Parameters
    ----------
    path
        The session file.
    clip
        The clip in the same folder to which the file's content or name refers, or the folder if
        there is no such clip.
    why
        The reason why the file cannot be read.
    """

    path: Path
    clip: Path
    why: str


@dataclass(frozen=True)
class FolderSessions:
    """The session files found in a folder of clips.

    Parameters
    ----------
    of
        The session file of each clip that has one, keyed by the clip's path.
    damaged
        The session files that cannot be read.
    """

    of: Mapping[Path, Path]
    damaged: tuple[Damaged, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """Return the paths of all session files, including damaged ones."""
        return (*self.of.values(), *(one.path for one in self.damaged))


def session_files_by_clip(folder: Path) -> FolderSessions:
    """Return the session file of each clip in a folder.

    If a clip has several sessions, the newest one for the clip's current content is chosen, or the
    newest of all if none is for the current content.
    """
    found: dict[Path, list[tuple[Path, str]]] = {}
    damaged: list[Damaged] = []
    for path, session in read_sessions_in_folder(folder):
        if isinstance(session, TwistError):
            damaged.append(Damaged(path, _meant_for(path) or folder, str(session)))
            continue
        clip = folder / PurePath(session.clip).name
        if is_file(clip):  # '' or '/' would give the folder
            found.setdefault(clip, []).append((path, session.sha256))
    of = {clip: _best(clip, found[clip]) for clip in sorted(found)}
    return FolderSessions(of, tuple(damaged))


def read_sessions_in_folder(
    folder: Path, *, below: bool = False
) -> Iterator[tuple[Path, Session | TwistError]]:
    """Yield each session file in a folder with its session, or with the error from reading it.

    The paths are sorted. Set `below` to True to include subfolders. Other JSON files are skipped.
    Export records are skipped, too, since the clip's session contains the same review.
    """
    for path in sorted((folder.rglob if below else folder.glob)("*.json")):
        if path.name.endswith(_REPLAY):
            continue
        try:
            yield path, read_session(path)
        except TwistError as error:
            if _meant_for(path) is not None:
                yield path, error


def _meant_for(path: Path) -> Path | None:
    """Return the clip to which a damaged session belongs, or its folder if the clip is unknown.

    The result is None if the file is not a session, since a folder of clips may also contain other
    JSON files.
    """
    document = None
    with suppress(TwistError):
        document = parsed_json(read_bytes_limited(path))
    said = document if isinstance(document, Mapping) else {}
    named = path.name.endswith(_SESSION)
    if not (named or str(said.get("schema")).startswith("twistcore.session/")):
        return None
    said_clip = path.parent / PurePath(str(said.get("clip", ""))).name
    if is_file(said_clip):
        return said_clip
    name = path.name.removesuffix(_SESSION)
    return next(
        (clip for clip in clip_paths_in_folder(path.parent) if companion_file_prefix(clip) == name),
        path.parent,
    )


def _best(clip: Path, sessions: Sequence[tuple[Path, str]]) -> Path:
    """Choose the session file to use for a clip.

    `sessions` contains pairs: a session file, and the SHA-256 of the clip content that was
    reviewed.
    """
    if len(sessions) == 1:
        return sessions[0][0]
    now = ""
    with suppress(OSError):  # reading the clip reports the error
        now = cached_sha256(clip)
    return max((sha == now, path.stat().st_mtime_ns, path) for path, sha in sessions)[-1]
