"""The sessions that lie beside a folder's clips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePath

from twistcore.errors import TwistError
from twistcore.files.document_values import bytes_of, parsed_json
from twistcore.files.marks import file_mark
from twistcore.files.ordinary import is_file
from twistcore.formats.clip_files import clips_in
from twistcore.formats.reading import own_name
from twistcore.review import Session, read_session
from twistcore.work.frozen import dataclass

_SESSION = ".twist.json"  # as the program names them; a person may choose another name
_REPLAY = ".replay.json"  # what an export did: its review is in the clip's own session


@dataclass(frozen=True)
class Damaged:
    """A session that cannot be read, and why.

    clip: beside it, that it is of, as far as it or its name tells, else the folder.
    """

    path: Path
    clip: Path
    why: str


@dataclass(frozen=True)
class FolderSessions:
    """What was found: the session of every clip that has one, and those that cannot be read."""

    of: Mapping[Path, Path]
    damaged: tuple[Damaged, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """All of them."""
        return (*self.of.values(), *(one.path for one in self.damaged))


def sessions_in(folder: Path) -> FolderSessions:
    """Clips of a folder and the session beside each.

    Of several of a clip the latest that is of the clip as it is, else the latest.
    """
    found: dict[Path, list[tuple[Path, str]]] = {}
    damaged: list[Damaged] = []
    for path, session in read_sessions(folder):
        if isinstance(session, TwistError):
            damaged.append(Damaged(path, _meant_for(path) or folder, str(session)))
            continue
        clip = folder / PurePath(session.clip).name
        if is_file(clip):  # not the folder, by '' or '/'
            found.setdefault(clip, []).append((path, session.sha256))
    of = {clip: _best(clip, found[clip]) for clip in sorted(found)}
    return FolderSessions(of, tuple(damaged))


def read_sessions(
    folder: Path, *, below: bool = False
) -> Iterator[tuple[Path, Session | TwistError]]:
    """Every session of a folder in order of names, or why it cannot be read.

    below: those of the folders below it, too. Other documents are left out, and so is what an
    export did, whose review is in the clip's own session.
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
    """The clip that a damaged session is of, its folder where nothing tells; None: no session.

    Beside clips there are other documents, which have nothing to do with this.
    """
    document = None
    with suppress(TwistError):
        document = parsed_json(bytes_of(path))
    said = document if isinstance(document, Mapping) else {}
    named = path.name.endswith(_SESSION)
    if not (named or str(said.get("schema")).startswith("twistcore.session/")):
        return None
    said_clip = path.parent / PurePath(str(said.get("clip", ""))).name
    if is_file(said_clip):
        return said_clip
    name = path.name.removesuffix(_SESSION)
    return next((clip for clip in clips_in(path.parent) if own_name(clip) == name), path.parent)


def _best(clip: Path, sessions: Sequence[tuple[Path, str]]) -> Path:
    """Of sessions, each with the SHA-256 of the clip that it was saved for."""
    if len(sessions) == 1:
        return sessions[0][0]
    now = ""
    with suppress(OSError):  # whoever reads the clip says so
        now = file_mark(clip)
    return max((sha == now, path.stat().st_mtime_ns, path) for path, sha in sessions)[-1]
