"""Process many clips, as an in-memory survey or as a batch whose results are stored on disk."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from twistcore.batch.clip_survey import ClipSurvey, survey_clip, survey_folder
    from twistcore.batch.manifest import ClipRecord, Manifest, is_batch_folder

__all__ = [
    "ClipRecord",
    "ClipSurvey",
    "Manifest",
    "is_batch_folder",
    "survey_clip",
    "survey_folder",
]

if not TYPE_CHECKING:
    # Modules are loaded on first use, since reading a manifest does not need numpy.
    _HOMES = {
        "clip_survey": "ClipSurvey survey_clip survey_folder",
        "manifest": "ClipRecord Manifest is_batch_folder",
    }

    def __getattr__(name: str) -> object:
        for module, names in _HOMES.items():
            if name in names.split():
                globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), name)
                return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
