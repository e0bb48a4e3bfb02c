"""Clips of every format, and files of poses: read, looked at, corrected and written back."""

from __future__ import annotations

import pickle
import random
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from tests.fuzz import clip_damage as text
from tests.fuzz import poses_damage as poses
from tests.fuzz.trial import Kind
from tests.twistcore import amc_files, pose_layout_files
from tests.twistcore.amass_files import amass_arrays
from tests.twistcore.estimator_files import LAYOUTS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import Interval
from twistcore.formats.bvh import BvhClip, read_bvh, write_motion
from twistcore.formats.clip import Clip, changed_rotations, create_file_patch_for_motion
from twistcore.formats.npz import NpzClip
from twistcore.formats.npz.video_poses import VideoPoses
from twistcore.formats.reading import is_clip_without_motion, read_clip
from twistcore.formats.smpl.pose_files import PosesError
from twistcore.formats.smpl.poses_clip import read_smpl_poses_as_clip
from twistcore.formats.smpl.skeleton import find_network_joints
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle

ASSETS = Path(__file__).parents[2] / "assets"
FRAMES = {"walk_injected": (140, 200), "dance": (0, 30), "basketball": (0, 6)}
LOOKED_AT = 5
_WIDE = 0.15
_OTHERS = 0.4
_ROUNDED = 1e-5  # radians, of numbers with six decimals
_HALF = 3e-2  # of the eleven bits that float16 has
GROWTH = 512 << 20  # bytes: an archive may unpack to 32 MiB, which are looked at in several ways


# -- valid ones ------------------------------------------------------------------------------------


@cache
def _bvh(name: str) -> bytes:
    """Some frames of a sample."""
    head, motion, rows = (ASSETS / f"{name}.bvh").read_bytes().partition(b"Frame Time")
    first, *others = rows.splitlines(keepends=True)
    return head + motion + first + b"".join(others[slice(*FRAMES[name])])


@cache
def _motion() -> BvhClip:
    return read_bvh(ASSETS / "walk_injected.bvh")


@cache
def _amc(full: bool) -> tuple[bytes, bytes]:
    return amc_files.asf(full), amc_files.amc(full, frames=40)


@cache
def _amass(joints: int, own: bool) -> Mapping[str, np.ndarray]:
    return amass_arrays(_motion().motion.sliced(*FRAMES["walk_injected"]), joints, own=own)


@cache
def _estimated(layout: str) -> tuple[str, bytes]:
    """A file as an estimator writes it, and how its name ends."""
    motion = _motion().motion.sliced(0, 12)
    q = find_network_joints(motion.skeleton).reduced(motion.rotations)
    with tempfile.TemporaryDirectory() as folder:
        path = LAYOUTS[layout][0](Path(folder, "a"), q, 0.05 * motion.positions[:, 0])
        return path.suffix, path.read_bytes()


# -- damaged ones ----------------------------------------------------------------------------------


def make_bvh(rng: random.Random) -> Mapping[str, bytes]:
    data = _bvh(rng.choice([*FRAMES]))
    kinds = rng.choice((text.BVH_BYTES, text.BVH_STRUCTURE, text.BVH_STRUCTURE))
    if rng.random() < _WIDE:
        data = _widened(data, rng)
    data = text.damaged(data, rng, kinds)
    return {"a.bvh": _widened(data, rng) if rng.random() < _WIDE else data}


def _widened(data: bytes, rng: random.Random) -> bytes:
    """In UTF-16 or UTF-32, as a shell's redirect writes it, with or without a mark in front."""
    codec = rng.choice(("utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be"))
    mark = "\ufeff" if rng.random() < 0.7 else ""
    return (mark + data.decode("utf-8", "surrogateescape")).encode(codec, "surrogatepass")


def make_amc(rng: random.Random) -> Mapping[str, bytes]:
    skeleton, motion = _amc(rng.random() < 0.7)
    for _ in range(rng.randint(0, 3)):
        skeleton, motion = text.pair(skeleton, motion, rng)
    kinds = rng.choice((text.AMC_BYTES, text.AMC_STRUCTURE, (text.numbers,)))
    if (which := rng.random()) < 0.4:
        skeleton = text.damaged(skeleton, rng, kinds, most=2)
    elif which < 0.8:
        motion = text.damaged(motion, rng, kinds, most=2)
    return {"01.asf": skeleton, "01_02.amc": motion}


def make_npz(rng: random.Random) -> Mapping[str, bytes]:
    if rng.random() < _OTHERS:
        return {"a.npz": poses.archive(_other_layout(rng), rng)}
    arrays = dict(_amass(rng.choice((22, 24, 52, 55)), rng.random() < 0.5))
    return {"a.npz": poses.archive(arrays, rng)}


def _other_layout(rng: random.Random) -> dict[str, object]:
    """SMPL-X in parts, AIST++'s names, or what ROMP saw in a video."""
    motion = _motion().motion.sliced(*FRAMES["walk_injected"])
    which = rng.randrange(4)
    if which == 0:
        return pose_layout_files.aist(motion)
    if which < 3:
        words = {name: rng.random() < 0.5 for name in ("smplx", "hands", "face")}
        return pose_layout_files.stageii(motion, **words)
    others = (7,) if rng.random() < 0.3 else ()
    found = pose_layout_files.romp(motion.sliced(0, 12), tracked=rng.random() < 0.8, others=others)
    frame = rng.choice([*found["results"].values()])
    if rng.random() < 0.4:
        frame[rng.choice([*frame])] = rng.choice((None, 3, np.zeros((2, 72)), np.full(72, np.nan)))
    return {name: np.array(value, dtype=object) for name, value in found.items()}


