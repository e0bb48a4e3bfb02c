"""Check that corrected AMC clips differ only where they should.

    python -m benchmarks.amc_round_trip FOLDER [--flip]

Every clip in the folder is corrected as `twistcore refine` does, and the output is compared with
the source word by word. Only the numbers of bones in frames that an accepted interval changes may
differ. With --flip, a limb flip of 170° about the right leg's line, including the foot, is first
injected into 12 frames, because few clips have errors that the channels of their bones can correct.
The exit status is 1 if any other word differs, or if an injected flip is not corrected.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import (
    automatic_corrections,
    joints_lacking_channels,
    refine,
    remove_twist,
)
from twistcore.detection import Interval
from twistcore.formats.amc import AmcClip, parse_amc, read_amc
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.skeleton.rotation import geodesic_angle

FLIPPED, DEGREES = 12, 170.0


def with_flip(clip: AmcClip) -> AmcClip:
    """Return a copy of the clip with an injected limb flip, written and read back."""
    analysis = analyse(clip)
    limb = next(limb for limb in analysis.limbs if limb.label == "Right leg")
    offset = np.zeros(clip.frames)
    start = clip.frames // 3
    offset[start : start + FLIPPED] = -np.radians(DEGREES)
    by_name = {limb.name: offset}
    motion = remove_twist(clip.motion, analysis.chains_and_limbs, by_name, by_name)
    return parse_amc(create_file_patch_for_motion(clip, motion).data, clip.asf, clip.path)


def words(data: bytes) -> list[tuple[int, str, bytes]]:
    """Return the words of an AMC file, each with its frame (from 0) and the first word of its line.

    In the file's head, the frame is −1.
    """
    out, frame = [], -1
    for line in data.splitlines():
        own = line.split()
        if len(own) == 1 and own[0].isdigit():
            frame = int(own[0]) - 1
        bone = own[0].decode("latin-1") if own else ""
        out += [(frame, bone, word) for word in own]
    return out


def turned(clip: AmcClip, accepted: Iterable[Interval]) -> set[tuple[int, str]]:
    """Return (frame, bone) for all rotations that the accepted intervals change."""
    chains = {c.name: c for c in analyse(clip).chains_and_limbs}
    names, out = clip.skeleton.names, set()
    for i in accepted:
        joints = chains[i.chain].changed_joints(clip.skeleton, carried=i.carried)
        out |= {(frame, names[j]) for frame in range(i.start, i.stop) for j in joints}
    return out


def main() -> int:
    """Check every clip and print one line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--flip", action="store_true")
    arguments = parser.parse_args()
    wrong = False
    for path in sorted(arguments.folder.glob("*.amc")):
        source = read_amc(path)
        clip = with_flip(source) if arguments.flip else source
        found = analyse(clip).detect()
        chains = {c.name: c for c in found.chains_and_limbs}
        applied = automatic_corrections(found)
        able = [
            i for i in applied if not joints_lacking_channels(clip.motion, chains[i.chain], [i])
        ]
        refined = refine(clip.motion, found.chains_and_limbs, applied)
        before, after = (
            words(data) for data in (clip.data, create_file_patch_for_motion(clip, refined).data)
        )
        same = len(before) == len(after)
        differ = {a[:2] for a, b in zip(before, after, strict=same) if a != b}
        others = differ - turned(clip, able)
        back = float(np.degrees(geodesic_angle(refined.rotations, source.motion.rotations).max()))
        wrong |= bool(others) or not same or (arguments.flip and len(differ) < FLIPPED)
        print(
            f"{path.stem}: {len(found)} found, {len(able)} of {len(applied)} corrected; "
            f"{len(differ)} rows of bones differ, {len(others)} of them not accepted"
            + (f"; {back:.2g}° from the source" if arguments.flip else "")
        )
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
