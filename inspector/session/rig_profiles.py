"""Read and write rig profiles, which contain the user's changes to the chains of a skeleton.

Each skeleton has its own file, which is read when a clip with this skeleton is opened.
"""

from __future__ import annotations

from pathlib import Path

from inspector.language import tr, translate_core_sentence
from inspector.session.session_files import rename_damaged
from inspector.session.settings import settings_path
from twistcore.errors import FormatError, TwistError
from twistcore.files.ordinary import path_exists
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rig import AS_FOUND, Rig, read_rig, skeleton_hash, write_rig


def rig_path(skeleton: Skeleton) -> Path:
    """Return the path of a skeleton's rig profile, which is stored with the settings."""
    return settings_path().parent / "rigs" / f"{skeleton_hash(skeleton)[:24]}.toml"


def load_rig_profile(motion: Motion) -> tuple[Rig, str]:
    """Return the stored rig of a motion's skeleton, and a sentence about a problem, or ''.

    Without a usable rig profile, the chains are found automatically. A damaged file is renamed.
    """
    path = rig_path(motion.skeleton)
    if not path_exists(path):
        return AS_FOUND, ""
    try:
        rig = read_rig(path)
        _fit(path, rig, motion)
    except FormatError as error:
        return AS_FOUND, rename_damaged(path, str(error))
    except TwistError as error:
        return AS_FOUND, tr(
            "The saved chains cannot be used, so the chains were found automatically. {error}.",
            error=translate_core_sentence(str(error)),
        )
    return rig, ""


def save_rig_profile(rig: Rig, skeleton: Skeleton, source: str) -> None:
    """Write the rig profile of a skeleton, or delete it if the rig has no changes.

    `source` is the name of the clip that the rig was made for. Raises OSError.
    """
    path = rig_path(skeleton)
    if not rig:
        path.unlink(missing_ok=True)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    write_rig(path, rig, skeleton, source)


def _fit(path: Path, rig: Rig, motion: Motion) -> None:
    try:
        rig.chains(motion)
    except TwistError as error:
        raise FormatError(f"{path}: {translate_core_sentence(str(error))}") from None
