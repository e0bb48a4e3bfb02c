"""Save profiles for skeletons and performers, and offer them when a matching clip is opened."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.session_files import rename_damaged
from inspector.session.settings import settings_path
from inspector.widgets.message_bar import Answers
from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import parsed_json, read_bytes_limited
from twistcore.files.encoding import json_bytes
from twistcore.files.ordinary import path_exists, real_path
from twistcore.skeleton.rig import skeleton_hash
from twistcore.tuning import Profile, read_profile
from twistcore.tuning.learned_profile import LearnedProfile
from twistcore.tuning.verdicts_of import performer_of_clip

_PERFORMERS = 2000  # maximum number of clips for which the user has named the performer


def profile_path(mark: str, performer: str = "") -> Path:
    """Return the path at which the profile of a skeleton and a performer is saved.

    `mark` is a string that identifies the skeleton. If `performer` is '', the profile applies to
    all performers.
    """
    own = f"-{hashlib.sha256(performer.encode()).hexdigest()[:8]}" if performer else ""
    return settings_path().parent / "profiles" / f"{mark[:24]}{own}.toml"


def load_saved_profile(mark: str, performer: str = "") -> tuple[Profile | None, str]:
    """Return the saved profile of a performer or, if there is none, of the skeleton.

    Returns a tuple of the profile, or None if none is saved, and an error message, or ''. A damaged
    file is renamed.
    """
    for who in dict.fromkeys((performer, "")):
        path = profile_path(mark, who)
        if not path_exists(path):
            continue
        try:
            profile = read_profile(path)
        except FormatError as error:
            return None, rename_damaged(path, str(error))
        except TwistError as error:
            return None, str(error)
        if profile.rig == mark and profile.performer == who:  # two names may have the same path
            return profile, ""
    return None, ""


def save_learned_profile(learnt: LearnedProfile, source: str) -> Path:
    """Save a profile for its rig and performer, and return its path. Raises OSError on failure.

    `source` is the name of the folder with the sessions from which the profile was learned.
    """
    path = profile_path(learnt.profile.rig, learnt.profile.performer)
    path.parent.mkdir(parents=True, exist_ok=True)
    learnt.write(path, source)
    return path


class Performers:
    """The performers of clips, as set by the user or, by default, as read from the file names."""

    def __init__(self) -> None:
        self._path = settings_path().parent / "performers.json"
        self._named: dict[str, str] = {}
        with suppress(TwistError):
            document = parsed_json(read_bytes_limited(self._path))
            if isinstance(document, dict):
                self._named = {str(k): v for k, v in document.items() if isinstance(v, str)}

    def of(self, clip: Path) -> str:
        """Return the performer of a clip, or '' if the performer is unknown."""
        return self._named.get(str(real_path(clip)), performer_of_clip(clip.name))

    def name(self, clip: Path, performer: str) -> None:
        """Set the performer of a clip. Raises OSError if the name cannot be saved.

        A name that can also be read from the file name is not saved.
        """
        key = str(real_path(clip))
        self._named.pop(key, None)
        if performer != performer_of_clip(clip.name):
            self._named[key] = performer
        self._named = dict([*self._named.items()][-_PERFORMERS:])
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(self._path, json_bytes(self._named))


class ProfileOffers(QObject):
    """Offers the saved profile when a clip with the same skeleton is opened."""

    def __init__(
        self,
        document: Document,
        performers: Performers,
        offer: Callable[[str, Answers], None],
        parent: QObject | None = None,
    ) -> None:
        """Start watching for opened clips. `offer` shows a question with its possible answers."""
        super().__init__(parent)
        self._document, self._performers, self._offer = document, performers, offer
        self._declined: set[tuple[str, str]] = set()  # declined since the program was started
        # After the messages about the clip itself
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._offer_saved)
        document.opened.connect(self._later.start)

    def _offer_saved(self) -> None:
        """Offer the saved profile for the open clip, if there is one.

        Nothing is offered in an exercise, in a lesson or if the review has already begun.
        """
        data = self._document.data
        if data is None or data.blind or data.session is not None or self._document.borrowed:
            return
        if self._document.review.undo_text:
            return
        mark = skeleton_hash(data.motion.skeleton)
        profile, trouble = load_saved_profile(mark, self._performers.of(data.clip.path))
        if trouble:
            self._document.message.emit(translate_core_sentence(trouble), True)
        if profile is None or (mark, profile.performer) in self._declined:
            return
        own, now = profile.of(data.chains), self._document.review.state.tau
        if profile.confidence is None and all(abs(now[n] - t) < 1e-6 for n, t in own.items()):
            return  # the profile would change nothing
        n, who, c = len(own), profile.performer, profile.confidence
        text = (
            tr("There is a profile for the performer {who} with this rig:", who=who)
            if who
            else tr("There is a profile for this rig:")
        )
        if c is None:
            text += " " + tr("τ for {n} chains.", n=n)
        else:
            text += " " + tr(
                "τ for {n} chains, and a confidence learned from {verdicts} verdicts.",
                n=n,
                verdicts=c.accepted + c.rejected,
            )
        self._offer(
            text,
            (
                (tr("Use profile"), lambda: self.take(profile)),
                (tr("Not now"), lambda: self._declined.add((mark, profile.performer))),
            ),
        )

    def take(self, profile: Profile) -> None:
        """Use the τ of a profile, and its learned confidence if it has one."""
        self._document.use_profile(profile)
        self._document.use_learned(profile.confidence)