def make_pkl(rng: random.Random) -> Mapping[str, bytes]:
    motion = _motion().motion.sliced(*FRAMES["walk_injected"])
    arrays = pose_layout_files.aist(motion, rng.choice((np.float32, np.float64, np.float16)))
    if rng.random() < _OTHERS:
        return {"a.pkl": poses.names(arrays, rng)}
    data = pickle.dumps(arrays, protocol=rng.randint(2, 5))
    damage = rng.choice((poses.damaged, poses.instructions, poses.instructions))
    return {"a.pkl": damage(data, rng) if rng.random() < 0.9 else data}


def make_poses(rng: random.Random) -> Mapping[str, bytes]:
    if rng.random() < 0.5:
        suffix, data = _estimated(rng.choice([*LAYOUTS]))
        damage = poses.instructions if suffix == ".pkl" and rng.random() < 0.5 else poses.damaged
        return {f"a{suffix}": damage(data, rng) if rng.random() < 0.8 else data}
    arrays = _amass(24, own=False)
    return {"a.pkl": poses.names({k: v for k, v in arrays.items() if k != "gender"}, rng)}


# -- what is done with them ------------------------------------------------------------------------


def follow(path: Path) -> None:
    """Read a clip, find what is wrong, take it out, and write it: only that is other then.

    What is wrong is looked for in one of LOOKED_AT, since that takes most of the time; something is
    taken out of one chain in all of them.
    """
    rng = random.Random(path.read_bytes())
    is_clip_without_motion(path)
    clip = read_clip(path)
    assert create_file_patch_for_motion(clip, clip.motion).data == clip.data
    assert all(np.isfinite(part).all() for part in forward_kinematics(clip.motion))
    found = _corrected(clip) if rng.randrange(LOOKED_AT) == 0 else clip.motion
    corrected = _turned(found, rng)
    changed = changed_rotations(clip, corrected)
    patch = create_file_patch_for_motion(clip, corrected)
    path.write_bytes(patch.data)
    again = read_clip(path, fps=1.0 / clip.frame_time)
    there, here = again.motion.rotations.copy(), clip.motion.rotations
    if isinstance(clip, NpzClip) and isinstance(clip.archive, VideoPoses):
        filled = clip.archive.filled  # between their neighbours, and not written
        there[filled], changed[filled] = here[filled], False
    assert np.array_equal(there[~changed], here[~changed])
    half = isinstance(clip, NpzClip) and any(
        clip.archive.array(part.name).dtype.itemsize == 2 for part in clip.parts
    )
    off = geodesic_angle(there[changed], corrected.rotations[changed])
    assert off.max(initial=0.0) < (_HALF if half else _ROUNDED)
    if clip.format != "bvh":
        write_motion(clip.motion, path.with_suffix(".bvh"))
        assert read_bvh(path.with_suffix(".bvh")).frames == clip.frames


def _corrected(clip: Clip):
    analysis = analyse(clip)
    found = analysis.detect()
    for name in analysis.signals:
        assert np.isfinite(analysis.signals[name].strength).all()
    wanted = automatic_corrections(found, 0.0, include_open=True)
    return refine(clip.motion, analysis.chains_and_limbs, wanted)


def _turned(motion: Motion, rng: random.Random) -> Motion:
    """With one chain or limb twisted in some frames."""
    chains = find_chains(motion)
    if not (every := [*chains, *find_limbs(motion, chains)]):
        return motion
    chain = rng.choice(every)
    start, stop = sorted(rng.randrange(motion.frames + 1) for _ in range(2))
    offset = np.full(stop - start, rng.choice((np.pi, 0.3, -2.0)))
    return refine(motion, every, [Interval(chain.name, start, stop, offset)])


def read_bvh_kind(folder: Path) -> None:
    follow(folder / "a.bvh")


def read_amc_kind(folder: Path) -> None:
    follow(folder / "01_02.amc")


def read_npz_kind(folder: Path) -> None:
    follow(folder / "a.npz")


def read_pkl_kind(folder: Path) -> None:
    path = folder / "a.pkl"
    is_clip_without_motion(path)
    if pickle_protocol(path) < 3:  # whose arrays cannot be replaced in place
        read_clip(path)
    else:
        follow(path)


def pickle_protocol(path: Path) -> int:
    """The protocol that a pickle's first bytes tell; 0 where they tell none."""
    head = path.read_bytes()[:2]
    return head[1] if head[:1] == b"\x80" and len(head) > 1 else 0


def read_poses_kind(folder: Path) -> None:
    (path,) = folder.iterdir()
    for person in (None, "0", "1"):
        try:
            clip = read_smpl_poses_as_clip(
                path, template=ASSETS / "dance.bvh", fps=25.0, person=person
            )
        except PosesError as error:
            if person == "1" or "--person" not in str(error):
                raise
        else:
            _corrected(clip)
            return


KINDS = [
    Kind("bvh", make_bvh, read_bvh_kind),
    Kind("amc", make_amc, read_amc_kind),
    Kind("npz", make_npz, read_npz_kind, growth=GROWTH),
    Kind("pkl", make_pkl, read_pkl_kind, growth=GROWTH),
    Kind("poses", make_poses, read_poses_kind, growth=GROWTH),
]
