"""Put the user's clip aside during a lesson or an exercise, and restore it afterwards."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

from inspector.bundled import ASSETS
from inspector.language import tr
from inspector.session.document import Document
from inspector.session.keeper import PutAside
from inspector.session.open_clip import Borrowed
from inspector.session.opening import Analysed

_OVER = tr(
    "The lesson or exercise with this sample is over. Nothing was saved. Open a clip to start a "
    "review."
)


class Aside:
    """Replaces the user's own clip with a borrowed clip, and restores the user's clip later.

    A borrowed clip is a clip that a lesson or an exercise has opened. While it is open, the user's
    review stays in memory; unsaved changes are also in the journal on disk.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._kept: tuple[Analysed, PutAside | None, int, str, int | None] | None = None
        self._folder: Path | None = None
        self._shown = False

    @property
    def open(self) -> bool:
        """Return True while a borrowed clip is open or about to close."""
        return self._shown

    @property
    def own(self) -> Analysed | None:
        """The user's own clip, either open or put aside; None if there is none."""
        if self._kept is not None:
            return self._kept[0]
        return None if self._document.borrowed is not None else self._document.data

    def folder(self) -> Path:
        """Return a temporary folder for the borrowed clip and the files of its review."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="twist-inspector-"))
        return self._folder

    def show(self, data: Analysed, why: str, *, signed: bool = False) -> None:
        """Put the user's own clip aside, and open a borrowed clip.

        `why` is a sentence with the reason why the review of the borrowed clip is not saved.
        `signed` is True if decisions carry the reviewer's name.
        """
        document = self._document
        document.leaving.emit()
        if self._kept is None and (own := self.own) is not None:
            kept = replace(own, review=document.review)
            place = document.frame, document.chain, document.interval_id
            self._kept = (kept, document.keeper.put_aside(), *place)
        if document.borrowed is not None:
            document.review.mark_saved()
        self._shown = True
        document.show_clip(data, borrowed=Borrowed(self._to_keep(), why, signed))

    def _to_keep(self) -> Path:
        """Return the folder for exports of a borrowed clip.

        This is the folder of the user's own clip or, if there is none, the home folder.
        """
        own = self._kept[0].clip.path.absolute() if self._kept is not None else None
        return Path.home() if own is None or ASSETS in own.parents else own.parent

    def put_back(self) -> None:
        """Show the user's own clip again, in its previous state.

        If no clip was open before, the borrowed clip stays open, but only for viewing.
        """
        if self._folder is None:
            return
        document = self._document
        borrowed = document.borrowed if self._shown else None
        if borrowed is not None:
            document.review.mark_saved()
        kept, self._kept = self._kept, None
        if kept is not None:
            data, review, frame, chain, interval = kept
            document.show_clip(data, review)
            if chain:
                document.select_chain(chain)
            document.select_interval(interval)
            document.go_to(frame)
        elif borrowed is not None:
            document.close_clip()
            document.borrowed = replace(borrowed, why=_OVER, over=True)
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder, self._shown = None, False
