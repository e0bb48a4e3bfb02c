"""Remove errors from a motion, and compute the corrected clip."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from twistcore.analysis.correction.corrected import Angles, Corrected
    from twistcore.analysis.correction.joint_repairs import JointRepairs
    from twistcore.analysis.correction.twist_removal import (
        SURE_ENOUGH,
        automatic_corrections,
        carried_by_limb,
        children_off_axis,
        offsets_by_chain,
        refine,
        remove_twist,
        stuck_joints,
    )

__all__ = [
    "SURE_ENOUGH",
    "Angles",
    "Corrected",
    "JointRepairs",
    "automatic_corrections",
    "carried_by_limb",
    "children_off_axis",
    "offsets_by_chain",
    "refine",
    "remove_twist",
    "stuck_joints",
]

if not TYPE_CHECKING:
    # Loaded on first use: clip_analysis imports twist_removal, and corrected imports clip_analysis.
    _HOMES = {
        "corrected": "Angles Corrected",
        "joint_repairs": "JointRepairs",
        "twist_removal": (
            "SURE_ENOUGH automatic_corrections carried_by_limb children_off_axis "
            "offsets_by_chain refine remove_twist stuck_joints"
        ),
    }

    def __getattr__(name: str) -> object:
        for module, names in _HOMES.items():
            if name in names.split():
                globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), name)
                return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
