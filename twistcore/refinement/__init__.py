"""Taking twist errors out of a motion, and how everything looks afterwards."""

from twistcore.refinement.corrected import Angles, Corrected
from twistcore.twist_removal import (
    SURE_ENOUGH,
    applied_unasked,
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
    "applied_unasked",
    "carried_by_limb",
    "children_off_axis",
    "offsets_by_chain",
    "refine",
    "remove_twist",
    "stuck_joints",
]
