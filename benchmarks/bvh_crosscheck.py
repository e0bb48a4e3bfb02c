"""Compare joint positions with pybvh: python -m benchmarks.bvh_crosscheck FOLDER…

For every file that both programs can read, the output shows the largest distance between our joints
and those of pybvh, as a share of the skeleton's height, in three cases:

- as read (expected ≤ 1e-9),
- with every rotation computed again from quaternions (≤ 1e-6), and
- with all detections of `refine` corrected (≤ 1e-9).

It also shows the largest displacement of a joint by the correction according to pybvh. The exit
status is 1 if any of the first three numbers is larger than expected.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._refined import EVERYTHING, refine_file
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.motion import forward_kinematics

MOST = (1e-9, 1e-6, 1e-9)  # expected shares of the height: as read, rewritten, corrected


def pybvh_positions(path: Path) -> NDArray[np.float64]:
    """Return the positions (frames, joints, 3) computed by pybvh, without End Sites."""
    import pybvh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        clip = pybvh.read_bvh_file(path, world_up="+y")
        positions: NDArray[np.float64] = clip.joint_positions()
    return positions


def rewritten(clip: Clip) -> bytes:
    """Return the bytes of the clip with every rotation computed again from quaternions."""
    every = np.zeros(clip.motion.rotations.shape[:2], dtype=np.bool_)
    every[:] = clip.skeleton.rotatable
    return clip.patched(clip.motion, every).data


def corrected(path: Path) -> tuple[float, float]:
    """Compare a corrected file with pybvh.

    Returns the largest distance from pybvh's joints, and the largest displacement of a joint by the
    correction according to pybvh. Both are shares of the height.
    """
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "corrected.bvh"
        refine_file(path, output, *EVERYTHING)
        clip = read_bvh(output)
        ours = forward_kinematics(clip.motion)[1]
        before, after = pybvh_positions(path), pybvh_positions(output)
    height = clip.skeleton.height
    return float(np.abs(ours - after).max()) / height, float(np.abs(after - before).max()) / height


def differences(path: Path) -> tuple[float, float]:
    """Return the largest distance from pybvh's joints as a share of the height, in two cases.

    The first is the file as read, and the second is the rewritten file.
    """
    clip = read_bvh(path)
    ours = forward_kinematics(clip.motion)[1]
    height = clip.skeleton.height
    with tempfile.TemporaryDirectory() as folder:
        again = Path(folder) / "again.bvh"
        again.write_bytes(rewritten(clip))
        theirs = pybvh_positions(path), pybvh_positions(again)
    return tuple(float(np.abs(ours - t).max()) / height for t in theirs)


def main() -> int:
    """Compare every file and print one line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    worst, count, wrong = [0.0, 0.0, 0.0], 0, 0
    for path in sorted(
        f
        for d in parser.parse_args().folders
        for f in clip_paths_in_folder(d, below=True, suffixes=BVH)
    ):
        try:
            found = (*differences(path), *corrected(path))
        except TwistError as error:
            print(f"{path.name}: we refuse it: {error}")
            continue
        except Exception as error:
            print(f"{path.name}: pybvh refuses it: {str(error).splitlines()[0][:90]}")
            continue
        count += 1
        fits = all(f <= most for f, most in zip(found, MOST, strict=False))
        wrong += not fits
        worst = [max(w, f) for w, f in zip(worst, found, strict=False)]
        read, written, after, moved = found
        note = "" if fits else "   <-- differs"
        print(f"{path.name}: {read:.1e} {written:.1e} {after:.1e}, moved {moved:.1e}{note}")
    print(
        f"{count} files compared, {wrong} differ; worst {worst[0]:.1e} read, {worst[1]:.1e} "
        f"written, {worst[2]:.1e} corrected"
    )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
