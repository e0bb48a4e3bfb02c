"""Joint names as in the file, such as 'lradius → lhand' for the chain 'Left ForeArm'."""

from __future__ import annotations

import re

from twistcore.files.encoding import legible
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton


def joints_of(chain: Chain, skeleton: Skeleton) -> str:
    """Return the names of a chain's joints as in the file: parent → child (→ end for a limb)."""
    joints = (chain.parent, chain.child, *((chain.end,) if isinstance(chain, Limb) else ()))
    return " → ".join(legible(skeleton.names[j]) for j in joints)


def own_joints(chain: Chain, skeleton: Skeleton) -> str:
    """Return the names of a chain's joints as in the file, or '' if they match its label."""
    ours = _letters(chain.side + chain.segment) if chain.segment else _letters(chain.name)
    same = _letters(skeleton.names[chain.parent]).endswith(ours)
    return "" if same or not chain.segment else joints_of(chain, skeleton)


def _letters(name: str) -> str:
    return re.sub(r"[\W_]", "", name).casefold()
