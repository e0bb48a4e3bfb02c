"""The actions of the Tuning menu."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtWidgets import QDockWidget, QWidget

from inspector.folder.queue import FolderQueue
from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.remembered_profiles import Performers, ProfileOffers
from inspector.tuning.tau_table import Column
from inspector.tuning.tuning_panel import TuningPanel
from inspector.widgets.building import bring_to_front
from inspector.widgets.file_dialog import ask_files, ask_save_path
from inspector.widgets.message_bar import MessageBar
from twistcore.errors import TwistError
from twistcore.files.ordinary import real_path
from twistcore.formats.reading import is_clip
from twistcore.review import LeaveOut
from twistcore.review.left_out import joined_spans
from twistcore.tuning import Profile, read_profile, write_profile

_PATTERN = tr("Profiles (*.toml);;All files (*)")


@dataclass(eq=False)
class TuningActions:
    """The actions that load, save, compare and apply profiles of τ.

    `panel` is a function that returns the panel of the tuning tab.
    """

    document: Document
    queue: FolderQueue
    bar: MessageBar
    panel: Callable[[], TuningPanel]
    performers: Performers
    dock: QDockWidget
    window: QWidget

    def load_profile(self) -> None:
        """Ask for a profile file, and use its τ."""
        ask_files(self.window, tr("Load profile"), _PATTERN, lambda p: self.load_profile_from(p[0]))

    def load_profile_from(self, path: Path) -> None:
        """Use the τ of a profile file. If the file is damaged, nothing changes."""
        if (profile := self._read(path)) is not None:
            self._take(profile, path.name)

    def _take(self, profile: Profile, name: str) -> None:
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
            return
        chains = self.document.review.state.tau
        known = [n for n in profile.tau if n in chains]
        if not known:
            message = tr(
                "Nothing was changed, because this clip has none of the chains in {name}.",
                name=name,
            )
            self.bar.show_message(message, True)
            return
        self.document.use_profile(profile)
        kept = len(chains) - len(known)
        message = (
            tr(
                "τ of {n} chains was set from {name}. The other {kept} chains keep their τ.",
                name=name,
                n=len(known),
                kept=kept,
            )
            if kept
            else tr("τ of {n} chains was set from {name}.", name=name, n=len(known))
        )
        self.bar.show_message(message, False)

    def save_profile(self) -> None:
        """Ask for a path, and write a profile with the current τ to it."""
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
            return
        if self._nothing_kept():
            return
        wanted = self.document.proposed(".toml")
        title, then = tr("Save profile"), self.save_profile_to
        ask_save_path(self.window, title, _PATTERN, then, wanted=wanted, suffix="toml")

    def _nothing_kept(self) -> bool:
        """If a lesson or an exercise owns the clip, show why τ is not saved, and return True."""
        if (borrowed := self.document.borrowed) is not None:
            self.bar.show_message(borrowed.why, False)
        return borrowed is not None

    def save_profile_to(self, path: Path) -> None:
        """Write a profile with the current τ of every chain, and its cost, to a file."""
        data = self.document.data
        if data is None:
            return
        if is_clip(path) or real_path(path) == real_path(data.clip.path):
            message = tr("{name} is a clip. Choose a file name that ends in .toml.", name=path.name)
            self.bar.show_message(message, True)
            return
        method = self.document.review.state.method
        try:
            write_profile(path, self.panel().tuned(), data.clip.name, method)
        except OSError as error:
            why = translate_core_sentence(error.strerror)
            self.bar.show_message(tr("{path} was not written ({why}).", path=path, why=why), True)
        else:
            message = tr("{name} was written. Pass it to twistcore with --profile.", name=path.name)
            self.bar.show_message(message, False)

    def compare_profiles(self) -> None:
        """Ask for one or two profile files, and compare the profiles."""
        ask_files(self.window, tr("Compare profiles"), _PATTERN, self.compare_with, several=True)

    def compare_with(self, paths: Sequence[Path]) -> None:
        """Compare one profile with the current τ, or two profiles with each other."""
        if len(paths) > 2:
            self.bar.show_message(tr("Choose one or two profiles to compare."), False)
            return
        read = [(path, self._read(path)) for path in paths]
        columns = [Column(p.name, profile) for p, profile in read if profile]
        if len(columns) == len(paths):
            self.panel().profiles.set_compared(columns)
            bring_to_front(self.dock)

    def take_profile(self) -> None:
        """Use the τ of the compared profile or, if there are two, of the second one."""
        if others := self.panel().profiles.model.others:
            column = others[-1]
            self._take(column.profile, column.name)

    def _read(self, path: Path) -> Profile | None:
        try:
            return read_profile(path)
        except TwistError as error:
            why = translate_core_sentence(error)
            self.bar.show_message(tr("{why}. Nothing was changed.", why=why), True)
            return None

    def __post_init__(self) -> None:
        """Offer saved profiles whenever a clip is opened."""
        offer = self.bar.append_offer
        self.offers = ProfileOffers(self.document, self.performers, offer, self.window)

    # -- frames left out of tuning -----------------------------------------------------------

    def leave_out_interval(self) -> None:
        """Exclude the frames of the selected interval from tuning."""
        if (judged := self.document.interval) is None:
            self.bar.show_message(
                tr("Select an interval first. Press N to go to the next one."), False
            )
        else:
            self.leave_out(judged.interval.start, judged.interval.stop)

    def leave_out_visible(self, ends: tuple[float, float]) -> None:
        """Exclude the frames between `ends` from tuning, unless this is the whole clip.

        `ends` are the first and the last frame that the plots show.
        """
        start, stop = max(math.ceil(ends[0]), 0), min(math.floor(ends[1]) + 1, self.document.frames)
        if stop - start >= self.document.frames:
            self.bar.show_message(
                tr("The plots show the whole clip. Zoom to the frames that you want to leave out."),
                False,
            )
        else:
            self.leave_out(start, stop)

    def leave_out(self, start: int, stop: int) -> None:
        """Exclude the frames [start, stop) from tuning, in one undo step.

        The excluded frames are stored in the session.
        """
        before = self.document.review.state.left_out
        wanted = joined_spans([*before, (start, stop)])
        first, last = (frame + self.document.first_frame for frame in (start, stop))
        if wanted == before:
            message = tr("Frames {first}–{last} are already left out.", first=first, last=last)
            self.bar.show_message(message, False)
        elif self.document.do(LeaveOut(wanted)):
            message = tr("Frames {first}–{last} are left out of tuning.", first=first, last=last)
            self.bar.show_message(message, False)

    def take_all_in(self) -> None:
        """Include all frames in tuning again, except blends at the ends of the clip."""
        if self.document.review.state.left_out and self.document.do(LeaveOut(())):
            self.bar.show_message(tr("All frames of the capture are used for tuning."), False)

    # -- the folder ---------------------------------------------------------------------------

    def profile_to_folder(self) -> None:
        """Analyse all clips of the open folder again with the current τ."""
        if self.document.data is None or self.queue.folder is None:
            self.bar.show_message(tr("Open a folder first (Ctrl+Shift+O)."), False)
            return
        if self._nothing_kept():
            return
        state = self.document.review.state
        clip = self.document.data.clip.name
        name = tr("from {clip}", clip=clip)
        self.queue.use_profile(Profile(dict(state.tau), state.method), name)
        self.bar.show_message(
            tr(
                "{folder} is being analysed again with the τ of {clip}. "
                "Clips with a session keep their own τ.",
                folder=self.queue.folder.name,
                clip=clip,
            ),
            False,
        )

    def automatic_folder(self) -> None:
        """Analyse all clips of the open folder again, each with its automatic τ."""
        if self.queue.folder is None:
            self.bar.show_message(tr("Open a folder first (Ctrl+Shift+O)."), False)
        elif self.queue.profile is not None:
            self.queue.use_profile(None)
