"""Measure the effect of using a template's bones for an AMASS file without a body.

    python -m benchmarks.amass_template FOLDER [--tilt DEG]…

Each BVH in the folder is converted to an AMASS clip with errors of protocol P0, whose limbs at rest
are rotated by DEG from those of the template, each bone in a different direction. (The limbs of a
real body are up to 8° away from the axes of a T-pose.) For each DEG, the table shows

- the number of counter-twists that are found with the body,
- the number of these that are also found, in the same frames, without the body,
- the number of other counter-twists that are found without the body, and
- how far joints of the real body move if the counter-twists are corrected about the template's
  bones.
"""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np

from tests.twistcore.amass_files import amass_arrays
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip, create_file_patch_for_motion
from twistcore.formats.npz import parse_npz
from twistcore.review import Review
from twistcore.review.replay import accepted_motion
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import exponential, normalise
from twistcore.synthesis import clip_random_generator, draw_errors, draw_targets, inject

_LIMBS = (1, 2, 4, 5, 7, 8, 16, 17, 18, 19)


def tilts(degrees: float, rng: np.random.Generator) -> np.ndarray:
    """Return random rest rotations of the joints' bones, quaternions (w, x, y, z), shape (24, 4).

    Only limbs are rotated, by `degrees`.
    """
    axes = np.zeros((24, 3))
    axes[list(_LIMBS)] = np.radians(degrees) * normalise(rng.normal(size=(len(_LIMBS), 3)))
    return exponential(axes)


def clips(motion: Motion, name: str, degrees: float) -> tuple[Clip, Clip]:
    """Return a clip with errors, read once with and once without its body."""
    rng = clip_random_generator(1, name)
    arrays = amass_arrays(motion, 24, tilt=tilts(degrees, rng))
    clean = parse_npz(packed(arrays), name)
    chains = analyse(clean).chains
    errors = draw_errors(clean.motion, draw_targets(chains, rng), rng)
    wrong = create_file_patch_for_motion(clean, inject(clean.motion, chains, errors)).data
    with np.load(io.BytesIO(wrong)) as found:
        bare = {key: value for key, value in found.items() if key != "J"}
    return parse_npz(wrong, name), parse_npz(packed(bare), name)


def packed(arrays: dict[str, np.ndarray]) -> bytes:
    """Return the bytes of an .npz file with these arrays."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def row(paths: list[Path], degrees: float) -> str:
    """Return a row of the table, for several clips with limbs rotated by `degrees`."""
    known = same = more = 0
    moved = []
    for path in paths:
        own, bare = clips(read_bvh(path).motion, path.name, degrees)
        both = [analyse(c).detect(kinds=(Kind.COUNTER_TWIST,)) for c in (own, bare)]
        found = [{(i.chain, i.start, i.stop) for i in detection} for detection in both]
        known, same = known + len(found[0]), same + len(found[0] & found[1])
        more += len(found[1] - found[0])
        review = Review.of(both[1])
        review.accept()
        corrected = accepted_motion(bare, both[1].chains_and_limbs, review.state)
        before, after = (
            forward_kinematics(own.motion.with_rotations(q))[1]
            for q in (bare.motion.rotations, corrected.rotations)
        )
        away = 1000.0 * np.linalg.norm(after - before, axis=2).max(axis=1)
        moved.append(away[away > 1e-3])
    half, most = np.percentile(np.concatenate(moved), [50.0, 95.0])
    return f"| {degrees:g}° | {known} | {same} | {more} | {half:.1f} | {most:.1f} |"


def main() -> None:
    """Measure all clips and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="only every N-th clip")
    parser.add_argument("--tilt", type=float, nargs="+", default=[0.0, 2.0, 5.0, 8.0])
    arguments = parser.parse_args()
    paths = sorted(arguments.folder.glob("*.bvh"))[:: arguments.every]
    print("| limbs off by | found with the body | of them without | others | moved, mm | 95 % |")
    print("|---|---|---|---|---|---|")
    for degrees in arguments.tilt:
        print(row(paths, degrees), flush=True)


if __name__ == "__main__":
    main()
