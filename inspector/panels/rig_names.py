"""Labels of errors, and joint names as in the file, such as 'lradius → lhand'."""

from __future__ import annotations

import re

from inspector.language import translate_core_sentence
from twistcore.detection import Interval
from twistcore.detection.error_label import WHOLE_BODY, error_label
from twistcore.files.encoding import escape_control_characters
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton


def label_of(interval: Interval, chain: Chain, *, listed: bool = False) -> str:
    """Return the label of an error, such as 'Left ForeArm' or 'Whole body'.

    `chain` is the chain in which it was found. `listed` is True for a list of chains and limbs.
    """
    return translate_core_sentence(error_label(interval, chain, listed=listed))


def label_without_chain(interval: Interval) -> str:
    """Return the label of an error whose chain is not in the review."""
    of_body = interval.kind.info.whole_body
    return translate_core_sentence(WHOLE_BODY) if of_body else interval.chain


def joints_of_error(interval: Interval, chain: Chain, skeleton: Skeleton) -> str:
    """Return the names of the joints of an error's chain, or '' for an error of the whole body."""
    return "" if interval.kind.info.whole_body else chain_joint_names(chain, skeleton)


def chain_joint_names(chain: Chain, skeleton: Skeleton) -> str:
    """Return the names of a chain's joints as in the file: parent → child (→ end for a limb)."""
    joints = (chain.parent, chain.child, *((chain.end,) if isinstance(chain, Limb) else ()))
    return " → ".join(escape_control_characters(skeleton.names[j]) for j in joints)


def joint_names_unlike_label(chain: Chain, skeleton: Skeleton) -> str:
    """Return the names of a chain's joints as in the file, or '' if they match its label."""
    ours = _letters(chain.side + chain.segment) if chain.segment else _letters(chain.name)
    same = _letters(skeleton.names[chain.parent]).endswith(ours)
    return "" if same or not chain.segment else chain_joint_names(chain, skeleton)


def _letters(name: str) -> str:
    return re.sub(r"[\W_]", "", name).casefold()
