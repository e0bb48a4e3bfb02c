"""Open scene files of other programs, which Blender converts to a BVH file in the same folder."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject

from inspector.language import tr, translate_core_sentence
from inspector.widgets.background import OneTask
from twistcore.errors import TwistError
from twistcore.formats.blender import SUFFIXES, find_blender
from twistcore.formats.reading import CLIP_PATTERNS
from twistcore.work.progress import Tell

CLIPS = CLIP_PATTERNS  # file name patterns
CLIPS_AND_SCENES = " ".join((CLIPS, *(f"*{suffix}" for suffix in SUFFIXES)))
Message = Callable[[str, bool], object]


class SceneFiles(QObject):
    """Converts scene files in the background, then opens the clips."""

    def __init__(
        self, show_message: Message, open_clip: Callable[[Path], object], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._show_message, self._open_clip = show_message, open_clip
        self._task = OneTask(self)

    def take(self, path: Path) -> bool:
        """Convert and open a file if it is a scene. Return False for any other file."""
        if path.suffix.lower() not in SUFFIXES:
            return False
        clip = path.with_suffix(".bvh")
        if clip.exists():
            self._open_clip(clip)
            text = tr(
                "{clip} is in the same folder as {scene} and was opened instead. Rename {clip} to "
                "convert the scene.",
                clip=clip.name,
                scene=path.name,
            )
            self._show_message(text, False)
            return True
        try:
            blender = find_blender()
        except TwistError as error:
            self._failed(path, error)
            return True
        text = tr("Blender is converting {scene} to {clip}.", scene=path.name, clip=clip.name)
        self._show_message(text, False)
        self._task.run(
            partial(_convert, path, clip, blender),
            partial(self._converted, clip),
            partial(self._failed, path),
        )
        return True

    def _converted(self, clip: Path, notes: tuple[str, ...]) -> None:
        self._open_clip(clip)
        text = tr("Corrections are written to a BVH file, not to the scene.")
        self._show_message(" ".join((text, *map(translate_core_sentence, notes))), False)

    def _failed(self, path: Path, error: Exception) -> None:
        why = tr(
            "{scene} was not opened: {error}", scene=path.name, error=translate_core_sentence(error)
        )
        self._show_message(why, True)


def _convert(path: Path, clip: Path, blender: str, _: Tell) -> tuple[str, ...]:
    """Convert a scene to a clip with Blender, and return the notes about the conversion."""
    from twistcore.formats.blender.scene_motion import write_as_bvh  # scipy.spatial

    return write_as_bvh(path, clip, blender)[1].notes
