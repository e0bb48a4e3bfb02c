"""Define protocols for injecting errors. Each varies one parameter of the paper's protocol."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from twistcore.errors import TwistError
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    twist_angle,
)
from twistcore.work.frozen import dataclass

_RICH_DELAY = 37  # frames; the delay keeps the two sides of a gait from coinciding
_RICH_SHARE = 0.5
_RICH_LIMIT = 0.2  # radians per frame
_OF_SINGLE = {"name", "text", "single", "step", "length", "delta", "clean"}


@dataclass(frozen=True)
class Protocol:
    """Parameters of the injection. The defaults are those of the paper [Choi26 §4.1].

    Parameters
    ----------
    name
        Name of the protocol, such as 'H3-4'.
    text
        A short description.
    step
        Only every `step`-th frame is kept before the injection.
    rich
        True to add motion to the less active joint of each chain before the injection.
    length
        Minimum and maximum length of an interval, frames.
    delta
        Minimum and maximum magnitude of δ, degrees.
    ramp
        Number of frames over which the offset rises and falls, inside the interval.
    low_pass
        Cut-off frequency of a zero-phase second-order Butterworth filter for the offset, Hz.
    jitter, leak
        Standard deviation of white noise on the offset and on the counter-rotation, degrees.
    stairs
        Number of equal steps by which the offset rises to δ.
    flicker
        True to apply the offset only in every other frame.
    compensated
        Fraction of δ by which the child is rotated back.
    drift
        Minimum and maximum duration over which the offset grows and decays, seconds.
    jump_out
        True for a drift that only grows and then ends with a jump.
    eased
        True for a drift along a half cosine instead of a line.
    both
        True for errors in two chains that share a joint.
    together
        Number of chains with errors in the same frames.
    border
        True if the first two intervals touch the clip's ends.
    persists
        True if errors are injected only at the clip's ends.
    clean
        True to inject nothing.
    limb
        True if the parent rotates about its limb's line instead of its bone. In half of the errors,
        at random, the limb's end rotates with it.
    carried
        True if the child rolls with its parent while the limb is bent.
    single
        Kind of an error of the child alone, 'stretch' or 'spike'. All joints below the child move.
        A stretch rotates the child about its bone, and a spike about an axis perpendicular to the
        bone.
    fill
        How the parent's twist in a gap is filled, 'held' or 'interpolated'. δ is the missing twist.
    straight
        Minimum and maximum duration over which δ rises and falls, seconds. There is an error
        wherever the limb is straight.
    """

    name: str
    text: str
    step: int = 1
    rich: bool = False
    length: tuple[int, int] = (1, 20)
    delta: tuple[float, float] = (5.0, 180.0)
    ramp: int = 0
    jitter: float = 0.0
    leak: float = 0.0
    both: bool = False
    border: bool = False
    drift: tuple[float, float] | None = None
    clean: bool = False
    limb: bool = False
    carried: bool = False
    single: str = ""
    low_pass: float = 0.0
    stairs: int = 1
    flicker: bool = False
    compensated: float = 1.0
    jump_out: bool = False
    eased: bool = False
    together: int = 1
    persists: bool = False
    fill: str = ""
    straight: tuple[float, float] | None = None


PROTOCOLS = {
    protocol.name: protocol
    for protocol in (
        Protocol("P0", "level shifts of 1-20 frames, ±5…±180° [Choi26]"),
        Protocol("H1", "30 Hz (every 4th frame)", step=4),
        Protocol("H2", "60 Hz (every 2nd frame)", step=2),
        Protocol("H3-2", "onsets ramped over 2 frames", length=(5, 20), ramp=2),
        Protocol("H3-4", "onsets ramped over 4 frames", length=(9, 20), ramp=4),
        Protocol("H4", "1° of jitter inside the interval", jitter=1.0),
        Protocol("H5", "0.5° of noise on the compensation", leak=0.5),
        Protocol("H6", "small: 2-15°", delta=(2.0, 15.0)),
        Protocol("H7", "long: 20-200 frames", length=(20, 200)),
        Protocol("H8", "errors in two chains that share a joint", both=True),
        Protocol("H9", "intervals touching the clip's ends", border=True),
        Protocol("H10", "nothing injected", clean=True),
        Protocol("H11", "slow drift over 0.5-3 s", drift=(0.5, 3.0)),
        Protocol("H12", "rich: the quiet joint moves as well", rich=True),
        *(
            Protocol(
                f"R{ramp}",
                f"onsets ramped over {ramp} frames",
                length=(2 * ramp + 1, 2 * ramp + 20),
                ramp=ramp,
            )
            for ramp in (6, 8, 12, 16)
        ),
        *(
            Protocol(
                f"F{hertz}",
                f"{low}-20 frames, the offset low-passed at {hertz} Hz",
                length=(low, 20),
                low_pass=hertz,
            )
            for hertz, low in ((15, 10), (10, 10), (6, 15))
        ),
        Protocol("D", "drifts in over 0.5 s, jumps out", drift=(0.5, 0.5), jump_out=True),
        Protocol("S", "drifts in and out over 0.5-3 s, eased", drift=(0.5, 3.0), eased=True),
        Protocol("K50", "the child turns back by half", compensated=0.5),
        Protocol("K80", "the child turns back by 80 %", compensated=0.8),
        Protocol(
            "B", "from the start, and to the end", length=(30, 200), border=True, persists=True
        ),
        Protocol("ST", "a staircase of three levels", length=(9, 30), stairs=3),
        Protocol("FL", "flickers, every other frame", length=(9, 20), flicker=True),
        Protocol("NB", "bursts of 5° noise", length=(10, 40), delta=(0.0, 0.0), jitter=5.0),
        Protocol("M5", "errors in five chains in the same frames", together=5),
        Protocol("CR", "carried rolls of 1-20 frames, ±5…±180°", carried=True),
        Protocol(
            "STR",
            "a foot or hand turned about its bone for 40-180 frames, ±90…±180°",
            length=(40, 180),
            delta=(90.0, 180.0),
            single="stretch",
        ),
        Protocol(
            "SP",
            "a foot or hand off its path for 1-3 frames, ±20…±120°",
            length=(1, 3),
            delta=(20.0, 120.0),
            single="spike",
        ),
        Protocol("GH", "gaps over which the twist is held", length=(10, 40), fill="held"),
        Protocol("GI", "gaps filled by interpolated twist", length=(10, 40), fill="interpolated"),
        Protocol(
            "SL",
            "±15…±60° wherever the limb is straight, onsets of 67-133 ms",
            delta=(15.0, 60.0),
            straight=(0.067, 0.133),
        ),
        Protocol(
            "L0",
            "limb flips of 1-20 frames, ±60…±180°, the end kept or carried",
            delta=(60.0, 180.0),
            limb=True,
        ),
        Protocol(
            "L1",
            "limb flips at 30 Hz (every 4th frame)",
            step=4,
            delta=(60.0, 180.0),
            limb=True,
        ),
    )
}


def parse_protocol(name: str) -> Protocol:
    """Return the protocol of this name, or a combination such as 'H12+H3-4'.

    Raises TwistError if a name is unknown or the protocols cannot be combined.
    """
    knobs: dict[str, Any] = {}
    texts = []
    for part in name.split("+"):
        part = "H12" if part == "rich" else part
        if part not in PROTOCOLS:
            known = ", ".join(PROTOCOLS)
            raise TwistError(
                f"unknown protocol {part!r}: choose from {known}, or combine several with '+'"
            )
        of_p0 = vars(PROTOCOLS["P0"])
        knobs |= {k: v for k, v in vars(PROTOCOLS[part]).items() if v != of_p0[k]}
        texts.append(PROTOCOLS[part].text)
    if knobs.get("limb") and (knobs.keys() & {"together", "fill", "straight"}):
        raise TwistError(
            f"protocol {name!r}: limb flips cannot be combined with errors of single bones"
        )
    if knobs.get("carried") and (knobs.keys() & {"limb", "fill", "straight", "leak"}):
        raise TwistError(
            f"protocol {name!r}: CR can be combined only with protocols that shift the "
            "twist of one chain"
        )
    if knobs.get("single") and not knobs.keys() <= _OF_SINGLE:
        raise TwistError(
            f"protocol {name!r}: errors of a single joint can be combined only with protocols that "
            "change the frame rate, the length or the angle"
        )
    if knobs.get("limb") and knobs.get("both"):
        raise TwistError(
            f"protocol {name!r}: H8 cannot be combined with limb flips, because no two "
            "limbs share a joint"
        )
    return Protocol(**{**knobs, "name": name, "text": " + ".join(texts)})


def prepare_clean_motion_for_injection(
    motion: Motion, chains: Sequence[Chain], protocol: Protocol
) -> Motion:
    """Return a clean motion after applying the options `rich` and `step` of a protocol."""
    if protocol.rich:
        motion = add_twist_from_opposite_side(motion, chains)
    if protocol.step > 1:
        motion = replace(
            motion,
            rotations=motion.rotations[:: protocol.step],
            positions=motion.positions[:: protocol.step],
            frame_time=motion.frame_time * protocol.step,
        )
    return motion


def add_twist_from_opposite_side(motion: Motion, chains: Sequence[Chain]) -> Motion:
    """Add a twist to the less active joint of every chain, for the protocol H12.

    The twist comes from the more active joint of the chain on the other side: its increments are
    halved, delayed by 37 frames, clipped to ±0.2 rad per frame, and summed. Chains without a
    counterpart on the other side do not change.
    """
    rotations = motion.rotations.copy()
    increments = {c.name: parent_and_child_twist_increments(motion, c) for c in chains}
    for chain in chains:
        own = [c for c in chains if c.person == chain.person]
        others = [c for c in own if c.segment == chain.segment and c.side != chain.side]
        if not chain.segment or not others:
            continue
        source = max(increments[others[0].name], key=lambda x: float(np.abs(x).mean()))
        delayed = np.zeros(motion.frames)
        delayed[_RICH_DELAY:] = _RICH_SHARE * source[: max(motion.frames - _RICH_DELAY, 0)]
        angle = np.cumsum(np.clip(delayed, -_RICH_LIMIT, _RICH_LIMIT))
        turn = quaternion_from_axis_angle(chain.axis, angle)
        of_parent, of_child = (float(np.abs(x).mean()) for x in increments[chain.name])
        if of_parent < of_child:
            rotations[:, chain.parent] = multiply(rotations[:, chain.parent], turn)
        else:
            rotations[:, chain.child] = multiply(turn, rotations[:, chain.child])
    return motion.with_rotations(normalise(rotations))


def parent_and_child_twist_increments(motion: Motion, chain: Chain) -> tuple[Array, Array]:
    """Return the twist increments of a chain's parent and child, radians, each (frames,).

    An increment is the rotation about the parent's bone axis since the previous frame. Both joints'
    increments are measured in the parent's coordinates and are 0 in frame 0.
    """
    q_p, q_c = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
    axis = chain.axis if chain.axis.ndim == 1 else chain.axis[1:]
    x, y = np.zeros(motion.frames), np.zeros(motion.frames)
    x[1:] = twist_angle(multiply(conjugate(q_p[:-1]), q_p[1:]), axis)
    y[1:] = twist_angle(multiply(q_c[1:], conjugate(q_c[:-1])), axis)
    return x, y
